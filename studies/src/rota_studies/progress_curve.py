"""How a search goes: the states it tells of, and the best one up to each moment."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rota.planning.progress import SearchState, rank


@dataclass(frozen=True, kw_only=True)
class ProgressPoint:
    """One state, the seconds after which it was told, and the best state until then (perhaps itself)."""

    time_s: float
    state: SearchState
    best: SearchState


def progress_curve(told: Iterable[tuple[float, SearchState]]) -> tuple[ProgressPoint, ...]:
    """The states in the order of their times (seconds), each beside the best so far; of equals the first stays."""
    points: list[ProgressPoint] = []
    for time_s, state in sorted(told, key=lambda entry: entry[0]):
        before = points[-1].best if points else state
        best = state if rank(state) < rank(before) else before
        points.append(ProgressPoint(time_s=time_s, state=state, best=best))
    return tuple(points)

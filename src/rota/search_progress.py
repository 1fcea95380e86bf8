"""How a search went: the states it told of, each with its time and with the best one until then."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rota.search_state import SearchState


@dataclass(frozen=True, kw_only=True)
class ProgressPoint:
    """One state, the seconds after which it was told, and the best state until then (perhaps itself)."""

    time_s: float
    state: SearchState
    best: SearchState


def progress_curve(told: Iterable[tuple[float, SearchState]]) -> tuple[ProgressPoint, ...]:
    """The states in the order of their times (seconds), each beside the best so far.

    What the check passed is better than what it did not, and better with fewer robots. Among the rest that is better
    which leaves less unseen and late, both as shares, and then what needs fewer robots. Of equals the first stays.
    """
    points: list[ProgressPoint] = []
    for time_s, state in sorted(told, key=lambda entry: entry[0]):
        before = points[-1].best if points else state
        best = state if _rank(state) < _rank(before) else before
        points.append(ProgressPoint(time_s=time_s, state=state, best=best))
    return tuple(points)


def _rank(state: SearchState) -> tuple[bool, float, float]:
    if state.met:
        return False, state.robots, 0.0
    return True, state.unseen_share + state.late_share, state.robots

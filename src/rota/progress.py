"""How a search goes: the states it tells of on its way, and the best one up to each moment."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

Stage = Literal["searched", "checked"]


@dataclass(frozen=True, kw_only=True)
class SearchState:
    """Where a search stands.

    stage: "searched", told by the planner of what it is working on; or "checked", told of a plan that was judged.
    robots: in it. unseen_share: how much of the asked ground is never seen, 0..1; by the planner's sample points while
    searched, by the check's area when checked. late_share: by how much the longest wait for what is seen outlasts its
    period, as a share of the period; 0 when none does. met: the check passed it.
    """

    stage: Stage
    robots: int
    unseen_share: float
    late_share: float
    met: bool = False


Watch = Callable[[SearchState], None]


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
        best = state if rank(state) < rank(before) else before
        points.append(ProgressPoint(time_s=time_s, state=state, best=best))
    return tuple(points)


def rank(state: SearchState) -> tuple[bool, float, float]:
    """The order in which ``progress_curve`` tells states apart; the best has the least."""
    if state.met:
        return False, state.robots, 0.0
    return True, state.unseen_share + state.late_share, state.robots

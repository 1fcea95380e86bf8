"""How a search goes: its share done and its time left, and the states it tells of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

LEAST_SHARE, LEAST_S = 0.04, 2.0  # before so much is done, the rate tells nothing


class SteadyProgress:
    """The share of the work that is done, which never falls, and about how long the rest takes.

    A planner tells its shares stage by stage; a stage that begins again, or ends sooner than it might, would make them
    fall or leap. time_limit_s: when the work is asked to end; None: never.
    """

    def __init__(self, time_limit_s: float | None = None) -> None:
        self.share = 0.0
        self._limit_s = time_limit_s
        self._at_s = 0.0

    def tell(self, share: float, elapsed_s: float) -> float:
        """So much was done after so many seconds; returns the largest share until now, in 0..1."""
        if share > self.share:
            self.share, self._at_s = min(share, 1.0), elapsed_s
        return self.share

    def left_s(self, elapsed_s: float) -> float | None:
        """Seconds that the rest takes at the rate until the last share; None: unknown.

        Nothing is known in the beginning, nor once the work takes longer than the rate foretold.
        """
        if self.share < LEAST_SHARE or self._at_s < LEAST_S:
            return None
        left_s = self._at_s / self.share - elapsed_s
        if self._limit_s is not None:
            left_s = min(left_s, self._limit_s - elapsed_s)
        return left_s if left_s > 0 or self.share == 1 else None


Stage = Literal["searched", "checked"]


@dataclass(frozen=True, kw_only=True)
class SearchState:
    """Where a search stands.

    stage: "searched", told by the planner of what it is working on; or "checked", told of a plan that was judged.
    robots: in it. unseen_share: how much of the asked ground is never seen, 0..1; by the planner's sample points while
    searched, by the check's area when checked. late_share: by how much the longest wait for what is seen outlasts its
    period, as a share of the period; 0 when none does. met: the check passed it. drivable: nothing
    else is wrong with it.
    """

    stage: Stage
    robots: int
    unseen_share: float
    late_share: float
    met: bool = False
    drivable: bool = True


Watch = Callable[[SearchState], None]


def rank(state: SearchState) -> tuple[bool, bool, float, float]:
    """The order of states; the best has the least.

    What the check passed is better than what it did not, and better with fewer robots. Among the rest what can be
    driven is better, then what leaves less unseen and late, both as shares, and then what needs fewer robots.
    """
    if state.met:
        return False, False, state.robots, 0.0
    return True, not state.drivable, state.unseen_share + state.late_share, state.robots

"""Other robots' clocks beside one's own: told apart by how late the promptest news of each robot are read."""

from __future__ import annotations

from rota.planners.swarm.nodes.telling import Telling

DRIFT_IN = 5000  # two clocks drift apart by no more than one second in so many


class Clocks:
    """What to add to the clocks of other robots, in nanoseconds; nothing where all are shared.

    News that a robot's clock dates b and that are read at a by one's own were told no later than a. So a - b is no less
    than what is to be added. The least of all a - b is taken, and raised by what drift may have made since. It is too
    much by no more than the promptest news are late.
    """

    def __init__(self, *, shared: bool) -> None:
        self._shared = shared
        self._added: dict[int, tuple[int, int]] = {}  # what to add, and when that was learned

    def hear(self, telling: Telling, now_ns: int) -> None:
        """Learn from a telling that is read now."""
        if not self._shared:
            least_ns = now_ns - telling.told_ns
            if telling.robot in self._added:
                added_ns, when_ns = self._added[telling.robot]
                least_ns = min(least_ns, added_ns + max(now_ns - when_ns, 0) // DRIFT_IN)
            self._added[telling.robot] = least_ns, now_ns

    def own(self, telling: Telling) -> Telling:
        """A telling of a robot that was heard, dated by one's own clock."""
        if self._shared:
            return telling
        return telling._replace(told_ns=telling.told_ns + self._added[telling.robot][0])

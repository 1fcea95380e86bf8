"""The time since a plan's start, for links to robots that live in real time."""

from __future__ import annotations

import time

from rota.files.timed_places import instant_given

DRIFT_S = 0.001  # by which the two clocks may drift apart before they are compared anew


class PlanClock:
    """Seconds since ``start_time`` (ISO 8601, named ``where`` in errors), or since ``begin`` where it is empty."""

    def __init__(self, start_time: str, where: str) -> None:
        self._start_unix_s = instant_given(start_time, where).timestamp() if start_time else None
        self._zero_s = self.steady_s()
        self._ahead_s = 0.0  # of the steady clock, against that which stamps are of

    def steady_s(self) -> float:
        """Seconds that pass evenly, since some moment."""
        return time.monotonic()

    def stamped_s(self) -> float:
        """Seconds since 1970 by the clock that robots' stamps are of: the system's."""
        return time.time()

    def begin(self) -> float:
        """Let the plan start now, unless it is given when it started; how many seconds later it starts by that."""
        before_s = self._zero_s
        past_s = 0.0 if self._start_unix_s is None else self.stamped_s() - self._start_unix_s
        self._zero_s = self.steady_s() - past_s
        return self._zero_s - before_s

    def now_s(self) -> float:
        """Seconds since the start."""
        return self.steady_s() - self._zero_s

    def of_unix_s(self, unix_s: float) -> float:
        """The same of another instant, by the clock of stamps; equal instants stay equal, and later ones later.

        The two clocks cannot be read at one instant, and the process may be put off between the two. Their difference
        is therefore kept until it is surely wrong: were it taken anew each time, two messages of one millisecond could
        seem to have come in the wrong order.
        """
        before_s, system_s, after_s = self.steady_s(), self.stamped_s(), self.steady_s()
        lowest_s, highest_s = before_s - system_s, after_s - system_s
        if not lowest_s - DRIFT_S <= self._ahead_s <= highest_s + DRIFT_S:
            self._ahead_s = (lowest_s + highest_s) / 2
        return unix_s + self._ahead_s - self._zero_s

    def unix_s(self, time_s: float) -> float:
        """The instant, by the clock of stamps, of a moment since the start."""
        return time_s - self.of_unix_s(0.0)

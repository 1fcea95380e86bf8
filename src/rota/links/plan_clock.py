"""The time since a plan's start, for links to robots that live in real time."""

from __future__ import annotations

import time

from rota.files.timed_places import instant_given


class PlanClock:
    """Seconds since ``start_time`` (ISO 8601, named ``where`` in errors), or since ``begin`` where it is empty."""

    def __init__(self, start_time: str, where: str) -> None:
        self._start_unix_s = instant_given(start_time, where).timestamp() if start_time else None
        self._zero_s = time.monotonic()

    def begin(self) -> None:
        """Let the plan start now, unless it is given when it started."""
        past_s = 0.0 if self._start_unix_s is None else time.time() - self._start_unix_s
        self._zero_s = time.monotonic() - past_s

    def now_s(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._zero_s

    def of_unix_s(self, unix_s: float) -> float:
        """The same of another instant, by the system's clock."""
        return self.now_s() + unix_s - time.time()

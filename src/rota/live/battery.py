"""How fast batteries fall, and when a robot must leave to reach home."""

from __future__ import annotations

import math
from dataclasses import dataclass

LEAST_S, LEAST_FALL = 20.0, 0.005  # how long a battery must have been heard, and how far have fallen, to tell its rate
CHARGED = 0.02  # a battery that rises by more than this was charged or changed
RESERVE = 0.1  # what must be left at home


@dataclass
class Battery:
    """One robot's battery, 0 (empty) to 1 (full); ``level`` None: it was never told.

    Its rate is the mean since it was first heard of, or since it was charged.
    """

    level: float | None = None
    _first: float = 0.0
    _first_s: float = 0.0
    _last_s: float = 0.0

    def hear(self, level: float, time_s: float) -> None:
        """What the robot said."""
        if self.level is None or level > self.level + CHARGED:
            self._first, self._first_s = level, time_s
        self.level, self._last_s = level, time_s

    @property
    def per_s(self) -> float | None:
        """What it loses in a second; None: not known yet."""
        time_s, fall = self._last_s - self._first_s, self._first - (self.level or 0.0)
        if self.level is None or time_s < LEAST_S or fall < LEAST_FALL:
            return None
        return fall / time_s

    def leaves_in_s(self, home_s: float) -> float | None:
        """Seconds until the robot must leave to be home, ``home_s`` away, with a tenth left; None: not known."""
        rate = self.per_s
        if rate is None or self.level is None or not math.isfinite(home_s):
            return None
        return (self.level - RESERVE) / rate - home_s

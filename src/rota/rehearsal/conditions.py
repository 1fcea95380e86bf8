"""Under what conditions a plan is rehearsed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rota.model.refusals import require, require_positive

MOST_HOURS = 10_000.0
MOST_RUNS = 100_000
MOST_NOISE = 0.3  # three times that is still less than a robot's speed
MOST_FAILURES_PER_HOUR = 1e4
MOST_LATE_S = 1e5


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """How long a run is, and what may go wrong in it.

    hours: that are looked at, from when all robots are on their loops by plan. failures_per_hour: of each robot, by
    chance alone. speed_noise: the standard deviation of a robot's speed as a share of it. wind_m_s: how fast the air
    moves; wind_from_deg: where it comes from, 0 north, 90 east; None: in each run from another direction.
    late_relief_s: by how much robots are late in the mean each time that they leave a charger. hands_off: nobody keeps
    robots in phase. replan: those that remain get a new plan when one has failed.

    Raises MissionError for values out of range.
    """

    hours: float = 24.0
    failures_per_hour: float = 0.0
    speed_noise: float = 0.0
    wind_m_s: float = 0.0
    wind_from_deg: float | None = None
    late_relief_s: float = 0.0
    hands_off: bool = False
    replan: bool = False

    def __post_init__(self) -> None:
        require_positive("hours", self.hours, MOST_HOURS)
        ok = 0 <= self.failures_per_hour <= MOST_FAILURES_PER_HOUR
        allowed = f"must be at least 0 and at most {MOST_FAILURES_PER_HOUR:g}"
        require(ok, "failures_per_hour", self.failures_per_hour, allowed)
        ok = 0 <= self.speed_noise <= MOST_NOISE
        require(ok, "speed_noise", self.speed_noise, f"must be at least 0 and at most {MOST_NOISE:g}")
        require(0 <= self.wind_m_s < math.inf, "wind_m_s", self.wind_m_s, "must be a number of at least 0")
        ok = self.wind_from_deg is None or abs(self.wind_from_deg) <= 360
        require(ok, "wind_from_deg", self.wind_from_deg, "must be -360 to 360")

        ok = 0 <= self.late_relief_s <= MOST_LATE_S
        require(ok, "late_relief_s", self.late_relief_s, f"must be at least 0 and at most {MOST_LATE_S:g}")

    @property
    def certain(self) -> bool:
        """Whether nothing is left to chance, so that all runs are the same."""
        blows_anywhere = self.wind_m_s > 0 and self.wind_from_deg is None
        return not (self.failures_per_hour or self.speed_noise or self.late_relief_s or blows_anywhere)

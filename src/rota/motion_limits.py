"""How fast a robot changes its speed and its direction, and what holds it up. SI units, frozen."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rota.limits import LARGEST_M
from rota.refusals import require, require_positive


@dataclass(frozen=True, kw_only=True)
class MotionLimits:
    """What a robot's mass and motors allow; None: no limit is known, so that it changes speed at once.

    vehicle: the name of the vehicle whose presets these are; None: of no vehicle. acceleration_m_s2: the greatest along
    its way. corner_acceleration_m_s2: the greatest on the curve round a corner; None: as along the way. jerk_m_s3: how
    fast the acceleration may change. corner_m: how far from a corner the robot may pass it; 0: it stops there.
    climb_m_s, descend_m_s: its vertical speeds. top_airspeed_m_s: its speed through the air, which wind_m_s, from
    wherever it may blow, takes from its speed over the ground.
    """

    vehicle: str | None = None
    acceleration_m_s2: float | None = None
    corner_acceleration_m_s2: float | None = None
    jerk_m_s3: float | None = None
    corner_m: float = 0.0
    climb_m_s: float | None = None
    descend_m_s: float | None = None
    top_airspeed_m_s: float | None = None
    wind_m_s: float = 0.0

    def __post_init__(self) -> None:
        for name in POSITIVE_OR_NONE:
            value = getattr(self, name)
            if value is not None:
                require_positive(name, value)
        require(0 <= self.corner_m <= LARGEST_M, "corner_m", self.corner_m, f"must be 0 to {LARGEST_M:g}")
        ok = 0 <= self.wind_m_s < math.inf
        require(ok, "wind_m_s", self.wind_m_s, "must be 0 or more")
        for name in ("jerk_m_s3", "corner_acceleration_m_s2"):
            ok = getattr(self, name) is None or self.acceleration_m_s2 is not None
            require(ok, name, getattr(self, name), "needs acceleration_m_s2: without one, speeds change at once")
        ok = self.corner_m == 0 or self.acceleration_m_s2 is not None
        require(ok, "corner_m", self.corner_m, "needs acceleration_m_s2: without one, corners cost nothing")
        top = self.top_airspeed_m_s
        if top is not None:
            ok = self.wind_m_s < top
            require(
                ok, "wind_m_s", self.wind_m_s, f"must be less than top_airspeed_m_s, {top:.6g}, or no leg can be flown"
            )

    @property
    def has_mass(self) -> bool:
        """Whether speeds take time to change."""
        return self.acceleration_m_s2 is not None

    def ground_speed_m_s(self, speed_m_s: float) -> float:
        """The speed over the ground, of so much asked, that it can keep wherever the wind blows from."""
        if self.top_airspeed_m_s is None:
            return speed_m_s
        return min(speed_m_s, self.top_airspeed_m_s - self.wind_m_s)


POSITIVE_OR_NONE = (
    "acceleration_m_s2",
    "corner_acceleration_m_s2",
    "jerk_m_s3",
    "climb_m_s",
    "descend_m_s",
    "top_airspeed_m_s",
)
AT_ONCE = MotionLimits()

"""How fast a robot changes its speed and its direction, and what holds it up. SI units, frozen."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rota.model.limits import LARGEST_M
from rota.model.refusals import require, require_positive, require_text


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
        if self.vehicle is not None:
            require_text("vehicle", self.vehicle)
        for name in POSITIVE_OR_NONE:
            value = getattr(self, name)
            if value is not None:
                require_positive(name, value)
        require(0 <= self.corner_m <= LARGEST_M, "corner_m", self.corner_m, f"must be 0 to {LARGEST_M:g}")
        ok = 0 <= self.wind_m_s < math.inf
        require(ok, "wind_m_s", self.wind_m_s, "must be 0 or more")
        for name, allowed in motion_faults(vars(self)):
            require(False, name, getattr(self, name), allowed)

    @property
    def has_mass(self) -> bool:
        """Whether speeds take time to change."""
        return self.acceleration_m_s2 is not None

    def ground_speed_m_s(self, speed_m_s: float) -> float:
        """The speed over the ground, of so much asked, that it can keep wherever the wind blows from."""
        if self.top_airspeed_m_s is None:
            return speed_m_s
        return min(speed_m_s, self.top_airspeed_m_s - self.wind_m_s)

    @property
    def told(self) -> dict[str, Any]:
        """Its fields and their values, without those that are at their defaults."""
        return {name: value for name, value in vars(self).items() if value != getattr(AT_ONCE, name)}


POSITIVE_OR_NONE = (
    "acceleration_m_s2",
    "corner_acceleration_m_s2",
    "jerk_m_s3",
    "climb_m_s",
    "descend_m_s",
    "top_airspeed_m_s",
)
NEED_MASS = ("jerk_m_s3", "corner_acceleration_m_s2", "corner_m")  # and without acceleration_m_s2 say nothing
MOTION_FIELDS = tuple(field.name for field in dataclasses.fields(MotionLimits))


def motion_faults(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Limits that contradict each other: the field at fault, and what is allowed. values: of each, perhaps None."""
    if values["acceleration_m_s2"] is None:
        for name in NEED_MASS:
            if values[name]:
                why = "corners cost nothing" if name == "corner_m" else "speeds change at once"
                yield name, f"needs acceleration_m_s2: without one, {why}"
    top = values["top_airspeed_m_s"]
    if top is not None and values["wind_m_s"] >= top:
        yield "wind_m_s", f"must be less than top_airspeed_m_s, {top:.6g}, or no leg can be flown"


def driving_faults(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Speed and turns that limits of motion do not allow, likewise.

    values: of speed_m_s, turn_rate_rad_s, turn_radius_m and all limits, which do not contradict each other.
    """
    top = values["top_airspeed_m_s"]
    if top is not None and values["speed_m_s"] > top - values["wind_m_s"]:
        wind = f" less wind_m_s, {values['wind_m_s']:.6g}" if values["wind_m_s"] else ""
        yield "speed_m_s", f"must be at most {top - values['wind_m_s']:.6g}: top_airspeed_m_s, {top:.6g}{wind}"
    if values["turn_rate_rad_s"] is not None and values["corner_m"] > 0:
        yield "corner_m", "must be 0 where turn_rate_rad_s is given: a robot that turns on the spot stops at corners"
    if values["turn_radius_m"] > 0 and values["acceleration_m_s2"] is not None:
        yield (
            "acceleration_m_s2",
            "does not go with turn_radius_m yet: arcs are driven at one speed; leave one out",
        )


AT_ONCE = MotionLimits()


def weakest(limits: Iterable[MotionLimits]) -> MotionLimits:
    """Limits that any robot with one of these keeps; of a vehicle where all are of that one."""
    every = list(dict.fromkeys(limits))
    if len(every) == 1:
        return every[0]
    least = {
        name: min((value for one in every if (value := getattr(one, name)) is not None), default=None)
        for name in POSITIVE_OR_NONE
    }
    corner_m = min(one.corner_m for one in every)
    return MotionLimits(corner_m=corner_m, wind_m_s=max(one.wind_m_s for one in every), **least)

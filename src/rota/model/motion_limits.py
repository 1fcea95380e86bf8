"""How fast a robot changes its speed and its direction, and what holds it up. SI units, frozen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rota.model.field_values import check_fields
from rota.model.fields import field_of, fields_of
from rota.model.limits import LARGEST_M, LENGTH_OR_ZERO, RATE
from rota.model.refusals import require, require_text


def _limit(meaning: str = "", **takes: Any) -> Any:
    """A limit that a robot need not have; a file that has none says nothing of it."""
    return field_of(None, meaning, above=0, written=RATE, newer=True, spared=True, **takes)


@dataclass(frozen=True, kw_only=True)
class MotionLimits:
    """What a robot's mass and motors allow; None: no limit is known, so that it changes speed at once."""

    vehicle: str | None = field_of(
        None,
        "presets speeds, turns and motion that are not given; without one, or with none, robots change speed at once",
        count=((1, None),),
        newer=True,
        spared=True,
    )
    acceleration_m_s2: float | None = _limit("the greatest along the way; null: speeds change at once")
    corner_acceleration_m_s2: float | None = _limit(
        "the greatest round a corner that is cut; null: as along the way", title="acceleration round corners"
    )
    jerk_m_s3: float | None = _limit("how fast the acceleration changes; null: at once")
    corner_m: float = field_of(
        0.0,
        "how far from a corner it may be passed, less than the radius of the widest circle in the free space; 0 or"
        " null: robots stop there",
        title="corners cut by",
        least=0,
        most=LARGEST_M,
        written=LENGTH_OR_ZERO,
        empty=True,
        newer=True,
        spared=True,
    )
    climb_m_s: float | None = _limit("upwards", title="climbs at")
    descend_m_s: float | None = _limit("downwards", title="descends at")
    top_airspeed_m_s: float | None = _limit(
        "the greatest through the air; speed_m_s is at most that less the wind; null: no such limit",
        title="fastest through the air",
    )
    wind_m_s: float = field_of(
        0.0, "from wherever it blows; it takes from top_airspeed_m_s", least=0, empty=True, newer=True, spared=True
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.vehicle is not None:
            require_text("vehicle", self.vehicle)
        for name, allowed in motion_faults(vars(self)):
            require(False, name, getattr(self, name), allowed)

    @property
    def has_mass(self) -> bool:
        """Whether speeds take time to change."""
        return self.acceleration_m_s2 is not None


NEED_MASS = ("jerk_m_s3", "corner_acceleration_m_s2", "corner_m")  # and without acceleration_m_s2 say nothing
MOTION_FIELDS = tuple(item.name for item in fields_of(MotionLimits))
_LIMITS = tuple(item.name for item in fields_of(MotionLimits) if item.kind == "number" and item.optional)


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
        for name in _LIMITS
    }
    corner_m = min(one.corner_m for one in every)
    return MotionLimits(corner_m=corner_m, wind_m_s=max(one.wind_m_s for one in every), **least)

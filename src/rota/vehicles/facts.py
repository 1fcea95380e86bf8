"""What is known of a vehicle, each value with where it is from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Fact:
    """A value in SI units (angles in degrees), the name that its firmware has for it, and where that is told."""

    value: float
    parameter: str
    source: str


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """A vehicle by its firmware's parameters. None: no value is known from a source, or there is no such limit.

    told: the vehicle in a sentence, "an ArduCopter by default parameters". formats: the export formats whose files it
    takes and whose motion is modelled. flies: it does not keep to the floor. acceleration_unknown: it has mass,
    and no source tells what that allows. speed_m_s: at which it drives unless told otherwise; top_speed_m_s: at most.
    turn_radius_m: at its own speed, and as the square of another. corner_m: how far from a waypoint the vehicle may
    pass. most_items, most_fence_points: what its memory holds.
    """

    name: str
    told: str
    formats: tuple[str, ...] = ()
    flies: bool = True
    acceleration_unknown: bool = False
    speed_m_s: Fact | None = None
    top_speed_m_s: Fact | None = None
    turn_rate_rad_s: Fact | None = None
    turn_radius_m: Fact | None = None
    acceleration_m_s2: Fact | None = None
    corner_acceleration_m_s2: Fact | None = None
    jerk_m_s3: Fact | None = None
    corner_m: Fact | None = None
    climb_m_s: Fact | None = None
    descend_m_s: Fact | None = None
    climb_m_s2: Fact | None = None
    top_airspeed_m_s: Fact | None = None
    lean_deg: Fact | None = None
    most_items: Fact | None = None
    most_fence_points: Fact | None = None

    def preset(self, names: Iterable[str]) -> dict[str, float]:
        """The values of those of these facts that are known, by their names.

        A vehicle whose motion is modelled has no jerk there: its firmware's is the mean of a raised cosine, which has
        up to pi / 2 times as much, and where legs blend both add up.
        """
        facts = {name: getattr(self, name, None) for name in names if name != "jerk_m_s3" or not self.formats}
        return {name: fact.value for name, fact in facts.items() if isinstance(fact, Fact)}

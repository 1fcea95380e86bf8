"""What is known of a vehicle, each value with where it is from."""

from __future__ import annotations

import math
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
    pass. climb_slowly_m_s, climb_slowly_m: how fast its take-off climbs up to which height; ramp_s: what it loses
    there as it gets up speed; arms_s: until it is off the ground. land_m_s: how fast it touches down; it descends so
    from ``land_m`` on, and in between down to there from ``slow_m`` on, ever more slowly. most_items,
    most_fence_points: what its memory holds.
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
    climb_slowly_m_s: Fact | None = None
    climb_slowly_m: Fact | None = None
    ramp_s: Fact | None = None
    arms_s: Fact | None = None
    land_m_s: Fact | None = None
    land_m: Fact | None = None
    slow_m: Fact | None = None
    top_airspeed_m_s: Fact | None = None
    lean_deg: Fact | None = None
    most_items: Fact | None = None
    most_fence_points: Fact | None = None

    def climbing_s(self, altitude_m: float) -> float:
        """Seconds from the order to take off until it is at a height; 0 where no source tells how it takes off."""
        if self.climb_m_s is None or self.arms_s is None:
            return 0.0
        slowly_m = 0.0 if self.climb_slowly_m is None else min(self.climb_slowly_m.value, altitude_m)
        slowly_s = 0.0 if self.climb_slowly_m_s is None else slowly_m / self.climb_slowly_m_s.value
        ramp_s = 0.0 if self.ramp_s is None else self.ramp_s.value
        return self.arms_s.value + ramp_s + slowly_s + (altitude_m - slowly_m) / self.climb_m_s.value

    def landing_s(self, altitude_m: float) -> float:
        """Seconds from the order to land at a height until it is on the ground; 0 where no source tells how it lands.

        Between two heights its speed changes evenly with the height, so that the time is a logarithm.
        """
        if self.descend_m_s is None or self.land_m_s is None or self.land_m is None:
            return 0.0
        fast_m_s, touch_m_s, low_m = self.descend_m_s.value, self.land_m_s.value, self.land_m.value
        high_m = low_m if self.slow_m is None else self.slow_m.value
        between_s, steps_m_s = 0.0, (fast_m_s - touch_m_s) / (high_m - low_m) if high_m > low_m else 0.0
        if altitude_m > low_m and steps_m_s != 0:
            from_m_s = touch_m_s + steps_m_s * (min(altitude_m, high_m) - low_m)
            between_s = math.log(from_m_s / touch_m_s) / steps_m_s
        return max(altitude_m - high_m, 0.0) / fast_m_s + between_s + min(altitude_m, low_m) / touch_m_s

    def preset(self, names: Iterable[str]) -> dict[str, float]:
        """The values of those of these facts that are known, by their names.

        A vehicle whose motion is modelled has no jerk there: its firmware's is the mean of a raised cosine, which has
        up to pi / 2 times as much, and where legs blend both add up.
        """
        facts = {name: getattr(self, name, None) for name in names if name != "jerk_m_s3" or not self.formats}
        return {name: fact.value for name, fact in facts.items() if isinstance(fact, Fact)}

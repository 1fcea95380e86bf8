"""What robots see with. SI units, frozen."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.limits import LARGEST_M, LENGTH
from rota.model.refusals import require


def name_field() -> Any:
    """What zones name a sensor by, declared for all of them."""
    return field_of(
        None,
        "what it is, such as thermal, for zones that name the sensors that count; null: for zones that name none",
        count=((1, None),),
        newer=True,
        spared=True,
    )


@dataclass(frozen=True, kw_only=True)
class DiscSensor:
    """Sees everything within ``radius_m`` that no obstacle hides.

    ``half_angle_deg``: a cone that looks straight down, for robots in a band of altitudes. From a height it has the
    ground in range that lies within height * tan(half angle), and never more than ``radius_m``. None: at any height
    all within ``radius_m``.
    """

    tag: ClassVar[tuple[str, str]] = ("shape", "disc")
    radius_m: float = field_of(meaning="how far it sees", above=0, most=LARGEST_M, written=LENGTH)
    half_angle_deg: float | None = field_of(
        None,
        "of a swarm with altitudes_m: the disc grows with height, height x tan, up to radius_m",
        above=0,
        below=90,
        newer=True,
        spared=True,
    )
    name: str | None = name_field()

    def __post_init__(self) -> None:
        check_fields(self, "sensor.")

    def radius_at_m(self, height_m: float) -> float:
        """Radius in metres of the disc on the ground that is in range from a height in metres."""
        if self.half_angle_deg is None:
            return self.radius_m
        return min(self.radius_m, max(height_m, 0.0) * math.tan(math.radians(self.half_angle_deg)))

    @property
    def full_height_m(self) -> float:
        """Height in metres from which on its footprint grows no more; -inf where it never does."""
        if self.half_angle_deg is None:
            return -math.inf
        return self.radius_m / math.tan(math.radians(self.half_angle_deg))

    @property
    def reach_m(self) -> float:
        """Farthest distance at which anything can be seen."""
        return self.radius_m


@dataclass(frozen=True, kw_only=True)
class SquareSensor:
    """Sees a square of ``side_m`` by ``side_m`` round the robot, along the axes of the plane whatever the heading."""

    tag: ClassVar[tuple[str, str]] = ("shape", "square")
    side_m: float = field_of(meaning="from border to border", above=0, most=LARGEST_M, written=LENGTH)
    name: str | None = name_field()

    def __post_init__(self) -> None:
        check_fields(self, "sensor.")
        require(self.side_m / 2 > 0, "sensor.side_m", self.side_m, "half of it must be greater than 0, too")

    @property
    def reach_m(self) -> float:
        """Farthest distance at which anything can be seen: half the diagonal."""
        return self.side_m / math.sqrt(2)


Sensor = DiscSensor | SquareSensor


def inner_reach_m(sensor: Sensor) -> float:
    """How far a sensor sees in every direction: a disc's radius, half a square's side."""
    return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2

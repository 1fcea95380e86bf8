"""Where robots may begin that have no start of their own. SI units, frozen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.limits import COORDINATE, LARGEST_M

Place = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class StartBox:
    """Robots start anywhere in the box between two opposite corners, (x, y) in metres; it may have no width."""

    low_m: Place = field_of(least=-LARGEST_M, most=LARGEST_M)
    high_m: Place = field_of(least=-LARGEST_M, most=LARGEST_M)

    def __post_init__(self) -> None:
        check_fields(self, "fleet.start.box.")
        (x0, y0), (x1, y1) = self.low_m, self.high_m
        object.__setattr__(self, "low_m", (float(min(x0, x1)), float(min(y0, y1))))
        object.__setattr__(self, "high_m", (float(max(x0, x1)), float(max(y0, y1))))

    @property
    def in_file(self) -> dict[str, Any]:
        """The box as files have it."""
        return {"box": [list(self.low_m), list(self.high_m)]}


@dataclass(frozen=True, kw_only=True)
class StartPoints:
    """Robots start at these points, (x, y) in metres, one at each; the planner chooses who starts where."""

    points_m: tuple[Place, ...] = field_of(least=-LARGEST_M, most=LARGEST_M, key="points")

    def __post_init__(self) -> None:
        check_fields(self, "fleet.start.")


@dataclass(frozen=True, kw_only=True)
class Start:
    """Where robots start in files: anywhere in a box, or at given points."""

    box: tuple[Place, Place] | None = field_of(
        None, "two opposite corners", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE, newer=True
    )
    points: tuple[Place, ...] | None = field_of(
        None, "one for each robot", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE, newer=True
    )

"""Lanes: lines that robots keep to, from end to end, where a mission is a graph of places and ways between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import shapely
from shapely import LineString, MultiPolygon, union_all

from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.fleet import Fleet, Place
from rota.model.limits import COORDINATE, DURATION, LARGEST_M, LENGTH, LONGEST_S
from rota.model.refusals import require

TOUCH_M = 1e-6  # a body on a lane may overlap walls and borders by this


@dataclass(frozen=True, kw_only=True)
class Lane:
    """A way between two places, straight from point to point. Robots change lanes where lanes end, nowhere else.

    Driving all of it takes ``length_m`` (None: what is drawn) at a robot's speed, and ``least_s`` at least.
    """

    line_m: tuple[Place, ...] = field_of(
        meaning="points from one end to the other, straight between them",
        count=((2, None),),
        least=-LARGEST_M,
        most=LARGEST_M,
        written=COORDINATE,
    )
    one_way: bool = field_of(False, "robots drive it from its first point to its last only")
    length_m: float | None = field_of(
        None,
        "metres that robots drive on it, where the line is a sketch; null: as drawn",
        above=0,
        most=LARGEST_M,
        written=LENGTH,
    )
    least_s: float | None = field_of(
        None, "seconds that all of it takes at least, however fast the robot is", above=0, most=LONGEST_S,
        written=DURATION,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_fields(self, "lane: ")
        for k, (a, b) in enumerate(itertools.pairwise(self.line_m)):
            require(a != b, f"lane: line_m[{k + 1}]", b, "must be another place than the one before")
        drawn_m, driven_m = self.drawn_m, self.length_m
        ok = driven_m is None or driven_m >= drawn_m * (1 - 1e-9)
        require(ok, "lane: length_m", driven_m, f"the line itself is {drawn_m:.6g} m long; no way is shorter")

    @property
    def ends_m(self) -> tuple[Place, Place]:
        """Where it begins and where it ends."""
        return self.line_m[0], self.line_m[-1]

    @property
    def drawn_m(self) -> float:
        """The length of its line."""
        return math.fsum(math.dist(a, b) for a, b in itertools.pairwise(self.line_m))

    def duration_s(self, speed_m_s: float) -> float:
        """What all of it takes a robot of this speed."""
        return max((self.length_m or self.drawn_m) / speed_m_s, self.least_s or 0.0)


def lane_faults(
    area: MultiPolygon, blocking: Sequence[MultiPolygon], fleet: Fleet, lanes: Sequence[Lane]
) -> list[tuple[str, str]]:
    """Lanes on which a body leaves the area or enters what blocks motion: the field at fault and a message."""
    if not lanes:
        return []
    body_m = max(robot.body_radius_m for robot in fleet.unlike_robots)
    ground, faults = _free(area, tuple(blocking)), []
    for k, lane in enumerate(lanes):
        line = LineString(lane.line_m)
        outside = (line.buffer(body_m - TOUCH_M) if body_m > TOUCH_M else line).difference(ground)
        if not outside.is_empty:
            x, y = shapely.get_coordinates(shapely.shortest_line(line, outside))[0]
            what = f"a body of {body_m:.6g} m does not fit" if body_m else "robots cannot be"
            faults.append((f"lanes[{k}].line_m", f"{what} at ({x:.6g}, {y:.6g}), which it passes; lead it elsewhere"))
    return faults


@lru_cache(maxsize=8)
def _free(area: MultiPolygon, blocking: tuple[MultiPolygon, ...]) -> shapely.Geometry:
    """The area without what blocks motion, and a hair more."""
    free = (area.difference(union_all(blocking)) if blocking else area).buffer(TOUCH_M)
    shapely.prepare(free)
    return free

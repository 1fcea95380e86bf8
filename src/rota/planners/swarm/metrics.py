"""What a run of the swarm comes to, step by step: coverage, contact, ways, oscillation and the time of a decision."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.model.arrays import Flags, Floats
from rota.planners.swarm.metric_kernels import Pixels, count_turns_back, least_gaps, mark_new
from rota.planners.swarm.rollout import Swarm

PIXELS_PER_SENSOR = 50  # of the smallest sensor's radius
MOST_PIXELS = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class History:
    """One value for each step, (steps + 1,), the start first.

    coverage: share of the region in range of anybody, by pixels. covered_importance: the share of its importance, which
    is the same where all ground is worth as much. deadweight_loss: the share of all footprints' area
    that covers nothing new of the region, 1 - covered / sum of them. body_gap_m, wall_gap_m: least distance between
    the rims of bodies, and of a body and a wall (inf: none is near). way_m: mean length of the robots' ways so far.
    reversals: share of the robots that turned back by more than a right angle. outside: robots that have left the
    region. decision_s: wall time for one robot. first_step, time_step_s: the first one's number, and what each takes.
    """

    coverage: Floats
    covered_importance: Floats
    deadweight_loss: Floats
    body_gap_m: Floats
    wall_gap_m: Floats
    way_m: Floats
    reversals: Floats
    outside: Floats
    decision_s: Floats
    first_step: int
    time_step_s: float

    @property
    def steps(self) -> int:
        """Steps of the run: the convergence step, where the stop rule ended it."""
        return len(self.coverage) - 1

    def csv(self) -> str:
        """A table with a row for each step, the names of the columns first; inf where nothing is near."""
        lines = [",".join(("step", "time_s", *_NAMES))]
        for k, row in enumerate(zip(*(getattr(self, name).tolist() for name in _NAMES), strict=True)):
            step = self.first_step + k
            lines.append(",".join((str(step), repr(step * self.time_step_s), *map(repr, row))))
        return "\n".join(lines) + "\n"


class Observer:
    """Measures a swarm after every step; ``history`` gives what it saw.

    region: what is to be covered. rest_m: a robot that goes no farther in a step rests, and does not turn back.
    squares: (n,) in the order of the fleet, robots whose footprint is not the disc of their sensor's radius but the
    square round it; None: none. worth: the importance at places x, y, arrays of one shape; None: all is worth as much.
    """

    def __init__(
        self,
        swarm: Swarm,
        region: MultiPolygon,
        rest_m: float,
        squares: Flags | None = None,
        worth: Callable[[Floats, Floats], Floats] | None = None,
    ) -> None:
        self._swarm, self._first_step = swarm, swarm.steps
        self._squares = np.zeros(len(swarm), np.bool_) if squares is None else squares
        self._rest_m_s = rest_m / swarm.rule.time_step_s
        x0, y0, x1, y1 = region.bounds
        sensors = swarm.kinds.sensor_m[swarm.kinds.sensor_m > 0]
        pixel = max(float(sensors.min()) / PIXELS_PER_SENSOR, math.sqrt((x1 - x0) * (y1 - y0) / MOST_PIXELS))
        columns, rows = max(int((x1 - x0) / pixel), 1), max(int((y1 - y0) / pixel), 1)
        x, y = np.meshgrid(x0 + pixel / 2 + pixel * np.arange(columns), y0 + pixel / 2 + pixel * np.arange(rows))
        shapely.prepare(region)
        self._region = region
        free = shapely.contains_xy(region, x, y).astype(np.uint8)
        weights = np.zeros((0, 0)) if worth is None else np.where(free > 0, worth(x, y), 0.0)
        self._pixels = Pixels(free, weights, np.full(free.shape, -1, np.int32), x0 + pixel / 2, y0 + pixel / 2, pixel)
        self._all_worth = float(weights.sum())
        self._free_pixels = max(int(free.sum()), 1)
        self._region_m2 = region.area
        self._before = np.zeros((2, len(swarm)))
        self._way_m = 0.0
        self._rows: list[tuple[float, ...]] = []
        self.note(0.0)

    def note(self, elapsed_s: float) -> None:
        """Measure the swarm as it is now; elapsed_s: what the step took."""
        swarm = self._swarm
        n, robots = len(swarm), swarm.robots
        count, worth = mark_new(robots, swarm.kinds, self._squares, self._pixels, swarm.steps)
        seen = count / self._free_pixels
        worth = worth / self._all_worth if self._all_worth > 0 else seen
        between, beside = least_gaps(robots, swarm.kinds, swarm.grid)
        turned = count_turns_back(robots, self._before[0], self._before[1], self._rest_m_s) / n
        self._way_m += float(np.sqrt(robots.vx**2 + robots.vy**2).mean()) * swarm.rule.time_step_s if self._rows else 0
        outside = n - int(shapely.intersects_xy(self._region, robots.x, robots.y).sum())
        footprints_m2 = float((np.where(self._squares, 4.0, math.pi) * swarm.sensors_m**2).sum())
        loss = 1 - seen * self._region_m2 / footprints_m2 if footprints_m2 > 0 else 0.0
        self._rows.append((seen, worth, loss, between, beside, self._way_m, turned, outside, elapsed_s / n))

    def history(self) -> History:
        """All that was measured."""
        return History(
            first_step=self._first_step,
            time_step_s=self._swarm.rule.time_step_s,
            **{name: values for name, values in zip(_NAMES, np.array(self._rows).T, strict=True)},
        )


_NAMES = (
    "coverage", "covered_importance", "deadweight_loss", "body_gap_m", "wall_gap_m", "way_m", "reversals", "outside",
    "decision_s",
)  # fmt: skip


def covered_share(places_m: Floats, sensors_m: Floats, region: MultiPolygon, squares: Flags | None = None) -> float:
    """Exact share of a region in range of robots at places (n, 2) with sensors (n,): radii, or half sides of squares.

    Circles are polygons of 512 corners with the circle's area. squares: (n,) which are some; None: none.
    """
    corners = 4 * 128
    as_large = math.sqrt(2 * math.pi / (corners * math.sin(2 * math.pi / corners)))
    discs = shapely.buffer(shapely.points(places_m), sensors_m * as_large, quad_segs=128)
    if squares is not None:
        x, y = places_m.T
        boxes = shapely.box(x - sensors_m, y - sensors_m, x + sensors_m, y + sensors_m)
        discs = np.where(squares, boxes, discs)
    return float(shapely.union_all(discs).intersection(region).area / region.area)

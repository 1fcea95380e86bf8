"""The places whose ages are watched: a lattice where every point is asked for, and one place for each visit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from rota.check import tiling_kernels
from rota.check.arrays import Binned, Grid
from rota.check.demands import DemandedGround, demands_of
from rota.check.seeable import seeable
from rota.check.standing import standing_areas
from rota.model.arrays import Floats, Ints
from rota.model.mission import Mission, inner_reach_m

PLACES_PER_REACH = 8  # lattice steps along a sensor's reach
FEWEST_ALONG = 6  # lattice steps along the side of a square as large as the region
MOST_PLACES = 200_000
BINS_PER_REACH = 4
MOST_BINS = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """Places (n, 2) in metres, by demand; the last ones stand for demands to visit, one each.

    demands: what is asked, empty ground left out. demand: (n,) index of each place's demand. spacings_m: (demands,)
    between neighbours, nan for visits. excluded: (demands,) how many lattice points nobody can see; they are no places.
    """

    points_m: Floats
    demand: Ints
    demands: tuple[DemandedGround, ...]
    spacings_m: Floats
    excluded: Ints

    @property
    def points(self) -> int:
        """How many places are points; those after them stand for visits."""
        return len(self.points_m) - sum(demand.demand == "visit" for demand in self.demands)

    @cached_property
    def periods_s(self) -> Floats:
        """(n,) period asked of each place."""
        periods = np.array([demand.period_s for demand in self.demands], np.float64)
        return np.ascontiguousarray(periods[self.demand])


def places_of(mission: Mission, most: int = MOST_PLACES) -> Places:
    """The places of a mission.

    Lattice points lie ``reach / 8`` apart, reach being how far the weakest sensor sees in every direction, or closer
    in a small region, which has some 36 at least, and farther apart only where there would be more than ``most``.
    Each polygon of a region has one at least. What nobody whose sensor counts can see from where a body can stand is
    left out.
    """
    demands = tuple(demand for demand in demands_of(mission) if not demand.region.is_empty)
    fleet = mission.fleet
    robots = fleet.unlike_robots
    step_m = min(inner_reach_m(robot.sensor) for robot in robots) / PLACES_PER_REACH
    asked_m2 = sum(demand.region.area for demand in demands if demand.demand == "every_point")
    step_m = max(step_m, math.sqrt(asked_m2 / most))
    points, owner = [np.empty((0, 2))], [np.empty(0, np.int64)]
    spacings, excluded = np.full(len(demands), np.nan), np.zeros(len(demands), np.int64)
    for k, demand in enumerate(demands):
        if demand.demand == "visit":
            continue
        spacings[k] = min(step_m, math.sqrt(demand.region.area) / FEWEST_ALONG)
        inside = _lattice(demand.region, float(spacings[k]))
        seen = seeable(mission, standing_areas(mission, demand.sensors), inside)
        excluded[k] = np.count_nonzero(~seen)
        points.append(inside[seen])
        owner.append(np.full(len(points[-1]), k, np.int64))
    for k, demand in enumerate(demands):
        if demand.demand == "visit":
            points.append(shapely.get_coordinates(shapely.point_on_surface(demand.region)))
            owner.append(np.array([k], np.int64))
    return Places(
        points_m=np.ascontiguousarray(np.vstack(points)),
        demand=np.concatenate(owner),
        demands=demands,
        spacings_m=spacings,
        excluded=excluded,
    )


def _lattice(region: Any, step_m: float) -> Floats:
    """Points (n, 2) of a square lattice inside a region, and one inside each of its polygons that holds none."""
    x0, y0, x1, y1 = region.bounds
    columns, rows = (max(1, math.ceil((high - low) / step_m)) for low, high in ((x0, x1), (y0, y1)))
    x, y = np.meshgrid(
        (x0 + x1) / 2 + step_m * (np.arange(columns) - (columns - 1) / 2),
        (y0 + y1) / 2 + step_m * (np.arange(rows) - (rows - 1) / 2),
    )
    shapely.prepare(region)
    inside = shapely.contains_xy(region, x, y)
    found = np.column_stack([x[inside], y[inside]])
    polygons = shapely.get_parts(region)
    empty = ~shapely.intersects(polygons, shapely.multipoints(found)) if len(found) else np.ones(len(polygons), bool)
    return np.vstack([found, shapely.get_coordinates(shapely.point_on_surface(polygons[empty])).reshape(-1, 2)])


def sort_in_bins(points_m: Floats, reach_m: float) -> tuple[Grid, Binned]:
    """Points (n, 2) sorted into the cells of a grid, so that those near a robot are found."""
    low = points_m.min(axis=0) if len(points_m) else np.zeros(2)
    wide, high = (points_m.max(axis=0) - low) if len(points_m) else np.zeros(2)
    size = max(reach_m / BINS_PER_REACH, math.sqrt(wide * high / MOST_BINS), max(wide, high) / MOST_BINS)
    grid = Grid(float(low[0]), float(low[1]), size, int(wide / size) + 1, int(high / size) + 1)
    return grid, tiling_kernels.rasterise(np.ascontiguousarray(np.hstack([points_m, points_m])), 0.0, grid)

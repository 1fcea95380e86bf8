"""What ground is worth all over a mission's area, from its map of importance or a number, and from its zones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.ndimage import distance_transform_edt
from shapely import MultiPolygon

from rota.model.arrays import Floats
from rota.model.importance import ImportanceMap
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.model.polygons import polygons_of
from rota.model.refusals import require
from rota.planning.plan_summary import range_at_the_end

SAMPLES = 3  # along each side of a cell: how finely the borders of zones are told
MOST_CELLS = 2**18
SAME = 1e-9  # relative: of importance between the places of a map by rounding
CELLS_PER_REACH = 32  # of the shortest sensor, for what is in range


@dataclass(frozen=True, kw_only=True, eq=False)
class ImportanceCells:
    """Importance of square cells over a ground, (rows, columns), the southern row first.

    values: per square metre, the mean over the ground of a cell, and outside the ground that of the nearest cell with
    some. ground_m2: how much ground a cell has. low_m: (x, y) of the first cell's middle; side_m: of a cell.
    """

    values: Floats
    ground_m2: Floats
    low_m: tuple[float, float]
    side_m: float

    def scale(self, factor: float) -> ImportanceCells:
        """The same ground, worth so many times as much."""
        return replace(self, values=factor * self.values)


def states_importance(mission: Mission) -> bool:
    """Whether a mission says what any ground is worth."""
    return mission.importance is not None or any(zone.importance is not None for zone in mission.zones)


def importance_at(mission: Mission, x: Floats, y: Floats) -> Floats:
    """What a square metre is worth at places, arrays of one shape in metres.

    The map's or else the number for the ground holds where no zone has an importance (None: 1); among overlapping
    zones the largest rules.
    """
    base, of_zones = mission.importance, np.full(x.shape, -1.0)
    ground = base.at(x, y) if isinstance(base, ImportanceMap) else np.full(x.shape, 1.0 if base is None else base)
    for zone in mission.zones:
        if zone.importance is not None:
            shapely.prepare(zone.shape)
            inside = shapely.contains_xy(zone.shape, x, y)
            of_zones = np.where(inside, np.maximum(of_zones, zone.importance), of_zones)
    return np.where(of_zones >= 0, of_zones, ground)


def importance_in_range(plan: Plan) -> float | None:
    """The share of the ground's importance that robots have in range in the end; None where all is worth as much."""
    in_range, free, _ = range_at_the_end(plan)
    reaches_m = [robot.sensor.reach_m for robot in plan.mission.fleet.robots or ()]
    cells = importance_cells(plan.mission, polygons_of(free), min(reaches_m, default=1.0) / CELLS_PER_REACH)
    if cells is None:
        return None
    rows, columns = np.nonzero(cells.ground_m2 > 0)
    worth = (cells.values * cells.ground_m2)[rows, columns]
    shapely.prepare(in_range)
    x, y = cells.low_m[0] + cells.side_m * columns, cells.low_m[1] + cells.side_m * rows
    return float(worth[shapely.contains_xy(in_range, x, y)].sum() / worth.sum())


def importance_cells(mission: Mission, ground: MultiPolygon, side_m: float) -> ImportanceCells | None:
    """A mission's importance over a ground by cells of this side; None where all of it is worth the same.

    Cells are wider where there would be more than ``MOST_CELLS``. Raises MissionError where none is worth anything.
    """
    if not states_importance(mission):
        return None
    x0, y0, x1, y1 = ground.bounds
    side_m = max(side_m, float(np.sqrt((x1 - x0) * (y1 - y0) / MOST_CELLS)), max(x1 - x0, y1 - y0) / MOST_CELLS)
    columns, rows = (max(int(np.ceil(extent / side_m)), 1) for extent in (x1 - x0, y1 - y0))
    fine_m = side_m / SAMPLES
    xs, ys = (low + fine_m * (np.arange(SAMPLES * count) + 0.5) for low, count in ((x0, columns), (y0, rows)))
    x, y = np.meshgrid(xs, ys)
    fine = importance_at(mission, x, y)
    shapely.prepare(ground)
    inside = shapely.contains_xy(ground, x, y)
    told = fine[inside]
    require(len(told) == 0 or told.max() > 0, "importance", 0.0, "some ground must be worth more than 0")
    if len(told) == 0 or told.max() - told.min() <= SAME * told.max():
        return None
    shape = (rows, SAMPLES, columns, SAMPLES)
    counted = inside.reshape(shape).sum(axis=(1, 3))
    values = np.where(inside, fine, 0.0).reshape(shape).sum(axis=(1, 3)) / np.maximum(counted, 1)
    nearest = distance_transform_edt(counted == 0, return_distances=False, return_indices=True)
    return ImportanceCells(
        values=values[tuple(nearest)],
        ground_m2=counted * fine_m**2,
        low_m=(x0 + side_m / 2, y0 + side_m / 2),
        side_m=side_m,
    )

"""The ground as a grid of cells: which of it is looked at, and the period asked of each cell."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Mission

MAX_CELLS_ALONG = 1600


@dataclass(frozen=True, kw_only=True)
class CellMap:
    """Square cells over the area's bounding box, judged at their centres.

    x_m: (columns,), y_m: (rows,) centres in metres, both increasing; period_s: (rows, columns), nan where nothing is
    asked of every point; inside: (rows, columns), in the area and in no obstacle that cuts sight; visit: (rows,
    columns), in a zone that asks for visits and in none that asks for every point.
    """

    x_m: Floats
    y_m: Floats
    cell_m: float
    period_s: Floats
    inside: Flags
    visit: Flags

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """Left, right, bottom, top of the outer cell edges in metres."""
        half = self.cell_m / 2
        return self.x_m[0] - half, self.x_m[-1] + half, self.y_m[0] - half, self.y_m[-1] + half

    @property
    def asked(self) -> Flags:
        """(rows, columns): cells of which a period is asked."""
        return np.isfinite(self.period_s)

    def points_m(self, mask: Flags) -> Floats:
        """(n, 2) centres in metres of the cells in ``mask``, row by row."""
        rows, columns = np.nonzero(mask)
        return np.column_stack([self.x_m[columns], self.y_m[rows]])


def neighbours(cell_map: CellMap) -> Ints:
    """For each cell (rows, columns) the flat index of the cell whose value to show there: its own, where it is inside.

    A cell whose centre lies in a wall or just outside may still reach inside; it shows what a neighbour shows.
    """
    rows, columns = cell_map.inside.shape
    own = np.arange(rows * columns).reshape(rows, columns)
    shown = np.where(cell_map.inside, own, -1)
    padded = np.pad(shown, 1, constant_values=-1)
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        beside = padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns]
        shown = np.where(shown < 0, beside, shown)
    return np.where(shown < 0, own, shown)


def _within(shape: MultiPolygon, x_m: Floats, y_m: Floats) -> Flags:
    """(rows, columns): centres inside ``shape``; only those in its bounding box are tried."""
    mask = np.zeros((len(y_m), len(x_m)), dtype=bool)
    left, bottom, right, top = shape.bounds
    columns = slice(*np.searchsorted(x_m, [left, right]))
    rows = slice(*np.searchsorted(y_m, [bottom, top]))
    shapely.prepare(shape)
    mask[rows, columns] = shapely.contains_xy(shape, *np.meshgrid(x_m[columns], y_m[rows]))
    return mask


def cell_map_of(mission: Mission, cells: int = 200_000) -> CellMap:
    """The ground of a mission in about ``cells`` cells over its bounding box, at most 1600 along one side.

    A zone's period replaces the area's, also by nothing; among overlapping zones the smallest rules. Under obstacles
    that ask nothing, nothing is asked.
    """
    left, bottom, right, top = mission.area.bounds
    width_m, height_m = right - left, top - bottom
    cell_m = max(math.sqrt(width_m * height_m / cells), max(width_m, height_m) / MAX_CELLS_ALONG)
    # up to the far border, but not a column more because of rounding
    columns, rows = (max(1, math.ceil(side_m / cell_m - 1e-6)) for side_m in (width_m, height_m))
    x_m = (left + right) / 2 + cell_m * (np.arange(columns) - (columns - 1) / 2)
    y_m = (bottom + top) / 2 + cell_m * (np.arange(rows) - (rows - 1) / 2)
    inside = _within(mission.area, x_m, y_m)
    for obstacle in mission.obstacles:
        if obstacle.blocks_sight:
            inside &= ~_within(obstacle.shape, x_m, y_m)
    zoned, visit, smallest_s = np.zeros_like(inside), np.zeros_like(inside), np.full(inside.shape, np.inf)
    for zone in mission.zones:
        here = _within(zone.shape, x_m, y_m)
        zoned |= here
        if zone.demand == "visit":
            visit |= here
        elif zone.period_s is not None:
            np.minimum(smallest_s, zone.period_s, out=smallest_s, where=here)
    rest_s = np.nan if mission.period_s is None else mission.period_s
    period_s = np.where(np.isfinite(smallest_s), smallest_s, np.where(zoned, np.nan, rest_s))
    for obstacle in mission.obstacles:
        if obstacle.asks == "nothing":
            period_s[_within(obstacle.shape, x_m, y_m)] = np.nan
    return CellMap(
        x_m=x_m,
        y_m=y_m,
        cell_m=cell_m,
        period_s=np.where(inside, period_s, np.nan),
        inside=inside,
        visit=visit & inside & ~np.isfinite(smallest_s),
    )

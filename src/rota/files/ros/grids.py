"""Grids of the ground as nav_msgs/OccupancyGrid: free space, and values from 0 to 100."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.model.mission import Mission
from rota.model.plan import Floats

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
WITHIN = 1e-6  # of a cell: what only touches its border is not in it

ROUNDING = 1e-9
USUAL_CELLS_M = [digit * ten for ten in (0.01, 0.1, 1.0, 10.0, 100.0, 1000.0, 1e4) for digit in (1, 2, 5)][2:]
MOST_CELLS = 1_000_000  # of the map: a megabyte


@dataclass(frozen=True, kw_only=True)
class GroundGrid:
    """Square cells of ``cell_m``: x_m (columns,), y_m (rows,) their centres, rising; values (rows, columns), int8."""

    x_m: Floats
    y_m: Floats
    cell_m: float
    values: NDArray[np.int8]

    @property
    def corner_m(self) -> tuple[float, float]:
        """x, y of the lower left corner."""
        return float(self.x_m[0]) - self.cell_m / 2, float(self.y_m[0]) - self.cell_m / 2


def usual_cells(mission: Mission) -> tuple[Floats, Floats, float]:
    """Cells over the area's bounding box, from its lower left corner: centres x_m (columns,), y_m (rows,), and a side.

    Sides are those that robots' maps have: 5 cm, or the next of 0.1, 0.2, 0.5, 1 m and so on with which there are no
    more than ``MOST_CELLS``.
    """
    left, bottom, right, top = mission.area.bounds
    for cell_m in USUAL_CELLS_M:
        columns, rows = (max(1, math.ceil(side_m / cell_m - WITHIN)) for side_m in (right - left, top - bottom))
        if columns * rows <= MOST_CELLS:
            break
    return left + cell_m * (np.arange(columns) + 0.5), bottom + cell_m * (np.arange(rows) + 0.5), cell_m


def free_space(mission: Mission, x_m: Floats, y_m: Floats, cell_m: float) -> GroundGrid:
    """Where robots may drive: 0, 100 in cells that an obstacle to motion reaches into, -1 outside the area.

    A cell lies in the area where its centre does. Bodies are not counted in: who plans on the grid widens obstacles.
    """
    centres_x, centres_y = np.meshgrid(x_m, y_m)
    shapely.prepare(mission.area)
    values = np.where(shapely.contains_xy(mission.area, centres_x, centres_y), FREE, UNKNOWN).astype(np.int8)
    half_m = cell_m / 2 * (1 - WITHIN)
    for obstacle in mission.obstacles:
        if obstacle.blocks_motion:
            left, bottom, right, top = obstacle.shape.bounds
            columns = slice(*np.searchsorted(x_m, [left - half_m, right + half_m]))
            rows = slice(*np.searchsorted(y_m, [bottom - half_m, top + half_m]))
            x, y = centres_x[rows, columns], centres_y[rows, columns]
            shapely.prepare(obstacle.shape)
            met = shapely.intersects(obstacle.shape, shapely.box(x - half_m, y - half_m, x + half_m, y + half_m))
            window = values[rows, columns]
            window[met & (window == FREE)] = OCCUPIED
    return GroundGrid(x_m=x_m, y_m=y_m, cell_m=cell_m, values=values)


def percent_of_period(periods: Floats) -> NDArray[np.int8]:
    """Whole percents of the period, rounded down, of times in periods (any shape).

    100: the period or more, or not seen at all (inf); -1: nothing is asked (nan).
    """
    with np.errstate(invalid="ignore"):
        percents = np.floor(100 * np.minimum(periods, 1.0) + ROUNDING)
    return np.where(np.isnan(periods), UNKNOWN, percents).astype(np.int8)

"""Grids of the ground as nav_msgs/OccupancyGrid: free space, and values from 0 to 100."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.model.mission import Mission
from rota.model.plan import Floats

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
WITHIN = 1e-6  # of a cell: what only touches its border is not in it

ROUNDING = 1e-9


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

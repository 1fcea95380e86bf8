"""What lies round a place, of ground with very many corners: to look at all of it for each view takes most of the time.

Views are cut by the space and hidden by walls that lie no farther off than they reach. Both are kept for square cells,
so that neighbours share them.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.line_of_sight import visibility_polygon
from rota.geometry.tiles import Box, grown_box
from rota.model.arrays import Floats
from rota.planners.patrol.tolerances import OUT_OF_REACH

MANY_WALLS = 500  # with fewer, all of the ground is looked at, drawn finer and measured round


class Surroundings:
    """The parts of a space and of walls (k, 4) that matter to what is seen within ``reach_m`` of a place."""

    def __init__(self, space: MultiPolygon, walls: Floats, reach_m: float) -> None:
        self.space, self.walls, self.reach_m = space, walls, reach_m
        self._cells: dict[tuple[int, int], tuple[BaseGeometry, Floats]] = {}

    def at(self, point_m: Floats) -> tuple[BaseGeometry, Floats]:
        """The part of the space within reach of the point (2,), and the walls at any height that it sees.

        Walls to the left and to the right at such a height tell whether a point lies inside of an obstacle.
        """
        if len(self.walls) < MANY_WALLS:
            return self.space, self.walls
        i, j = (int(v) for v in np.floor(point_m / self.reach_m))
        found = self._cells.get((i, j))
        if found is None:
            cell = (i * self.reach_m, j * self.reach_m, (i + 1) * self.reach_m, (j + 1) * self.reach_m)
            found = self._cells[i, j] = self._within(grown_box(cell, OUT_OF_REACH * self.reach_m))
        return found

    def _within(self, box: Box) -> tuple[BaseGeometry, Floats]:
        low, high = np.minimum(self.walls[:, 1], self.walls[:, 3]), np.maximum(self.walls[:, 1], self.walls[:, 3])
        beside = self.walls[(low <= box[3]) & (high >= box[1])]
        return shapely.intersection(self.space, shapely.box(*box)), beside


_kept: tuple[Surroundings, ...] = ()  # of the grounds looked at last: views are asked for by the thousand


def surroundings(space: MultiPolygon, walls: Floats, reach_m: float) -> Surroundings:
    """Those of this very space, these walls and this reach, from the last time if it is not long ago."""
    global _kept
    for known in _kept:
        if known.space is space and known.walls is walls and known.reach_m == reach_m:
            return known
    made = Surroundings(space, walls, reach_m)
    _kept = (made, *_kept[:2])  # three grounds in all
    return made


def places_in_sight(
    point_m: Floats, space: MultiPolygon, walls: Floats, reach_m: float, cut: BaseGeometry | None = None
) -> BaseGeometry:
    """Where a robot may stand in sight of the point (2,), as far off as ``reach_m`` or a little farther.

    cut: the view is cut by it too. A view a hair wide has no area, and may be of any kind.
    """
    space_here, walls_here = surroundings(space, walls, reach_m).at(point_m)
    view: BaseGeometry = visibility_polygon(point_m, walls_here, reach_m)
    return (view if cut is None else view.intersection(cut)).intersection(space_here)

"""The cells of a bounce mission, as its settings define them: where a body stands, and which moves it can make.

Written from the definitions in ``BounceSettings`` alone, for the check; it shares nothing with the planner.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from rota.check.arrays import Flags, Floats, Ints
from rota.check.routes import lines_of, segments_of
from rota.check.tolerances import EDGE_RAD, FLOAT_EPS, SAME_CELL, TOUCH_M
from rota.model.mission import Bouncing, Mission

MOST_CELLS = 4_000_000


class Floor:
    """The lattice of a mission's cells; a cell is a row (column, row) of whole numbers, 0, 0 at the lower left."""

    def __init__(self, mission: Mission, rules: Bouncing) -> None:
        self.cell_m = rules.cell_m
        self.moves = heading_moves(rules.headings)
        self._pass_corners = rules.corners == "pass"
        x0, y0, x1, y1 = mission.area.bounds
        origin = rules.cell_origin
        self.corner_m = np.array([x0, y0])
        if origin is not None:
            self.corner_m = (
                np.array(origin) - np.ceil((np.array(origin) - [x0, y0]) / self.cell_m - SAME_CELL) * self.cell_m
            )
        count = np.maximum(1, np.ceil((np.array([x1, y1]) - self.corner_m) / self.cell_m - SAME_CELL))
        self.judgeable = bool(count.prod() <= MOST_CELLS)  # there are no more cells than can be looked at
        self.shape = count.astype(np.int64) if self.judgeable else np.zeros(2, np.int64)
        blocked = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
        self._ground = shapely.difference(mission.area, blocked)
        self._wider_ground = shapely.buffer(self._ground, TOUCH_M / 2, join_style="mitre")
        shapely.prepare([self._ground, self._wider_ground])
        walls = lines_of(np.vstack([segments_of(mission.area), segments_of(blocked)]))
        self._walls = shapely.STRtree(walls)
        robots = mission.fleet.unlike_robots
        self._body_m = max(robot.body_radius_m for robot in robots)

    def centres_m(self, cells: Ints) -> Floats:
        """(n, 2) centres of cells (n, 2)."""
        return np.asarray(self.corner_m + (cells + 0.5) * self.cell_m)

    def cells_at(self, places_m: Floats) -> tuple[Ints, Flags]:
        """The cells (n, 2) that hold places, and whether each place is its cell's centre within 1e-6 m."""
        with np.errstate(invalid="ignore"):  # places too far off to have a cell are at no centre
            cells = np.floor((places_m - self.corner_m) / self.cell_m).astype(np.int64)
        noise_m = TOUCH_M + 8 * FLOAT_EPS * np.abs(places_m).max(initial=0.0)
        return cells, np.hypot(*(places_m - self.centres_m(cells)).T) <= noise_m

    def free(self, cells: Ints) -> Flags:
        """Whether the widest body can stand at the centres of cells (n, 2); outside of the lattice none can."""
        inside = ((cells >= 0) & (cells < self.shape)).all(axis=1)
        free = np.zeros(len(cells), np.bool_)
        free[inside] = self._clear(shapely.points(self.centres_m(cells[inside])))
        return free

    def every_free_cell(self) -> Ints:
        """(n, 2) all cells at whose centre the widest body can stand."""
        cells = np.stack(np.meshgrid(*(np.arange(n) for n in self.shape), indexing="ij"), axis=-1).reshape(-1, 2)
        return np.asarray(cells[self.free(cells)])

    def blocks_moves(self, cells: Ints, headings: Ints) -> Flags:
        """Whether a body in each of the cells (n, 2) cannot make the move of its heading (n,): something is in the way.

        The cell where it ends, or (unless corners may be passed) one that the move crosses or whose corner it touches,
        is not free; or the body on its way comes into a wall or obstacle.
        """
        stopped = np.zeros(len(cells), np.bool_)
        for heading in np.unique(headings):
            members = np.flatnonzero(headings == heading)
            move = self.moves[heading]
            needed = [move] if self._pass_corners else [move, *cells_on_line(int(move[0]), int(move[1]))]
            for offset in needed:
                stopped[members] |= ~self.free(cells[members] + offset)
            left = members[~stopped[members]]
            ends = np.stack([self.centres_m(cells[left]), self.centres_m(cells[left] + move)], axis=1)
            stopped[left] = ~self._clear(shapely.linestrings(ends))
        return stopped

    def _clear(self, shapes: Any) -> Flags:
        """Whether a body whose centre is on the shapes stays in the ground; it may touch by half of 1e-6 m."""
        if self._body_m <= TOUCH_M / 2:
            return np.asarray(shapely.covers(self._wider_ground, shapes))
        # what begins inside and comes near no wall stays inside
        begins = shapes if (shapely.get_type_id(shapes) == 0).all() else shapely.get_point(shapes, 0)
        good: Flags = np.asarray(shapely.covers(self._ground, begins))
        near, _ = self._walls.query(shapes, predicate="dwithin", distance=self._body_m - TOUCH_M / 2)
        good[near] = False
        return good


def heading_moves(headings: int) -> Ints:
    """(headings, 2) lattice vectors of the headings, from east on counterclockwise, as ``BounceSettings`` has them.

    With 4 and 8 headings the moves lead to the neighbours. With more, each heading takes the vector nearest in
    direction among those of at most R cells along each axis. R is the least number by which no heading is off by more
    than a quarter of the heading step.
    """
    step = math.tau / headings
    wanted = step * np.arange(headings)
    reach = 1
    while True:
        span = range(-reach, reach + 1)
        vectors = np.array([(x, y) for x in span for y in span if math.gcd(x, y) == 1])
        off = np.arctan2(vectors[:, 1], vectors[:, 0])[None, :] - wanted[:, None]
        off = np.abs(np.arctan2(np.sin(off), np.cos(off)))
        if off.min(axis=1).max() <= step / 4 + EDGE_RAD:
            return np.asarray(vectors[off.argmin(axis=1)])
        reach += 1


def cells_on_line(dx: int, dy: int) -> list[tuple[int, int]]:
    """The cells whose closed square meets the line from the middle of (0, 0) to that of (dx, dy), without both ends."""
    cells = []
    for x in range(min(0, dx), max(0, dx) + 1):
        for y in range(min(0, dy), max(0, dy) + 1):
            if abs(dx * y - dy * x) * 2 <= abs(dx) + abs(dy) and (x, y) not in ((0, 0), (dx, dy)):
                cells.append((x, y))
    return cells

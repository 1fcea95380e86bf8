"""The ground as cells in which a disc robot can stand, and the moves between them that its body can make."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, STRtree

from rota.errors import MissionError
from rota.geometry.free_space import free_ground
from rota.model.mission import TOUCH_M, Mission
from rota.model.planner_settings import Corners
from rota.planners.bounce.arrays import Flags, Floats, Ints, Longs
from rota.planners.bounce.planner_settings import BounceSettings

MOST_CELLS = 4_000_000
BLOCKED = -1
CORNER = 1e-9  # cells: what a move passes by less than this it touches only


@dataclass(frozen=True, kw_only=True, eq=False)
class Cells:
    """The free cells of a ground, n of them, and where each of k headings leads from there.

    A robot's state is ``cell * k + heading``. column, row: (n,) int32, in cells from the lower left corner of the
    area's bounds. moves: (k, 2) int32, columns and rows. target: (n, k) int32, the cell where a move ends, or BLOCKED.
    """

    cell_m: float
    corner_m: tuple[float, float]
    column: Ints
    row: Ints
    moves: Ints
    target: Ints

    @property
    def count(self) -> int:
        """How many cells are free."""
        return len(self.column)

    @property
    def headings(self) -> int:
        """How many headings there are."""
        return len(self.moves)

    @property
    def states(self) -> int:
        """How many states a robot can be in: a free cell and a heading."""
        return self.count * self.headings

    @property
    def centres_m(self) -> Floats:
        """(n, 2) centres of the cells."""
        lattice = np.column_stack([self.column, self.row]) + 0.5
        return np.asarray(np.asarray(self.corner_m) + lattice * self.cell_m)

    @property
    def longest_move_m(self) -> float:
        """The length of the longest move in metres, which tells how long a step must last."""
        return float(np.hypot(*self.moves.T).max()) * self.cell_m

    @property
    def headings_rad(self) -> Floats:
        """(k,) true directions of the moves, from 0 counterclockwise."""
        return np.asarray(np.arctan2(self.moves[:, 1], self.moves[:, 0]) % math.tau)

    def at(self, place_m: tuple[float, float]) -> int | None:
        """The free cell that holds a place; None where there is none."""
        column, row = (math.floor((place_m[k] - self.corner_m[k]) / self.cell_m) for k in (0, 1))
        cells = np.flatnonzero((self.column == column) & (self.row == row))
        return int(cells[0]) if len(cells) else None


def heading_moves(headings: int) -> Ints:
    """(headings, 2) int32: the lattice vectors that robots with so many headings move along, from east on.

    4 headings lead to the neighbours by a side, 8 also to those by a corner. With more, each heading takes the vector
    nearest to it among those of at most R cells along each axis. R is the smallest number for which no heading is off
    by more than a quarter of the heading step. The move of 16 headings at 22.5 degrees is (2, 1), at 26.57.
    """
    step = math.tau / headings
    for reach in range(1, 8):
        span = np.arange(-reach, reach + 1)
        vectors = np.array([(x, y) for x in span for y in span if math.gcd(x, y) == 1])
        angles = np.arctan2(vectors[:, 1], vectors[:, 0])
        off = np.abs((angles[None, :] - step * np.arange(headings)[:, None] + math.pi) % math.tau - math.pi)
        if off.min(axis=1).max() <= step / 4 + CORNER:
            return np.asarray(vectors[off.argmin(axis=1)], np.int32)
    raise AssertionError(f"{headings} headings have no moves of 7 cells or less")


def make_cells(mission: Mission) -> Cells:
    """The cells of a mission, for the widest body of its fleet and the settings of its planner.

    Raises MissionError for more than MOST_CELLS cells and for a ground on which no body can stand at a cell's centre.
    """
    settings = BounceSettings.of(mission)
    robots = mission.fleet.unlike_robots
    _, _, x1, y1 = mission.area.bounds
    x0, y0 = mission.grid_corner_m
    return cells_of(
        free_ground(mission),
        (x0, y0, x1, y1),
        cell_m=settings.cell_m,
        headings=settings.headings,
        corners=settings.corners,
        body_radius_m=max(robot.body_radius_m for robot in robots),
    )


def cells_of(
    ground: MultiPolygon,
    bounds_m: tuple[float, float, float, float],
    *,
    cell_m: float,
    headings: int = 8,
    corners: Corners = "blocked",
    body_radius_m: float = 0.0,
) -> Cells:
    """Cells of ``cell_m`` from the lower left corner of ``bounds_m`` on; free where a body can stand at the centre.

    ground: the free space in metres. A move is possible when the moving body touches no border by more than 1e-6 m.
    With corners "blocked", all cells that the move crosses, or whose corners it touches, must be free as well; for a
    diagonal move these are both cells beside it. Raises MissionError.
    """
    x0, y0, x1, y1 = bounds_m
    columns, rows = (max(1, math.ceil((high - low) / cell_m - 1e-9)) for low, high in ((x0, x1), (y0, y1)))
    if columns * rows > MOST_CELLS:
        raise MissionError(
            f"bounce.cell_m: {cell_m:.6g} is not allowed; the area would have {columns} x {rows} cells and at most"
            f" {MOST_CELLS:,} are possible; larger cells are needed"
        )
    row, column = (index.ravel() for index in np.indices((rows, columns)))
    centres = np.column_stack([x0 + (column + 0.5) * cell_m, y0 + (row + 0.5) * cell_m])
    room = _Room(ground, body_radius_m)
    free = room.holds(shapely.points(centres))
    if not free.any():
        raise MissionError(
            f"bounce.cell_m: a body of radius {body_radius_m:.6g} m fits at the centre of none of the"
            f" {columns} x {rows} cells of {cell_m:.6g} m; smaller cells, a smaller body or more free space are needed"
        )
    number = np.full((rows, columns), BLOCKED, np.int32)
    number.ravel()[free] = np.arange(free.sum(), dtype=np.int32)
    moves = heading_moves(headings)
    target = np.full((int(free.sum()), headings), BLOCKED, np.int32)
    for k, move in enumerate(moves):
        target[:, k] = _targets(number, column[free], row[free], move, corners)
    _block_by_geometry(target, moves, centres[free], room)
    return Cells(
        cell_m=cell_m,
        corner_m=(x0, y0),
        column=column[free].astype(np.int32),
        row=row[free].astype(np.int32),
        moves=moves,
        target=target,
    )


def crossed_cells(move: tuple[int, int]) -> list[tuple[int, int]]:
    """The cells that a move crosses or whose corners it touches, without the cells at its ends."""
    dx, dy = move
    cells = []
    for x in range(min(0, dx), max(0, dx) + 1):
        for y in range(min(0, dy), max(0, dy) + 1):
            # the corners nearest to the line on either side of it; 0: the line runs through a corner
            off = dx * y - dy * x
            if abs(off) <= (abs(dx) + abs(dy)) / 2 and (x, y) not in ((0, 0), (dx, dy)):
                cells.append((x, y))
    return cells


def _targets(number: Ints, column: Longs, row: Longs, move: Ints, corners: Corners) -> Ints:
    """(n,) cells that the move ends in; BLOCKED where a cell that the move needs is not free."""
    rows, columns = number.shape

    def cell(dx: int, dy: int) -> Ints:
        x, y = column + dx, row + dy
        inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
        return np.where(inside, number[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)], BLOCKED)

    dx, dy = int(move[0]), int(move[1])
    target = cell(dx, dy)
    if corners == "blocked":
        for beside in crossed_cells((dx, dy)):
            target = np.where(cell(*beside) == BLOCKED, BLOCKED, target)
    return target


def _block_by_geometry(target: Ints, moves: Ints, centres: Floats, room: _Room) -> None:
    """Block the moves, there and back, that the body cannot make."""
    headings = len(moves)
    for k in range(headings // 2):
        cells = np.flatnonzero(target[:, k] != BLOCKED)
        ends = target[cells, k]
        lines = shapely.linestrings(np.stack([centres[cells], centres[ends]], axis=1))
        blocked = ~room.holds(lines)
        target[cells[blocked], k] = BLOCKED
        target[ends[blocked], k + headings // 2] = BLOCKED


class _Room:
    """Where the body's centre may be."""

    def __init__(self, ground: MultiPolygon, body_radius_m: float) -> None:
        self._ground = ground.buffer(TOUCH_M / 2, join_style="mitre")
        shapely.prepare(self._ground)
        self._clear_m = body_radius_m - TOUCH_M / 2
        rings = [np.asarray(ring.coords) for part in ground.geoms for ring in (part.exterior, *part.interiors)]
        segments = [np.stack([points[:-1], points[1:]], axis=1) for points in rings]
        self._walls = STRtree(shapely.linestrings(np.concatenate(segments))) if segments else STRtree([])

    def holds(self, shapes: NDArray[np.object_]) -> Flags:
        """Whether a body whose centre is at these points, or moves along these lines, stays in the free space."""
        good = np.asarray(shapely.covers(self._ground, shapes))
        if self._clear_m > 0:
            near, _ = self._walls.query(shapes, predicate="dwithin", distance=self._clear_m)
            good[near] = False
        return good

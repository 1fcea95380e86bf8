"""Open ground in rows of lanes: how many lanes side by side, cut where, so that whole robots just drive them in time.

A *row* is an even number of lanes side by side. It is cut across into *columns*, each driven round and round by a few
robots. Long lanes waste least: a column loses about a swath's width a lane. Robots come whole, and what the last one of
a row has to spare is lost; so rows are chosen whose lengths fill their robots' budgets best, by dynamic programming.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.methods.sweeping.lanes import Swath, ground_turned, polygons, shared_m, slab
from rota.planners.patrol.tolerances import BESIDE_M, CUT_M

MOST_LANES = 24  # side by side in one row
MOST_SHARING = 16  # robots of one column: each drives all of it, and what there is to check grows with their square


@dataclass(frozen=True, kw_only=True)
class LaneCell:
    """Ground that every line along x meets in one stretch, in lanes along x.

    lanes (n,): the ground in each, n even. edges_m (n + 1,): heights of their borders. left_m, right_m (n,): the ends
    of the ground in each.
    """

    lanes: tuple[BaseGeometry, ...]
    edges_m: Floats
    left_m: Floats
    right_m: Floats

    @property
    def lane_m(self) -> float:
        """The width of a lane."""
        return float(self.edges_m[1] - self.edges_m[0])


@dataclass(frozen=True, kw_only=True)
class Row:
    """Lanes ``first`` to ``last`` - 1 of a cell in so many columns, with so many robots in all."""

    first: int
    last: int
    columns: int
    robots: int


@dataclass(frozen=True, kw_only=True)
class Column:
    """Ground that one loop sees: one shape for each of its lanes, from the lowest; and the robots expected on it."""

    lanes: tuple[MultiPolygon, ...]
    heights_m: Floats
    robots: int


@dataclass(frozen=True, kw_only=True)
class RowMeasures:
    """What the length of a row depends on. budget_m: what one robot drives in a period.

    width_m: of a lane at most. short_m: a lane may end so far before the ground does, at either end. corner_m: metres
    worth the time of a corner. sharing: robots of one column at most.
    """

    budget_m: float
    width_m: float
    short_m: float
    corner_m: float
    sharing: int

    def ends_m(self, lanes: int) -> float:
        """What a column adds to the lengths of its lanes: ways between them and back along a side, and corners.

        The way back sees half a lane's width of all lanes but the outermost two.
        """
        ways_m = (1.5 * lanes - 1) * self.width_m if lanes > 1 else 0.0
        return ways_m + 2 * lanes * (self.corner_m - self.short_m)


def row_measures(problem: Problem, swath: Swath, budget_m: float) -> RowMeasures:
    """Rows for the mission's robot. Lanes are so much narrower than its swath that bodies stay in their columns."""
    body_m = problem.robot.body_radius_m
    apart_m = body_m + BESIDE_M if body_m > 0 else 0.0
    offsets = np.linspace(swath.half_m, 0.0, 501)
    fitting = offsets[swath.chords_m(offsets)[1] >= apart_m]
    half_m = float(fitting[0]) if len(fitting) else swath.half_m
    shares = body_m == 0 or half_m >= 4.0 * body_m  # robots with bodies share loops where they can pass each other
    return RowMeasures(
        budget_m=budget_m,
        width_m=2 * half_m,
        short_m=float(swath.chords_m(np.array([half_m]))[1][0]),
        corner_m=driving_of(problem.robot).corner_costs.quarter_turn_m,
        sharing=MOST_SHARING if shares else 1,
    )


def lane_cells(ground: MultiPolygon, angle_rad: float, width_m: float) -> list[LaneCell]:
    """The ground, turned so that lanes of this angle lie along x, in cells of an even number of lanes each.

    The lanes of all cells lie on one grid, two by two. Pairs of lanes one above the other are in one cell where they
    border each other and no others; that cuts the ground as boustrophedon cells are cut (Choset, Coverage of known
    spaces, Autonomous Robots 9, 2000), but for a hole or a notch that leaves some of a pair of lanes in one piece.
    """
    upright = ground_turned(ground, -angle_rad)
    _, low, _, high = upright.bounds
    pairs = max(1, math.ceil((high - low) / (2 * width_m) - 1e-9))
    edges_m = np.linspace(low, high, 1 + 2 * pairs)
    return [lane_cell(first, parts, edges_m) for first, parts in chains(upright, edges_m)]


def chains(shape: MultiPolygon, edges_m: Floats) -> Iterator[tuple[int, list[Polygon]]]:
    """The parts of a shape in every pair of lanes, in chains upwards: the first one's pair, and the parts of each."""
    growing: list[tuple[int, list[Polygon]]] = []
    for pair in range(len(edges_m) // 2):
        parts = slab(shape, edges_m[2 * pair], edges_m[2 * pair + 2])
        touches = np.array([[shared_m(part, chain[-1]) > CUT_M for _, chain in growing] for part in parts])
        touches = touches.reshape(len(parts), len(growing))
        now: list[tuple[int, list[Polygon]]] = []
        for part, row in zip(parts, touches, strict=True):
            below = np.flatnonzero(row)
            if len(below) == 1 and touches[:, below[0]].sum() == 1:
                first, chain = growing[below[0]]
                now.append((first, [*chain, part]))
            else:
                now.append((pair, [part]))
        ended = [chain for k, chain in enumerate(growing) if not (touches[:, k].sum() == 1 and goes_on(touches, k))]
        yield from ended
        growing = now
    yield from growing


def goes_on(touches: Flags, k: int) -> bool:
    """Whether the one part that borders chain k borders no other: touches (parts, chains)."""
    return bool(touches[np.argmax(touches[:, k])].sum() == 1)


def lane_cell(first: int, parts: list[Polygon], edges_m: Floats) -> LaneCell:
    """The cell of the parts (n,) of so many pairs of lanes, from pair ``first`` on; edges_m: of all lanes."""
    own_m = edges_m[2 * first : 2 * (first + len(parts)) + 1]
    each = np.repeat(np.array(parts), 2)
    left, _, right, _ = shapely.total_bounds(each)
    held = shapely.intersection(each, shapely.box(left - 1, own_m[:-1], right + 1, own_m[1:]))
    bounds = shapely.bounds(held)
    bounds = np.where(np.isfinite(bounds), bounds, left)  # a lane in which there is nothing
    return LaneCell(lanes=tuple(held), edges_m=own_m, left_m=bounds[:, 0], right_m=bounds[:, 2])


def best_rows(cell: LaneCell, measures: RowMeasures) -> list[Row]:
    """The division of a cell's lanes into rows with the fewest robots, and of these the one with the shortest loops.

    Dynamic programming over the number of lanes that are done, from below.
    """
    n = len(cell.left_m)
    length_m = np.concatenate([[0.0], np.cumsum(cell.right_m - cell.left_m + slants_m(cell))])
    best: list[tuple[float, float]] = [(0.0, 0.0)] + [(math.inf, math.inf)] * n
    last_row: list[Row | None] = [None] * (n + 1)
    for end in range(2, n + 1, 2):
        for first in range(max(0, end - MOST_LANES), end, 2):
            columns, row_m = columns_for(float(length_m[end] - length_m[first]), end - first, measures)
            robots = math.ceil(row_m / measures.budget_m - 1e-9)
            cost = (best[first][0] + robots, best[first][1] + row_m)
            if cost < best[end]:
                best[end] = cost
                last_row[end] = Row(first=first, last=end, columns=columns, robots=robots)
    rows: list[Row] = []
    end = n
    while end > 0:
        row = last_row[end]
        assert row is not None
        rows.append(row)
        end = row.first
    return rows[::-1]


def slants_m(cell: LaneCell) -> Floats:
    """What slanting ends add to the ways from each lane (n,) to the next, and back along the left side."""
    left, right = np.diff(cell.left_m, append=cell.left_m[-1]), np.diff(cell.right_m, append=cell.right_m[-1])
    way_m = cell.lane_m
    return np.asarray(1.5 * (np.hypot(left, way_m) - way_m) + 0.5 * (np.hypot(right, way_m) - way_m))


def columns_for(lanes_m: float, lanes: int, measures: RowMeasures) -> tuple[int, float]:
    """The fewest columns of a row whose lanes are so long in all that no column has too many robots, and its length.

    With columns that would be too narrow robots become more than may share instead.
    """
    columns = 1
    while True:
        row_m = lanes_m + columns * measures.ends_m(lanes)
        needed = math.ceil(math.ceil(row_m / measures.budget_m - 1e-9) / measures.sharing)
        # a column is two lanes wide at least
        if needed <= columns or lanes_m < lanes * needed * 2.0 * measures.width_m:
            return columns, max(row_m, 1e-9)
        columns = needed


def columns_of(cell: LaneCell, row: Row, measures: RowMeasures) -> Iterator[Column]:
    """The columns of a row, from left to right, as even as whole robots allow."""
    left, right = cell.left_m[row.first : row.last], cell.right_m[row.first : row.last]
    at = np.unique(np.concatenate([left, right]))
    below_m = np.clip(at[:, None] - left, 0.0, right - left).sum(axis=1)  # metres of lane to the left of there
    robots = np.array([row.robots // row.columns + (k < row.robots % row.columns) for k in range(row.columns)])
    ends_m = measures.ends_m(row.last - row.first)
    each_m = (below_m[-1] + row.columns * ends_m) / row.robots
    cuts = np.interp(np.cumsum(robots * each_m - ends_m)[:-1], below_m, at)
    edges = np.concatenate([[at[0] - 1], cuts, [at[-1] + 1]])
    low, high = cell.edges_m[row.first : row.last], cell.edges_m[row.first + 1 : row.last + 1]
    for k in range(row.columns):
        lanes = np.array(cell.lanes[row.first : row.last])
        parts = shapely.intersection(lanes, shapely.box(edges[k], low - 1, edges[k + 1], high + 1))
        held = [(MultiPolygon(polygons(part)), (a + b) / 2) for part, a, b in zip(parts, low, high, strict=True)]
        held = [(part, height) for part, height in held if not part.is_empty]
        if held:
            yield Column(
                lanes=tuple(part for part, _ in held),
                heights_m=np.array([height for _, height in held]),
                robots=int(robots[k]),
            )

# mypy: disallow-untyped-decorators=False, disallow-untyped-calls=False
"""Compiled loops over cells: which cells a virtual sensor sees. A cell is seen when all its corners are."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.geometry.kernels import EdgeGrid, point_in_space, point_sees_point
from rota.planners.patrol.tolerances import TIE


class CellTable(NamedTuple):
    """Cells (or what is left of them at borders) in the order of their squares, row by row.

    Those of square q = j * nx + i are square_start[q] : square_start[q + 1]; corners of cell c are
    corners[corner_item[corner_start[c] : corner_start[c + 1]]], (v, 2) metres; centres (m, 2) metres.
    """

    x0: float
    y0: float
    cell_m: float
    nx: int
    ny: int
    square_start: Any
    corner_start: Any
    corner_item: Any
    corners: Any
    centres: Any


class Ground(NamedTuple):
    """Where sensors may be (space), what hides cells from them (walls), and the walls in reach of each bucket.

    Buckets are squares of bucket_m, in ``columns`` columns and ``rows`` rows from (x0, y0) on. Walls near bucket b are
    wall_item[wall_start[b] : wall_start[b + 1]].
    """

    space: EdgeGrid
    walls: EdgeGrid
    reach_m: float
    x0: float
    y0: float
    bucket_m: float
    columns: int
    rows: int
    wall_start: Any
    wall_item: Any


@allocation_free
def corner_in_sight(ax: float, ay: float, bx: float, by: float, first: int, last: int, ground: Ground) -> bool:
    """Whether the line from a sensor a to a corner b meets the inside of no obstacle; walls first..last are near."""
    ux, uy = bx - ax, by - ay
    hair_of_line = 4.0 * TIE * (abs(ux) + abs(uy))
    edges = ground.walls.edges
    for n in range(first, last):
        k = ground.wall_item[n]
        px, py, qx, qy = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        p, q = ux * (py - ay) - uy * (px - ax), ux * (qy - ay) - uy * (qx - ax)
        if (p > hair_of_line and q > hair_of_line) or (p < -hair_of_line and q < -hair_of_line):
            continue
        wx, wy = qx - px, qy - py
        hair = 4.0 * TIE * (abs(wx) + abs(wy))
        a, b = wx * (ay - py) - wy * (ax - px), wx * (by - py) - wy * (bx - px)
        if min(a, b) > hair or (min(a, b) < -hair and max(a, b) <= hair):
            continue  # on one side of the wall, or one end on the wall and the other on its free side
        if min(abs(a), abs(b)) > hair and min(abs(p), abs(q)) > hair_of_line:
            return False  # on both sides, and well between the wall's ends
        return bool(point_sees_point(ax, ay, bx, by, ground.walls))
    return True


@allocation_free
def cells_seen(px: float, py: float, cells: CellTable, ground: Ground, known: Any, seen: Any) -> int:
    """Write the cells that a sensor at (px, py) sees into ``seen``, ascending; returns how many.

    known: (1 + corners,) scratch: the number of calls, and for each corner the call that judged it last, and how.
    """
    known[0] += 1
    mark = 2 * known[0]
    reach = ground.reach_m
    most = reach * reach * (1.0 + TIE)
    column = min(max(int((px - ground.x0) / ground.bucket_m), 0), ground.columns - 1)
    row = min(max(int((py - ground.y0) / ground.bucket_m), 0), ground.rows - 1)
    bucket = row * ground.columns + column
    first, last = ground.wall_start[bucket], ground.wall_start[bucket + 1]
    i0 = max(int(np.floor((px - reach - cells.x0) / cells.cell_m)), 0)
    i1 = min(int(np.floor((px + reach - cells.x0) / cells.cell_m)), cells.nx - 1)
    j0 = max(int(np.floor((py - reach - cells.y0) / cells.cell_m)), 0)
    j1 = min(int(np.floor((py + reach - cells.y0) / cells.cell_m)), cells.ny - 1)
    count = 0
    for j in range(j0, j1 + 1):
        if i1 < i0:
            break
        for c in range(cells.square_start[j * cells.nx + i0], cells.square_start[j * cells.nx + i1 + 1]):
            whole = True
            for n in range(cells.corner_start[c], cells.corner_start[c + 1]):
                corner = cells.corner_item[n]
                dx, dy = cells.corners[corner, 0] - px, cells.corners[corner, 1] - py
                if dx * dx + dy * dy > most:
                    whole = False
                    break
            if not whole:
                continue
            if last > first:
                for n in range(cells.corner_start[c], cells.corner_start[c + 1]):
                    corner = cells.corner_item[n]
                    if known[1 + corner] < mark:
                        open_view = corner_in_sight(
                            px, py, cells.corners[corner, 0], cells.corners[corner, 1], first, last, ground
                        )
                        known[1 + corner] = mark + 1 if open_view else mark
                    if known[1 + corner] == mark:
                        whole = False
                        break
            if whole:
                seen[count] = c
                count += 1
    return count


@kernel
def cells_seen_from(places: Any, cells: CellTable, ground: Ground, most: int) -> Any:
    """Starts (n + 1,) and items of the cells seen from each place (n, 2); ``most`` is the most that a place sees."""
    known = np.zeros(1 + cells.corners.shape[0], np.int64)
    seen = np.empty(most, np.int32)
    start = np.zeros(places.shape[0] + 1, np.int64)
    items = np.empty(0, np.int64)
    for filling in range(2):
        for k in range(places.shape[0]):
            count = cells_seen(places[k, 0], places[k, 1], cells, ground, known, seen)
            start[k + 1] = start[k] + count
            if filling:
                for n in range(count):
                    items[start[k] + n] = seen[n]
        if not filling:
            items = np.empty(start[-1], np.int64)
    return start, items


@allocation_free
def most_in_reach(cells: CellTable, reach_m: float) -> int:
    """An upper bound of the cells that a sensor can see: the most in any window of squares as wide as its disc."""
    span = int(np.ceil(2.0 * reach_m / cells.cell_m)) + 1
    most = 0
    for j in range(cells.ny):
        for i in range(cells.nx):
            count = 0
            for row in range(j, min(j + span, cells.ny)):
                q = row * cells.nx
                count += cells.square_start[q + min(i + span, cells.nx)] - cells.square_start[q + i]
            most = max(most, count)
    return most


@allocation_free
def is_place(px: float, py: float, ground: Ground) -> bool:
    """Whether a sensor may be there."""
    return bool(point_in_space(px, py, ground.space))

"""Compiled loops for the walls near a point that hide something from it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.planners.patrol.ground.sight_kernels import norm
from rota.planners.patrol.tolerances import ON_LINE_M


class WallCells(NamedTuple):
    """Walls (w, 4) in square cells: those in column i and row j are items[start[j * nx + i] : start[j * nx + i + 1]].

    x0, y0: the lower left corner of the first cell.
    """

    walls: Any
    x0: float
    y0: float
    cell_m: float
    nx: int
    ny: int
    start: Any
    items: Any


@kernel(error_model="numpy")
def walls_that_hide(xy: Any, reach: float, cells: WallCells) -> Any:
    """The walls within reach of each point (n, 2) that hide anything from it: starts (n + 1,), and their numbers."""
    n = xy.shape[0]
    start = np.zeros(n + 1, dtype=np.int64)
    found = np.empty(1024, dtype=np.int64)
    asked = np.full(cells.walls.shape[0], -1, dtype=np.int64)
    for i in range(n):
        near = walls_near(xy[i, 0], xy[i, 1], reach, cells, asked, i)
        needed = nearest_walls(xy[i, 0], xy[i, 1], near, cells.walls)
        at = start[i]
        for j in range(near.shape[0]):
            if needed[j]:
                if at == found.shape[0]:
                    found = np.concatenate((found, np.empty_like(found)))
                found[at] = near[j]
                at += 1
        start[i + 1] = at
    return start, found[: start[n]].copy()


@kernel(error_model="numpy")
def walls_near(x: float, y: float, reach: float, cells: WallCells, asked: Any, turn: int) -> Any:
    """The numbers of the walls within reach of a point, ascending; asked (w,): the last turn that asked for each."""
    left = max(math.floor((x - reach - cells.x0) / cells.cell_m), 0)
    right = min(math.floor((x + reach - cells.x0) / cells.cell_m), cells.nx - 1)
    low = max(math.floor((y - reach - cells.y0) / cells.cell_m), 0)
    high = min(math.floor((y + reach - cells.y0) / cells.cell_m), cells.ny - 1)
    most = 0
    for j in range(low, high + 1):
        if left <= right:
            most += cells.start[j * cells.nx + right + 1] - cells.start[j * cells.nx + left]
    near, numbers = np.empty(most, dtype=np.int64), np.empty(most)
    count = 0
    for j in range(low, high + 1):
        for i in range(left, right + 1):
            for k in range(cells.start[j * cells.nx + i], cells.start[j * cells.nx + i + 1]):
                w = cells.items[k]
                if asked[w] == turn:
                    continue
                asked[w] = turn
                if away_from(x, y, cells.walls[w]) <= reach:
                    near[count], numbers[count] = w, w
                    count += 1
    return near[ascending(numbers[:count])]


@allocation_free
def away_from(x: float, y: float, wall: Any) -> float:
    """Distance of a point from a wall."""
    ux, uy, wx, wy = x - wall[0], y - wall[1], wall[2] - wall[0], wall[3] - wall[1]
    square = wx * wx + wy * wy
    along = 0.0 if square == 0.0 else min(1.0, max(0.0, (ux * wx + uy * wy) / square))
    away: float = norm(ux - along * wx, uy - along * wy)
    return away


@kernel(error_model="numpy")
def nearest_walls(x: float, y: float, items: Any, walls: Any) -> Any:
    """Which of the walls with the numbers items are the nearest in some direction: the others hide nothing more.

    Walls may meet but not cross: between two neighbouring directions of wall ends the nearest wall is the same one, so
    one ray there tells it. A wall that the point lies on always counts: it hides what is behind it. Walls are sorted
    into sectors, the nearest first: a ray is tried on those that lie its way and could be nearer than what it has hit.
    """
    count = items.shape[0]
    needed, sectors = np.zeros(count, dtype=np.bool_), min(count, 256)
    if count == 0:
        return needed
    angles, away = np.empty(2 * count), np.empty(count)
    first, last = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    start = np.zeros(sectors + 1, dtype=np.int64)
    for j in range(count):
        w = walls[items[j]]
        angles[2 * j], angles[2 * j + 1] = math.atan2(w[1] - y, w[0] - x), math.atan2(w[3] - y, w[2] - x)
        needed[j] = lies_on(w, x, y)
        away[j], first[j], last[j] = sectors_of(x, y, w, angles[2 * j], angles[2 * j + 1], sectors)
        for k in range(first[j], last[j] + 1):
            start[(k if k < sectors else k - sectors) + 1] += 1
    for k in range(sectors):
        start[k + 1] += start[k]
    inside, place = np.empty(start[sectors], dtype=np.int64), start.copy()
    for j in ascending(away):
        for k in range(first[j], last[j] + 1):
            sector = k if k < sectors else k - sectors
            inside[place[sector]] = j
            place[sector] += 1
    order = ascending(angles)
    per_turn = sectors / (2 * math.pi)
    for a in range(2 * count):
        after = angles[order[a + 1]] if a + 1 < 2 * count else angles[order[0]] + 2 * math.pi
        middle = (angles[order[a]] + after) / 2
        dx, dy = math.cos(middle), math.sin(middle)
        near, hit = math.inf, -1
        sector = int((middle + math.pi) * per_turn)
        sector = sector if sector < sectors else sector - sectors
        for n in range(start[sector], start[sector + 1]):
            j = inside[n]
            if away[j] > near * (1 + 1e-9) + ON_LINE_M:
                break
            far = ray_hits(dx, dy, walls[items[j]], x, y)
            if far < near or (far == near and j < hit):
                near, hit = far, j
        if hit >= 0:
            needed[hit] = True
    return needed


@kernel(noinline=True)
def ascending(values: Any) -> Any:
    """The order (n,) in which values (n,) rise; a kernel by itself, since numpy's sorting takes long to compile."""
    return np.argsort(values)


@allocation_free
def sectors_of(x: float, y: float, wall: Any, first_angle: float, last_angle: float, sectors: int) -> Any:
    """How far a wall is from (x, y), and the first and last of the sectors that it lies in, both ends at angles.

    The last may be beyond the number of sectors, which begin at -pi, and both are a little wide. Where rounding leaves
    the side unclear on which the point passes the wall, it lies in all of them.
    """
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    along = 0.0 if wx == 0.0 and wy == 0.0 else min(1.0, max(0.0, -(ux * wx + uy * wy) / (wx * wx + wy * wy)))
    away = norm(ux + along * wx, uy + along * wy)
    if away < 1e-4:
        return away, 0, sectors - 1
    turn = last_angle - first_angle
    if turn < 0:
        turn += 2 * math.pi
    begin = first_angle if turn <= math.pi else last_angle
    turn = min(turn, 2 * math.pi - turn)
    per_turn = sectors / (2 * math.pi)
    first = math.floor((begin - 1e-9 + math.pi) * per_turn)
    last = math.floor((begin + turn + 1e-9 + math.pi) * per_turn)
    if first < 0:
        first, last = first + sectors, last + sectors
    return away, first, min(last, first + sectors - 1)


@allocation_free
def lies_on(wall: Any, x: float, y: float) -> Any:
    """Whether a point lies on a wall, its ends not included."""
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    return turn * turn <= ON_LINE_M * ON_LINE_M * (wx * wx + wy * wy) and ux * vx + uy * vy < 0


@allocation_free
def ray_hits(dx: float, dy: float, wall: Any, x: float, y: float) -> float:
    """Distance along a ray from (x, y) along d to the wall, inf when it misses or starts on the wall's line."""
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    if turn * turn <= ON_LINE_M * ON_LINE_M * (wx * wx + wy * wy):
        return math.inf
    across = dx * wy - dy * wx
    if across == 0.0:
        return math.inf
    along = (dy * ux - dx * uy) / across
    far = (ux * wy - uy * wx) / across
    return far if far > 0 and 0 <= along <= 1 else math.inf

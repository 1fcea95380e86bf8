"""Compiled loops for places to look from: who sees what, and greedy set cover."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.sight_kernels import TOUCH_M

MANY_WALLS = 40  # round a point: from this number on they are sorted by direction
MOST_SECTORS = 256  # into which they are sorted


@njit(cache=True)
def places_see(x: Any, y: Any, reach: float, square: int, period_class: int, s: Samples, room: int) -> Any:
    """Samples that each place sees: starts (n + 1,) and indices; no place sees more than ``room``."""
    n = x.shape[0]
    start = np.zeros(n + 1, dtype=np.int64)
    runs = np.empty(2 * room, dtype=np.int32)
    for i in range(n):
        written = leg_sees(Leg(x[i], y[i], x[i], y[i], reach, square), period_class, s, runs)
        start[i + 1] = start[i]
        for j in range(0, written, 2):
            start[i + 1] += runs[j + 1] - runs[j]
    items = np.empty(start[n], dtype=np.int32)
    at = 0
    for i in range(n):
        written = leg_sees(Leg(x[i], y[i], x[i], y[i], reach, square), period_class, s, runs)
        for j in range(0, written, 2):
            for sample in range(runs[j], runs[j + 1]):
                items[at] = sample
                at += 1
    return start, items


@njit(cache=True)
def walls_that_hide(x: Any, y: Any, start: Any, items: Any, walls: Any) -> Any:
    """Which of each point's walls (flags like items) are the nearest in some direction: the others hide nothing more.

    Walls may meet but not cross: between two neighbouring directions of wall ends the nearest wall is the same one, so
    one ray there tells it. A wall that the point lies on always counts: it hides what is behind it.
    """
    needed = np.zeros(items.shape[0], dtype=np.bool_)
    for i in range(x.shape[0]):
        begin, end = start[i], start[i + 1]
        angles = np.empty(2 * (end - begin) + 1)
        for j in range(begin, end):
            w = walls[items[j]]
            angles[2 * (j - begin)] = math.atan2(w[1] - y[i], w[0] - x[i])
            angles[2 * (j - begin) + 1] = math.atan2(w[3] - y[i], w[2] - x[i])
            needed[j] = lies_on(w, x[i], y[i])
        if end == begin:
            continue
        angles[-1] = np.min(angles[:-1]) + 2 * math.pi
        if end - begin > MANY_WALLS:
            mark_nearest(x[i], y[i], items[begin:end], walls, angles, needed[begin:end])
            continue
        angles.sort()
        for a in range(angles.shape[0] - 1):
            middle = (angles[a] + angles[a + 1]) / 2
            dx, dy = math.cos(middle), math.sin(middle)
            near, first = math.inf, -1
            for j in range(begin, end):
                far = ray_hits(dx, dy, walls[items[j]], x[i], y[i])
                if far < near:
                    near, first = far, j
            if first >= 0:
                needed[first] = True
    return needed


@njit(cache=True)
def mark_nearest(x: float, y: float, items: Any, walls: Any, angles: Any, needed: Any) -> None:
    """Mark the walls that are the nearest in the middle between two neighbouring directions, of very many walls.

    angles (2 k + 1,): the directions of their ends, and the first of these once more. Walls are sorted into sectors,
    the nearest first, so that a ray is tried on those alone that lie its way and could be nearer than what it has hit.
    """
    count = items.shape[0]
    away, sectors = np.empty(count), min(count, MOST_SECTORS)
    first, last = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    start = np.zeros(sectors + 1, dtype=np.int64)
    for j in range(count):
        away[j], first[j], last[j] = sectors_of(x, y, walls[items[j]], angles[2 * j], angles[2 * j + 1], sectors)
        for k in range(first[j], last[j] + 1):
            start[k % sectors + 1] += 1
    for k in range(sectors):
        start[k + 1] += start[k]
    inside, place = np.empty(start[sectors], dtype=np.int64), start.copy()
    for j in np.argsort(away):
        for k in range(first[j], last[j] + 1):
            inside[place[k % sectors]] = j
            place[k % sectors] += 1
    angles.sort()
    for a in range(angles.shape[0] - 1):
        middle = (angles[a] + angles[a + 1]) / 2
        dx, dy = math.cos(middle), math.sin(middle)
        near, hit = math.inf, -1
        sector = math.floor((middle + math.pi) / (2 * math.pi) * sectors) % sectors
        for n in range(start[sector], start[sector + 1]):
            j = inside[n]
            if away[j] > near * (1 + 1e-9) + TOUCH_M:
                break
            far = ray_hits(dx, dy, walls[items[j]], x, y)
            if far < near or (far == near and j < hit):
                near, hit = far, j
        if hit >= 0:
            needed[hit] = True


@njit(cache=True)
def sectors_of(x: float, y: float, wall: Any, first_angle: float, last_angle: float, sectors: int) -> Any:
    """How far a wall is from (x, y), and the first and last of the sectors that it lies in, both ends at angles.

    The last may be beyond the number of sectors, which begin at -pi, and both are a little wide. Where rounding leaves
    the side unclear on which the point passes the wall, it lies in all of them.
    """
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    along = 0.0 if wx == 0.0 and wy == 0.0 else min(1.0, max(0.0, -(ux * wx + uy * wy) / (wx * wx + wy * wy)))
    away = math.hypot(ux + along * wx, uy + along * wy)
    if away < 1e-4:
        return away, 0, sectors - 1
    turn = (last_angle - first_angle) % (2 * math.pi)
    begin = first_angle if turn <= math.pi else last_angle
    turn = min(turn, 2 * math.pi - turn)
    first = math.floor((begin - 1e-9 + math.pi) / (2 * math.pi) * sectors)
    last = math.floor((begin + turn + 1e-9 + math.pi) / (2 * math.pi) * sectors)
    return away, first, min(last, first + sectors - 1)


@njit(cache=True)
def lies_on(wall: Any, x: float, y: float) -> bool:
    """Whether a point lies on a wall, its ends not included."""
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    return turn * turn <= TOUCH_M * TOUCH_M * (wx * wx + wy * wy) and ux * vx + uy * vy < 0


@njit(cache=True)
def ray_hits(dx: float, dy: float, wall: Any, x: float, y: float) -> float:
    """Distance along a ray from (x, y) along d to the wall, inf when it misses or starts on the wall's line."""
    ux, uy, vx, vy = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    if turn * turn <= TOUCH_M * TOUCH_M * (wx * wx + wy * wy):
        return math.inf
    across = dx * wy - dy * wx
    if across == 0.0:
        return math.inf
    along = (dy * ux - dx * uy) / across
    far = (ux * wy - uy * wx) / across
    return far if far > 0 and 0 <= along <= 1 else math.inf


@njit(cache=True)
def greedy_cover(start: Any, items: Any, weight: Any, covered: Any) -> Any:
    """Places chosen one after the other, each for the greatest weight of samples not yet covered; marks ``covered``."""
    n = start.shape[0] - 1
    count = weight.shape[0]
    back_start = np.zeros(count + 2, dtype=np.int64)
    for j in range(items.shape[0]):
        back_start[items[j] + 2] += 1
    for i in range(2, count + 2):
        back_start[i] += back_start[i - 1]
    back = np.empty(items.shape[0], dtype=np.int32)
    gain = np.zeros(n)
    for i in range(n):
        for j in range(start[i], start[i + 1]):
            back[back_start[items[j] + 1]] = i
            back_start[items[j] + 1] += 1
            if not covered[items[j]]:
                gain[i] += weight[items[j]]
    chosen = np.empty(n, dtype=np.int64)
    count_chosen = 0
    while count_chosen < n:
        best = np.argmax(gain)
        if gain[best] <= 1e-9:
            break
        chosen[count_chosen] = best
        count_chosen += 1
        for j in range(start[best], start[best + 1]):
            sample = items[j]
            if covered[sample]:
                continue
            covered[sample] = True
            for m in range(back_start[sample], back_start[sample + 1]):
                gain[back[m]] -= weight[sample]
        gain[best] = 0.0
    return chosen[:count_chosen]

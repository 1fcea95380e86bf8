"""Compiled loops of the patrol planner: what a leg sees. Arrays are float64 and int64: one compilation serves all."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True, "_nrt": False}


def compiled(function: Callable[..., Any]) -> Any:
    """A compiled function that allocates no array.

    Such functions pass tuples of many arrays to each other; to count references to every array on every call (numba's
    runtime, "nrt") would take more time than all the rest.
    """
    return njit(**OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """A compiled function that becomes part of its callers."""
    return njit(**OPTIONS, inline="always")(function)


Index = np.uint64  # in the hottest loops: each index that may be negative costs a look whether it is
STANDING_M2 = 1e-18  # a leg with less length (squared) is a place where the robot stands
TOUCH_M = 1e-7  # a sample this close to a wall lies on it: that wall does not hide it


class Samples(NamedTuple):
    """Points that must be seen: those of lattices row by row, then all others by bins; see ``samples.py``."""

    x: Floats
    y: Floats
    weight: Floats
    period: Ints
    visit_m: Floats
    shrink_m: Floats
    wall_start: Ints
    wall_item: Ints
    walls: Floats
    next_walled: Ints
    frames: Floats
    frame_ints: Ints
    column_start: NDArray[np.int32]
    bin_start: Ints
    origin: Floats
    bins: Ints


@compiled
def norm(dx: float, dy: float) -> float:
    """Length of a vector; the library's hypot guards against overflow, which costs more than all the rest here."""
    return math.sqrt(dx * dx + dy * dy)


@compiled
def hidden_until(
    t: float, ux: float, uy: float, vx: float, vy: float, px: float, py: float, dx: float, dy: float, corner: float
) -> float:  # fmt: skip
    """End of the interval of leg parameters round ``t`` in which a wall hides the origin, or t if it does not.

    The wall runs from u to v, its obstacle on the left, the leg from p on along d, all seen from the hidden point. A
    point that lies on the wall, farther than ``corner`` from its ends, is hidden from the obstacle's side.
    """
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    if turn < 0:
        wx, wy = -wx, -wy
    # the shadow is where all three are positive: behind the wall, and between the rays through its ends
    at, slope = wy * (px - ux) - wx * (py - uy), wy * dx - wx * dy
    now = at + t * slope
    if turn * turn <= TOUCH_M * TOUCH_M * (wx * wx + wy * wy):
        if turn >= 0:  # the sign above is for the side away from the point: here it is the obstacle's that counts
            at, slope, now = -at, -slope, -now
        now -= TOUCH_M * norm(wx, wy)
        if now <= 0 or ux * vx + uy * vy >= 0 or min(ux * ux + uy * uy, vx * vx + vy * vy) <= corner * corner:
            return t
        return t - now / slope if slope < 0 else math.inf
    if now < 0 or (now == 0 and slope <= 0):
        return t
    end = -at / slope if slope < 0 else math.inf
    if turn < 0:
        ux, uy, vx, vy = vx, vy, ux, uy
    at, slope = ux * py - uy * px, ux * dy - uy * dx
    now = at + t * slope
    if now < 0 or (now == 0 and slope <= 0):
        return t
    if slope < 0:
        end = min(end, -at / slope)
    at, slope = px * vy - py * vx, dx * vy - dy * vx
    now = at + t * slope
    if now < 0 or (now == 0 and slope <= 0):
        return t
    return min(end, -at / slope) if slope < 0 else end


@compiled
def range_interval(px: float, py: float, dx: float, dy: float, reach: float, square: int) -> tuple[float, float]:
    """First and last leg parameter at which the origin is in range of p + t d; first > last when it never is."""
    first, last = 0.0, 1.0
    if square:
        for axis in range(2):
            p, d = (px, dx) if axis == 0 else (py, dy)
            if abs(d) < 1e-12:
                if abs(p) > reach:
                    return 1.0, 0.0
                continue
            t0, t1 = (-reach - p) / d, (reach - p) / d
            first, last = max(first, min(t0, t1)), min(last, max(t0, t1))
        return first, last
    aa = dx * dx + dy * dy
    ab = px * dx + py * dy
    cc = px * px + py * py - reach * reach
    if aa < STANDING_M2:
        return (0.0, 1.0) if cc <= 0 else (1.0, 0.0)
    under = ab * ab - aa * cc
    if under < 0:
        return 1.0, 0.0
    root = math.sqrt(under)
    return max(0.0, (-ab - root) / aa), min(1.0, (-ab + root) / aa)


@inlined
def in_sight(
    px: float, py: float, dx: float, dy: float, near: float, reach: float, square: int, cx: float, cy: float,
    walls: Any, items: Any, begin: int, end: int, corner: float,
) -> bool:  # fmt: skip
    """Whether c is in range and not hidden somewhere on a leg that starts at c + p and runs along d.

    near: a leg parameter in range, where sight is likeliest: mostly one look from there is enough.
    """
    hidden = False
    for j in range(begin, end):
        k = items[j]
        ux, uy, vx, vy = walls[k, 0] - cx, walls[k, 1] - cy, walls[k, 2] - cx, walls[k, 3] - cy
        if hidden_until(near, ux, uy, vx, vy, px, py, dx, dy, corner) > near:
            hidden = True
            break
    if not hidden:
        return True
    if dx * dx + dy * dy < STANDING_M2:
        return False
    t, last = range_interval(px, py, dx, dy, reach, square)
    moved = True
    while moved:
        moved = False
        for j in range(begin, end):
            k = items[j]
            ux, uy, vx, vy = walls[k, 0] - cx, walls[k, 1] - cy, walls[k, 2] - cx, walls[k, 3] - cy
            until = hidden_until(t, ux, uy, vx, vy, px, py, dx, dy, corner)
            if until > t:
                if until >= last:
                    return False
                t = until + 1e-12
                moved = True
    return True


@inlined
def square_row(
    ax: float, ay: float, dx: float, dy: float, per_dy: float, reach: float, y: float
) -> tuple[float, float]:  # fmt: skip
    """Least and greatest x at height y that a square's range sweeps on the leg from a along d; first > last: none."""
    first, last = 0.0, 1.0
    if dy == 0.0:
        if abs(y - ay) > reach:
            return 1.0, 0.0
    else:
        t0, t1 = (y - reach - ay) * per_dy, (y + reach - ay) * per_dy
        first, last = max(0.0, min(t0, t1)), min(1.0, max(t0, t1))
        if first > last:
            return 1.0, 0.0
    x0, x1 = ax + first * dx, ax + last * dx
    return min(x0, x1) - reach, max(x0, x1) + reach


@inlined
def disc_row(
    ax: float, ay: float, dx: float, dy: float, per_dy: float, nx: float, ny: float, reach: float, y: float
) -> tuple[float, float]:
    """Least and greatest x at height y that a disc's range sweeps on the leg from a along d; first > last: none.

    (nx, ny): across the leg, as long as the reach.
    """
    left, right = math.inf, -math.inf
    up = y - ay
    under = reach * reach - up * up
    if under >= 0:
        wide = math.sqrt(under)
        left, right = ax - wide, ax + wide
    up -= dy
    under = reach * reach - up * up
    if under >= 0:
        wide = math.sqrt(under)
        left, right = min(left, ax + dx - wide), max(right, ax + dx + wide)
    if dy != 0.0:
        # the straight sides of the lane
        t = (y - ay - ny) * per_dy
        if 0 <= t <= 1:
            x = ax + nx + t * dx
            left, right = min(left, x), max(right, x)
        t = (y - ay + ny) * per_dy
        if 0 <= t <= 1:
            x = ax - nx + t * dx
            left, right = min(left, x), max(right, x)
    return left, right


@inlined
def nearest_in_range(
    px: float, py: float, dx: float, dy: float, per_aa: float, reach: float, square: int, slack: float
) -> float:
    """A leg parameter (of p + t d) at which the origin is in range, near its nearest approach; -1 when there is none.

    slack: squared metres by which a disc may fall short, for what was found in range by another formula.
    """
    t = 0.0
    if per_aa > 0:
        t = -(px * dx + py * dy) * per_aa
        t = 0.0 if t < 0 else (1.0 if t > 1 else t)
    if square:
        first, last = range_interval(px, py, dx, dy, reach, square)
        if first > last:
            return -1.0
        return first if t < first else (last if t > last else t)
    qx, qy = px + t * dx, py + t * dy
    return t if qx * qx + qy * qy <= reach * reach + slack else -1.0


@compiled
def leg_sees(
    ax: float, ay: float, bx: float, by: float, reach: float, square: int, serves: int, s: Samples, out: Any
) -> int:
    """Write what the leg a-b sees of the samples of period class >= serves, as runs: first index, one past the last.

    Returns how many numbers were written, two for each run, or -1 if ``out`` is short. No two runs share a sample.
    """
    found = lattice_runs(ax, ay, bx, by, reach, square, serves, s, out)
    if found < 0:
        return found
    return loose_runs(ax, ay, bx, by, reach, square, serves, s, out, found)


@compiled
def lattice_runs(
    ax: float, ay: float, bx: float, by: float, reach: float, square: int, serves: int, s: Samples, out: Any
) -> int:
    """The part of ``leg_sees`` that lies on lattices: row by row, one look at a time only where walls are near."""
    xs, ys = s.x, s.y
    wall_start, wall_item, walls, next_walled = s.wall_start, s.wall_item, s.walls, s.next_walled
    frames, ints, column_start, corner = s.frames, s.frame_ints, s.column_start, s.origin[4]
    dx, dy = bx - ax, by - ay
    aa = dx * dx + dy * dy
    per_aa = 1 / aa if aa >= STANDING_M2 else 0.0
    per_dy = 1 / dy if dy != 0.0 else 0.0
    per_leg = 1 / math.sqrt(aa) if aa > 0 else 0.0
    found, room = 0, out.shape[0] - 1
    for f in range(frames.shape[0]):
        r = reach - frames[f, 3]
        if ints[f, 0] < serves or r < 0:
            continue
        left, low, step = frames[f, 0], frames[f, 1], frames[f, 2]
        rows, columns, table = ints[f, 1], ints[f, 2], ints[f, 3]
        row0 = max(0, math.ceil((min(ay, by) - r - low) / step))
        row1 = min(rows - 1, math.floor((max(ay, by) + r - low) / step))
        if max(ax, bx) + r < left or min(ax, bx) - r > left + columns * step:
            continue
        per_step = 1 / step
        nx, ny = -dy * per_leg * r, dx * per_leg * r
        for row in range(row0, row1 + 1):
            y = low + row * step
            if square:
                x0, x1 = square_row(ax, ay, dx, dy, per_dy, r, y)
            else:
                x0, x1 = disc_row(ax, ay, dx, dy, per_dy, nx, ny, r, y)
            if x0 > x1 or x1 < left or x0 > left + columns * step:
                continue
            c0 = max(0, math.ceil((x0 - left) * per_step))
            c1 = min(columns, math.floor((x1 - left) * per_step) + 1)
            if c0 >= c1:
                continue
            at = table + row * (columns + 1)
            i, end = np.int64(column_start[at + c0]), np.int64(column_start[at + c1])
            while i < end:
                until = min(end, next_walled[i])
                if until == i:
                    cx, cy = xs[i], ys[i]
                    px, py = ax - cx, ay - cy
                    t = nearest_in_range(px, py, dx, dy, per_aa, r, square, TOUCH_M)
                    first, last = wall_start[i], wall_start[i + 1]
                    if t < 0 or not in_sight(
                        px, py, dx, dy, t, r, square, cx, cy, walls, wall_item, first, last, corner
                    ):
                        i += 1
                        continue
                    until = i + 1
                if found > 0 and out[found - 1] == i:
                    out[found - 1] = until
                else:
                    if found >= room:
                        return -1
                    out[found], out[found + 1] = i, until
                    found += 2
                i = until
    return found


@compiled
def loose_runs(
    ax: float, ay: float, bx: float, by: float, reach: float, square: int, serves: int, s: Samples, out: Any, found: int
) -> int:
    """The part of ``leg_sees`` that lies on no lattice, bin by bin; ``found`` numbers have been written before."""
    # local names: the loop below runs over everything near every leg that is ever tried
    xs, ys, period, visit, shrink = s.x, s.y, s.period, s.visit_m, s.shrink_m
    wall_start, wall_item, walls, bin_start = s.wall_start, s.wall_item, s.walls, s.bin_start
    left, low, cell, farthest, corner = s.origin[0], s.origin[1], s.origin[2], s.origin[3], s.origin[4]
    columns, rows = s.bins[0], s.bins[1]
    far = max(reach * (1.4142135623730951 if square else 1.0), farthest)
    x0 = max(0, int((min(ax, bx) - far - left) / cell))
    x1 = min(columns - 1, int((max(ax, bx) + far - left) / cell))
    y0 = max(0, int((min(ay, by) - far - low) / cell))
    y1 = min(rows - 1, int((max(ay, by) + far - low) / cell))
    dx, dy = bx - ax, by - ay
    aa = dx * dx + dy * dy
    per_aa = 1 / aa if aa >= STANDING_M2 else 0.0
    room = out.shape[0] - 1
    if x0 > x1:
        return found
    for row in range(y0, y1 + 1):
        # the bins of a row follow each other, and most are empty
        for i in range(bin_start[row * columns + x0], bin_start[row * columns + x1 + 1]):
            if period[i] < serves:
                continue
            cx, cy = xs[i], ys[i]
            px, py = ax - cx, ay - cy
            r, wide = reach - shrink[i], square
            if visit[i] > 0:
                r, wide = visit[i], 0
            t = nearest_in_range(px, py, dx, dy, per_aa, r, wide, 0.0)
            if t < 0:
                continue
            first, last = wall_start[i], wall_start[i + 1]
            if (
                visit[i] == 0
                and last > first
                and not in_sight(px, py, dx, dy, t, r, wide, cx, cy, walls, wall_item, first, last, corner)
            ):
                continue
            if found > 0 and out[found - 1] == i:
                out[found - 1] = i + 1
                continue
            if found >= room:
                return -1
            out[found], out[found + 1] = i, i + 1
            found += 2
    return found

"""Compiled loops of the patrol planner: what a leg sees. Arrays are float64 and int64: one compilation serves all."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.ground.sight_kernels import STANDING_M2, TOUCH_M, compiled, in_sight, inlined, range_interval

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Index = np.uint64  # in the hottest loops: each index that may be negative costs a look whether it is


class Samples(NamedTuple):
    """Points that must be seen: those of lattices row by row, then all others by bins; see ``samples.py``.

    depth2: how far each sees in each sector of directions; see ``depth_kernels.py``.
    """

    x: Floats
    y: Floats
    weight: Floats
    period: Ints
    visit_m: Floats
    shrink_m: Floats
    wall_start: Ints
    wall_item: Ints
    walls: Floats
    depth2: NDArray[np.float32]
    next_walled: Ints
    frames: Floats
    frame_ints: Ints
    column_start: NDArray[np.int32]
    bin_start: Ints
    origin: Floats
    bins: Ints


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
    depth2 = s.depth2
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
                        px, py, dx, dy, t, r, square, cx, cy, walls, wall_item, first, last, corner, depth2, i
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
    wall_start, wall_item, walls, bin_start, depth2 = s.wall_start, s.wall_item, s.walls, s.bin_start, s.depth2
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
                and not in_sight(px, py, dx, dy, t, r, wide, cx, cy, walls, wall_item, first, last, corner, depth2, i)
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

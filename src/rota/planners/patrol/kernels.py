"""Compiled loops of the patrol planner: what a leg sees. Arrays are float64 and int64: one compilation serves all."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STANDING_M2 = 1e-18  # a leg with less length (squared) is a place where the robot stands
TOUCH_M = 1e-7  # a sample this close to a wall lies on it: that wall does not hide it


class Samples(NamedTuple):
    """Points that must be seen, sorted by bin; see ``samples.py`` for shapes and units."""

    x: Floats
    y: Floats
    weight: Floats
    period: Ints
    visit_m: Floats
    shrink_m: Floats
    wall_start: Ints
    wall_item: Ints
    walls: Floats
    bin_start: Ints
    origin: Floats
    bins: Ints


@njit(cache=True, error_model="numpy")
def norm(dx: float, dy: float) -> float:
    """Length of a vector; the library's hypot guards against overflow, which costs more than all the rest here."""
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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


# numba counts references to every array it passes to a function: inlined, since that cost four times the work itself
@njit(cache=True, error_model="numpy", inline="always")
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


@njit(cache=True, error_model="numpy")
def leg_sees(
    ax: float, ay: float, bx: float, by: float, reach: float, square: int, serves: int, s: Samples, out: Any
) -> int:
    """Write the samples of period class >= serves that the leg a-b sees; return how many, or -1 if out is short."""
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
    out_of_lane = (far + 0.7072 * cell) * math.sqrt(aa)
    found = 0
    room = out.shape[0]
    for row in range(y0, y1 + 1):
        my = low + (row + 0.5) * cell - ay
        for col in range(x0, x1 + 1):
            mx = left + (col + 0.5) * cell - ax
            if abs(dx * my - dy * mx) > out_of_lane and aa > STANDING_M2:
                continue
            b = row * columns + col
            for i in range(bin_start[b], bin_start[b + 1]):
                px, py = ax - xs[i], ay - ys[i]
                r = reach - shrink[i]
                wide = square
                if visit[i] > 0:
                    r, wide = visit[i], 0
                t = 0.0
                if aa >= STANDING_M2:
                    t = -(px * dx + py * dy) * per_aa
                    t = 0.0 if t < 0 else (1.0 if t > 1 else t)
                if wide:
                    first, last = range_interval(px, py, dx, dy, r, wide)
                    if first > last:
                        continue
                    t = first if t < first else (last if t > last else t)
                else:
                    qx, qy = px + t * dx, py + t * dy
                    if qx * qx + qy * qy > r * r:
                        continue
                if period[i] < serves:
                    continue
                if (
                    visit[i] == 0
                    and wall_start[i + 1] > wall_start[i]
                    and not in_sight(
                        px,
                        py,
                        dx,
                        dy,
                        t,
                        r,
                        wide,
                        xs[i],
                        ys[i],
                        walls,
                        wall_item,
                        wall_start[i],
                        wall_start[i + 1],
                        corner,
                    )
                ):
                    continue
                if found == room:
                    return -1
                out[found] = i
                found += 1
    return found

"""Compiled loops that ask whether a point is in range and in sight of a leg, past walls."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import njit

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True, "_nrt": False}
STANDING_M2 = 1e-18  # a leg with less length (squared) is a place where the robot stands
TOUCH_M = 1e-7  # a sample this close to a wall lies on it: that wall does not hide it
DEPTH_SECTORS = 32  # of directions round a sample, a multiple of 4


def compiled(function: Callable[..., Any]) -> Any:
    """A compiled function that allocates no array.

    Such functions pass tuples of many arrays to each other; to count references to every array on every call (numba's
    runtime, "nrt") would take more time than all the rest.
    """
    return njit(**OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """A compiled function that becomes part of its callers."""
    return njit(**OPTIONS, inline="always")(function)


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


@compiled
def turned(x: float, y: float) -> float:
    """How far a direction is turned from the x axis to the left, in sectors (0 for none), which are not quite alike."""
    whole = abs(x) + abs(y)
    if whole == 0:
        return 0.0
    along = y / whole if y >= 0 else 2 - y / whole
    if x < 0 <= y or (x >= 0 and y < 0):
        along = 1 - x / whole if y >= 0 else 3 + x / whole
    return along * (DEPTH_SECTORS / 4)


@compiled
def all_hidden(ax: float, ay: float, bx: float, by: float, near2: float, depth2: Any, i: int) -> bool:
    """Whether all of a leg from a to b is known to be hidden from sample i; near2: squared metres to its nearest."""
    k, last = int(turned(ax, ay)) % DEPTH_SECTORS, int(turned(bx, by)) % DEPTH_SECTORS
    step = 1 if ax * by - ay * bx >= 0 else DEPTH_SECTORS - 1
    while depth2[i, 1, k] < near2:
        if k == last:
            return True
        k = (k + step) % DEPTH_SECTORS
    return False


@inlined
def in_sight(
    px: float, py: float, dx: float, dy: float, near: float, reach: float, square: int, cx: float, cy: float,
    walls: Any, items: Any, begin: int, end: int, corner: float, depth2: Any, i: int,
) -> bool:  # fmt: skip
    """Whether c, sample i, is in range and not hidden somewhere on a leg that starts at c + p and runs along d.

    near: a leg parameter in range, where sight is likeliest: mostly one look from there is enough, and mostly the
    depths tell what comes of it; they change nothing of the answer.
    """
    qx, qy = px + near * dx, py + near * dy
    near2 = qx * qx + qy * qy
    if near2 < depth2[i, 0, int(turned(qx, qy)) % DEPTH_SECTORS]:
        return True
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
    if all_hidden(px + t * dx, py + t * dy, px + last * dx, py + last * dy, near2, depth2, i):
        return False
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

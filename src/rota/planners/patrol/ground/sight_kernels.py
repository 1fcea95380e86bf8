"""Compiled questions about one point and one leg: when the point is in range, and how long a wall hides it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.patrol.tolerances import ON_LINE_M, SAME_PLACE_M

DEPTH_SECTORS = 32  # of directions round a sample, a multiple of 4


class Line(NamedTuple):
    """A leg as a point sees it: from p along d, in metres, with the point at the origin. Places on it are p + t d."""

    px: float
    py: float
    dx: float
    dy: float


@allocation_free
def norm(dx: float, dy: float) -> float:
    """Length of a vector; the library's hypot guards against overflow, which costs more than all the rest here."""
    return math.sqrt(dx * dx + dy * dy)


@allocation_free
def end_of_hiding(t: float, ux: float, uy: float, vx: float, vy: float, line: Line, corner: float) -> float:
    """End of the interval of leg parameters round ``t`` in which a wall hides the origin, or t if it does not.

    The wall runs from u to v with its obstacle on the left, in metres from the hidden point. A point that lies on the
    wall, farther than ``corner`` metres from its ends, is hidden from the obstacle's side.
    """
    px, py, dx, dy = line.px, line.py, line.dx, line.dy
    wx, wy = vx - ux, vy - uy
    turn = ux * vy - uy * vx
    if turn < 0:
        wx, wy = -wx, -wy
    # the shadow is where all three are positive: behind the wall, and between the rays through its ends
    at, slope = wy * (px - ux) - wx * (py - uy), wy * dx - wx * dy
    now = at + t * slope
    if turn * turn <= ON_LINE_M * ON_LINE_M * (wx * wx + wy * wy):
        if turn >= 0:  # the sign above is for the side away from the point; the side of the obstacle counts here
            at, slope, now = -at, -slope, -now
        now -= ON_LINE_M * norm(wx, wy)
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


@allocation_free
def range_interval(line: Line, reach: float, square: int) -> tuple[float, float]:
    """First and last leg parameter at which the origin is in range; first > last when it never is.

    reach: metres, a disc's radius or, with ``square``, half a square's side.
    """
    px, py, dx, dy = line.px, line.py, line.dx, line.dy
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
    if aa < SAME_PLACE_M * SAME_PLACE_M:
        return (0.0, 1.0) if cc <= 0 else (1.0, 0.0)
    under = ab * ab - aa * cc
    if under < 0:
        return 1.0, 0.0
    root = math.sqrt(under)
    return max(0.0, (-ab - root) / aa), min(1.0, (-ab + root) / aa)


@always_inline
def nearest_in_range(line: Line, per_aa: float, reach: float, square: int, slack: float) -> float:
    """A leg parameter at which the origin is in range, near its nearest approach; -1 when there is none.

    per_aa: 1 / (d . d), or 0 for a leg without length. slack: squared metres by which a disc may fall short, for points
    that another formula told to be in range.
    """
    px, py, dx, dy = line.px, line.py, line.dx, line.dy
    t = 0.0
    if per_aa > 0:
        t = -(px * dx + py * dy) * per_aa
        t = 0.0 if t < 0 else (1.0 if t > 1 else t)
    if square:
        first, last = range_interval(line, reach, square)
        if first > last:
            return -1.0
        return first if t < first else (last if t > last else t)
    qx, qy = px + t * dx, py + t * dy
    return t if qx * qx + qy * qy <= reach * reach + slack else -1.0


@allocation_free
def sectors_from_x(x: float, y: float) -> float:
    """How far a direction is turned from the x axis to the left, in sectors (0 for none), which are not quite alike."""
    whole = abs(x) + abs(y)
    if whole == 0:
        return 0.0
    along = y / whole if y >= 0 else 2 - y / whole
    if x < 0 <= y or (x >= 0 and y < 0):
        along = 1 - x / whole if y >= 0 else 3 + x / whole
    return along * (DEPTH_SECTORS / 4)


@allocation_free
def hides_all(ax: float, ay: float, bx: float, by: float, near2: float, depth2: Any, row: int) -> bool:
    """Whether all of a leg from a to b, in metres from a sample, is known to be hidden from it.

    near2: squared metres to the leg's nearest place. depth2: (w, 2, DEPTH_SECTORS), as ``depth_kernels.depths`` tells;
    row: the sample's.
    """
    k, last = int(sectors_from_x(ax, ay)) % DEPTH_SECTORS, int(sectors_from_x(bx, by)) % DEPTH_SECTORS
    step = 1 if ax * by - ay * bx >= 0 else DEPTH_SECTORS - 1
    while depth2[row, 1, k] < near2:
        if k == last:
            return True
        k = (k + step) % DEPTH_SECTORS
    return False

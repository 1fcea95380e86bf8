# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled questions about very many segments from one point: what bars one mostly bars the next ones too."""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.geometry.kernels import OUTSIDE, TOUCH_M, contacts_of, meets_between_touches

SECTORS = 256  # of directions, a multiple of 4, each with the edge that barred the last segment there
BESIDE = 8  # edges before and after that one, along its border, that are tried too
SURE_M = 2 * TOUCH_M  # an edge that reaches so far past a segment, on both sides, properly crosses it


@allocation_free
def _sector(dx, dy):
    """The sector of a direction, not all of them alike in width; dx and dy are not both 0."""
    along = dx / (abs(dx) + abs(dy))
    return int((SECTORS // 4) * (1.0 - along if dy >= 0.0 else 3.0 + along)) % SECTORS


@allocation_free
def _surely_crosses(ax, ay, dx, dy, edges, k):
    """Whether edge k surely crosses the segment from a along d; it takes no root and no division."""
    ex, ey, fx, fy = edges[k, 0] - ax, edges[k, 1] - ay, edges[k, 2] - ax, edges[k, 3] - ay
    one, other = dx * ey - dy * ex, dx * fy - dy * fx
    if one * other >= 0.0 or min(one * one, other * other) <= SURE_M * SURE_M * (dx * dx + dy * dy):
        return False
    wx, wy = fx - ex, fy - ey
    begin = wy * ex - wx * ey
    end = begin + wx * dy - wy * dx
    return begin * end < 0.0 and min(begin * begin, end * end) > SURE_M * SURE_M * (wx * wx + wy * wy)


@kernel(noinline=True)
def segment_is_free_too(ax, ay, bx, by, grid, bars):
    """``segment_is_free`` for one of many segments from the point a.

    bars: (SECTORS,) -1 before the first, then the edges that barred the last ones. A segment that properly crosses one
    is barred, and so the walk through the cells that would find such an edge is mostly spared.
    """
    dx, dy = bx - ax, by - ay
    if dx**2 + dy**2 <= TOUCH_M * TOUCH_M:
        return True
    sector, edges = _sector(dx, dy), grid.edges
    bar = bars[sector]
    if bar >= 0:
        if _surely_crosses(ax, ay, dx, dy, edges, bar):
            return False
        for k in range(max(bar - BESIDE, 0), min(bar + BESIDE + 1, len(edges))):
            if _surely_crosses(ax, ay, dx, dy, edges, k):
                bars[sector] = k
                return False
    count = contacts_of(ax, ay, bx, by, grid, edges[:0])
    if count < 0:
        bars[sector] = -1 - count
    if count <= 0:
        return count == 0
    return not meets_between_touches(ax, ay, bx, by, grid, count, np.int64(OUTSIDE))

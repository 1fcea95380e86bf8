# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the visibility graph: which corners see each other, and lengths of paths over them.

Corners are rows x, y, then the border corners before and after, (c, 6) metres, with the space on the left.
"""

from __future__ import annotations

from math import hypot, inf

import numpy as np
from numba import njit

from rota.geometry.kernels import TOUCH_M, segment_is_free


@njit(cache=True)
def _can_bend(px, py, corner):
    """Whether a shortest path coming straight from the point may bend at the corner: its line is a tangent there."""
    dx, dy = corner[0] - px, corner[1] - py
    slack = TOUCH_M * hypot(dx, dy)
    before = dx * (corner[3] - corner[1]) - dy * (corner[2] - corner[0])
    after = dx * (corner[5] - corner[1]) - dy * (corner[4] - corner[0])
    return not ((before > slack and after < -slack) or (before < -slack and after > slack))


@njit(cache=True)
def bitangents(corners, corner_part, grid):
    """(c, c) bool: corners of one part that see each other along a line that is a tangent at both."""
    c = len(corners)
    linked = np.zeros((c, c), np.bool_)
    for k in range(c):
        one = corners[k]
        for m in range(k):
            other = corners[m]
            if corner_part[k] != corner_part[m] or not _can_bend(one[0], one[1], other):
                continue
            if _can_bend(other[0], other[1], one) and segment_is_free(one[0], one[1], other[0], other[1], grid):
                linked[k, m] = linked[m, k] = True
    return linked


@njit(cache=True)
def tangents(points, part, corners, corner_part, grid):
    """(n, c) bool: the corners of its own part that each point sees along a tangent."""
    linked = np.zeros((len(points), len(corners)), np.bool_)
    for k in range(len(points)):
        px, py = points[k]
        for m in range(len(corners)):
            if part[k] == corner_part[m] and _can_bend(px, py, corners[m]):
                linked[k, m] = segment_is_free(px, py, corners[m, 0], corners[m, 1], grid)
    return linked


@njit(cache=True)
def _lengths_to_corners(px, py, linked, corners, between, lengths):
    """Fill lengths (c,) with those of the shortest paths from the point, by way of its links, to each corner."""
    lengths[:] = inf
    for m in linked:
        first = hypot(corners[m, 0] - px, corners[m, 1] - py)
        for n in range(len(lengths)):
            lengths[n] = min(lengths[n], first + between[m, n])


@njit(cache=True)
def path_lengths(a, part_a, start_a, items_a, b, part_b, start_b, items_b, corners, between, grid, symmetric):
    """(n, m) lengths of shortest paths, inf between different parts; part -1 is outside and reaches nothing.

    start, items: the corners linked to point k are items[start[k] : start[k + 1]]. symmetric: a and b are the same.
    """
    found = np.full((len(a), len(b)), inf)
    lengths = np.empty(len(corners))
    for k in range(len(a)):
        ax, ay = a[k]
        known = False
        for m in range(k if symmetric else 0, len(b)):
            if part_a[k] < 0 or part_a[k] != part_b[m]:
                continue
            bx, by = b[m]
            best = inf
            if segment_is_free(ax, ay, bx, by, grid):
                best = hypot(bx - ax, by - ay)
            else:
                if not known:
                    _lengths_to_corners(ax, ay, items_a[start_a[k] : start_a[k + 1]], corners, between, lengths)
                    known = True
                for n in items_b[start_b[m] : start_b[m + 1]]:
                    best = min(best, lengths[n] + hypot(corners[n, 0] - bx, corners[n, 1] - by))
            found[k, m] = best
            if symmetric:
                found[m, k] = best
    return found

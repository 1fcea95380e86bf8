# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that keep the moment at which each place was last seen, and find the gaps that were too long."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.check.kernels import part_in_range
from rota.check.tiling_kernels import cell_along
from rota.compiled.kernel import kernel
from rota.geometry.kernels import point_in_space, point_sees_point, segment_is_free
from rota.model.arrays import Flags, Floats


class Driven(NamedTuple):
    """What robots drove: legs_m (m, 4), when each began and ended, times_s (m, 2), and what was seen from it.

    reaches_m: (m,) radii, or half sides where squares (m,) is set.
    """

    legs_m: Floats
    times_s: Floats
    reaches_m: Floats
    squares: Flags


@kernel
def _shares_in_sight(piece, leg, reach_m, square, walls):
    """The first and last share of a leg (4,), of three that are tried, from which a point (1, 2) is seen.

    Tried are the first, the middle and the last share from which the point is in range. 1, 0: none of them.
    """
    lo, hi = part_in_range(piece, leg, reach_m, square)
    if lo > hi or not len(walls.edges):
        return lo, hi
    first, last = 1.0, 0.0
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    for share in (lo, (lo + hi) / 2, hi):
        if point_sees_point(leg[0] + share * dx, leg[1] + share * dy, piece[0, 0], piece[0, 1], walls):
            first, last = min(first, share), share
    return first, last


@kernel
def see_along(driven, points, grid, near, walls, first_s, last_s):
    """Note the first and last moments at which points are seen along what was driven.

    points: (n, 2), found through ``near`` in ``grid``. first_s, last_s: (n,) are lowered and raised.
    """
    piece = np.empty((1, 2))
    for m in range(len(driven.legs_m)):
        leg, reach = driven.legs_m[m], driven.reaches_m[m]
        t0, t1 = driven.times_s[m, 0], driven.times_s[m, 1]
        left = cell_along(min(leg[0], leg[2]) - reach - grid.x0_m, grid.cell_m, grid.columns)
        right = cell_along(max(leg[0], leg[2]) + reach - grid.x0_m, grid.cell_m, grid.columns)
        low = cell_along(min(leg[1], leg[3]) - reach - grid.y0_m, grid.cell_m, grid.rows)
        high = cell_along(max(leg[1], leg[3]) + reach - grid.y0_m, grid.cell_m, grid.rows)
        for i in range(left, right + 1):
            # the cells of a column follow each other
            begin, end = near.offsets[i * grid.rows + low], near.offsets[i * grid.rows + high + 1]
            for p in near.items[begin:end]:
                if first_s[p] <= t0 and last_s[p] >= t1:
                    continue
                piece[0, 0], piece[0, 1] = points[p, 0], points[p, 1]
                first, last = _shares_in_sight(piece, leg, reach, driven.squares[m], walls)
                if first <= last:
                    first_s[p] = min(first_s[p], t0 if first == 0.0 else t0 + first * (t1 - t0))
                    last_s[p] = max(last_s[p], t1 if last == 1.0 else t0 + last * (t1 - t0))


@kernel
def visits_along(legs, times_s, space, first_s, last_s):
    """The first and last moment at which one of the legs (m, 4) is in a closed space, and those given before.

    A leg that enters or leaves the space counts at its end inside, one that only crosses it at its beginning.
    """
    for m in range(len(legs)):
        x0, y0, x1, y1 = legs[m, 0], legs[m, 1], legs[m, 2], legs[m, 3]
        begins, ends = point_in_space(x0, y0, space), point_in_space(x1, y1, space)
        if begins or (not ends and not segment_is_free(x0, y0, x1, y1, space)):
            first_s, last_s = min(first_s, times_s[m, 0]), max(last_s, times_s[m, 0])
        if ends:
            first_s, last_s = min(first_s, times_s[m, 1]), max(last_s, times_s[m, 1])
    return first_s, last_s


@kernel
def close_gaps(first_s, last_s, last_seen_s, demand, gaps_s, where):
    """Move last_seen_s (n,) on to last_s (n,) and note each demand's worst gap that this ends, and its place.

    gaps_s, where: (demands,) the worst gap so far and its place. first_s, last_s: (n,) are emptied.
    """
    for p in range(len(last_seen_s)):
        if last_s[p] > last_seen_s[p]:
            gap = first_s[p] - last_seen_s[p]
            if gap > gaps_s[demand[p]]:
                gaps_s[demand[p]], where[demand[p]] = gap, p
            last_seen_s[p] = last_s[p]
        first_s[p], last_s[p] = math.inf, -math.inf


@kernel
def oldest(last_seen_s, demand, demands):
    """For each demand the place (demands,) that was seen longest ago, -1 without one, the first of several."""
    where = np.full(demands, -1, np.int64)
    since = np.full(demands, math.inf)
    for p in range(len(last_seen_s)):
        k = demand[p]
        if last_seen_s[p] < since[k]:
            since[k], where[k] = last_seen_s[p], p
    return where

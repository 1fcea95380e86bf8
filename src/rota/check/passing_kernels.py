# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops for pieces that no one view takes in whole, but of which a robot sees each point as it passes.

Behind a slit each point is seen from a part of the leg of its own: the nearer to the line through the slit's two
corners, the shorter that part, so that no piece that touches the line is ever seen whole, however small it is.

Let all of a part lo..hi of a leg be in range of all of a piece, and let each wall hide from each point q of the piece
no more than what comes before a place a(q) of that part (a wall before), or what comes after a place b(q) (a wall
behind): those where the line from q through one end of the wall meets the leg. Then q is seen from somewhere on the
part if a(q) <= b(q) for each wall before and each wall behind, with lo as one more a and hi as one more b (intervals
of which every two meet have a common point). For two ends c and d, a(q) <= b(q) says on which side of the line through
c and d the point q lies, so that all q of a convex piece do if its corners do.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from rota.check.gap_kernels import team_gap
from rota.check.kernels import LOOP, blocked_part, leg_sights, part_in_range, shadows_of, shrunk
from rota.check.tiling_kernels import cell_along

APART_M = 1e-7  # corners nearer than this are one corner, and no slit lies between them
SAME_S = 1e-9  # legs of robots that follow each other take the same time, but for rounding


@njit(cache=True)
def _cross(ax, ay, bx, by):
    return ax * by - ay * bx


@njit(cache=True)
def _ends(wall, piece, slack_m, turn):
    """The ends of a wall, (first x, y, last x, y) as the piece sees the leg run, and whether they are sure.

    turn: 1 where the leg runs counterclockwise, -1 where clockwise. They are sure where the piece lies on one side of
    the wall's line.
    """
    wx, wy = wall[2] - wall[0], wall[3] - wall[1]
    length = math.hypot(wx, wy)
    low, high = math.inf, -math.inf
    for i in range(len(piece)):
        side = _cross(wx, wy, piece[i, 0] - wall[0], piece[i, 1] - wall[1]) / length
        low, high = min(low, side), max(high, side)
    left = low >= -slack_m
    sure = left or high <= slack_m
    if left == (turn > 0):
        return wall[0], wall[1], wall[2], wall[3], sure
    return wall[2], wall[3], wall[0], wall[1], sure


@njit(cache=True)
def _ahead(piece, ahead_x, ahead_y, x, y):
    """Whether (x, y) lies ahead of all of the piece."""
    least = math.inf
    for q in range(len(piece)):
        least = min(least, ahead_x * (x - piece[q, 0]) + ahead_y * (y - piece[q, 1]))
    return least > 0


@njit(cache=True)
def _end_of_hidden(wall, piece, middle, slack_m, turn, ahead_x, ahead_y, px, py):
    """Which part of the leg a wall hides: 1 before (x, y) as each point of the piece sees it, -1 behind it, 0: unclear.

    (px, py): a place on the leg that the middle of the piece sees.
    """
    first_x, first_y, last_x, last_y, sure = _ends(wall, piece, slack_m, turn)
    x, y = px - middle[0], py - middle[1]
    if sure and turn * _cross(last_x - middle[0], last_y - middle[1], x, y) >= 0:
        return (1 if _ahead(piece, ahead_x, ahead_y, last_x, last_y) else 0), last_x, last_y
    if sure and turn * _cross(first_x - middle[0], first_y - middle[1], x, y) <= 0:
        return (-1 if _ahead(piece, ahead_x, ahead_y, first_x, first_y) else 0), first_x, first_y
    return 0, 0.0, 0.0


@njit(cache=True)
def _in_order(piece, turn, before, behind):
    """Whether a(q) <= b(q) for all corners q of the piece and all ends (n, 2) of walls before and (m, 2) behind."""
    for i in range(len(before)):
        for j in range(len(behind)):
            if math.hypot(before[i, 0] - behind[j, 0], before[i, 1] - behind[j, 1]) < APART_M:
                return False
            for q in range(len(piece)):
                x, y = piece[q, 0], piece[q, 1]
                if turn * _cross(before[i, 0] - x, before[i, 1] - y, behind[j, 0] - x, behind[j, 1] - y) < 0:
                    return False
    return True


@njit(cache=True)
def _seen_round(place, piece, middle, leg, lo, hi, walls, shadows, index, n_shadows, slack_m):
    """Whether each point of the piece is seen from somewhere on the leg round a place of it, in 0..1."""
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    px, py = leg[0] + place * dx, leg[1] + place * dy
    turn = 1.0 if _cross(leg[0] - middle[0], leg[1] - middle[1], dx, dy) > 0 else -1.0
    ahead_x, ahead_y = turn * dy, -turn * dx
    if not _ahead(piece, ahead_x, ahead_y, px, py):
        return False
    before, behind = np.empty((n_shadows + 1, 2)), np.empty((n_shadows + 1, 2))
    n_before, n_behind = 1, 1
    for w in range(n_shadows):
        start, stop = blocked_part(shadows[w], leg, lo, hi)
        if not start < stop:
            continue
        kind, x, y = _end_of_hidden(walls[index[w]], piece, middle, slack_m, turn, ahead_x, ahead_y, px, py)
        if kind == 1:
            before[n_before] = (x, y)
            n_before += 1
        elif kind == -1:
            behind[n_behind] = (x, y)
            n_behind += 1
        elif stop <= place:
            lo = stop
        elif start >= place:
            hi = start
        else:
            return False
    before[0], behind[0] = (leg[0] + lo * dx, leg[1] + lo * dy), (leg[0] + hi * dx, leg[1] + hi * dy)
    return _in_order(piece, turn, before[:n_before], behind[:n_behind])


@njit(cache=True)
def _gap_of_followers(
    first, which, legs, leg_times_s, leg_robots, reaches_m, squares, classes, parts, units_s, limit_s, from_s
):
    """Worst gap between looks at one point by all robots that drive the same leg as the first, one after the other.

    which: the legs from which each point of a piece is seen, robot by robot. Robots with another sensor may see the
    point from another place of the leg, and do not count.
    """
    leader = leg_robots[first]
    lasts_s = leg_times_s[first, 1] - leg_times_s[first, 0]
    ends, robots = np.empty(len(which)), np.empty(len(which), np.int64)
    bounds = np.zeros(len(which) + 1, np.int64)
    n = np.int64(0)
    for m in which:
        same = (legs[m] == legs[first]).all() and abs(leg_times_s[m, 1] - leg_times_s[m, 0] - lasts_s) <= SAME_S
        same = same and reaches_m[leg_robots[m]] == reaches_m[leader] and squares[leg_robots[m]] == squares[leader]
        # a robot that drives the leg twice in its loop counts once
        if same and (n == 0 or robots[n - 1] != leg_robots[m]):
            ends[n], robots[n] = leg_times_s[m, 1], leg_robots[m]
            n += 1
            bounds[n] = n
    gap, _, _ = team_gap(ends, ends, bounds, robots, n, classes, parts, units_s, limit_s, from_s)
    return gap + 2 * SAME_S


@njit(cache=True, nogil=True)
def passing_gaps(
    offsets, corners, limits_s, slack_m, grid, shape,
    legs, leg_times_s, leg_robots, leg_kinds, leg_offsets, leg_index,
    reaches_m, squares, classes, parts, units_s, from_s,
    walls, wall_offsets, wall_index,
):  # fmt: skip
    """For each piece a time (n,) that none of its points waits longer for a look, and a first look (n,); inf: not told.

    A point is seen at the same moment of each turn of a loop, though another point is seen at another: robots that
    drive the same leg count together, all others by themselves.
    """
    n_pieces = len(offsets) - 1
    gaps, firsts = np.full(n_pieces, np.inf), np.full(n_pieces, np.inf)
    starts, ends = np.empty(64), np.empty(64)
    widest = reaches_m.max() if len(reaches_m) else 0.0
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        middle = np.empty((1, 2))
        middle[0, 0], middle[0, 1] = piece[:, 0].mean(), piece[:, 1].mean()
        column = cell_along(middle[0, 0] - grid[0], grid[2], shape[0])
        row = cell_along(middle[0, 1] - grid[1], grid[2], shape[1])
        cell = column * shape[1] + row
        near = wall_index[wall_offsets[cell] : wall_offsets[cell + 1]]
        shadows, _, index, n_shadows = shadows_of(piece, walls, near, slack_m, widest)
        seen_by, seen_boxes, _, n_seen_by = shadows_of(middle, walls, near, slack_m, widest)
        if n_shadows < 0 or n_seen_by < 0:
            continue
        if n_seen_by + 4 > len(starts):
            starts, ends = np.empty(2 * n_seen_by + 4), np.empty(2 * n_seen_by + 4)
        near_legs = leg_index[leg_offsets[cell] : leg_offsets[cell + 1]]
        passed = np.zeros(len(near_legs), np.bool_)
        for i in range(len(near_legs)):
            m = near_legs[i]
            if leg_kinds[m] != LOOP:
                continue
            robot = leg_robots[m]
            lo, hi = part_in_range(piece, legs[m], reaches_m[robot], squares[robot])
            if not lo < hi:
                continue
            kept = leg_sights(
                middle, legs[m], reaches_m[robot], squares[robot], seen_by, seen_boxes, n_seen_by, slack_m, starts, ends
            )
            for p in range(kept):
                place = 0.5 * (max(lo, starts[p]) + min(hi, ends[p]))
                if lo <= place <= hi and _seen_round(
                    place, piece, middle[0], legs[m], lo, hi, walls, shadows, index, n_shadows, slack_m
                ):
                    passed[i] = True
                    break
        which = near_legs[passed]
        for m in which:
            gap = _gap_of_followers(
                m, which, legs, leg_times_s, leg_robots, reaches_m, squares, classes, parts, units_s, limits_s[k],
                from_s,
            )  # fmt: skip
            gaps[k], firsts[k] = min(gaps[k], gap), min(firsts[k], leg_times_s[m, 1])
    return gaps, firsts

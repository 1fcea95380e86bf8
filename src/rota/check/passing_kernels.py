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
from typing import NamedTuple

import numpy as np

from rota.check.arrays import Floats, Parts, SeenTimes
from rota.check.gap_kernels import team_gap
from rota.check.kernels import (
    FIRST_ROOM,
    LOOP,
    leg_sights,
    part_in_range,
    room_for_parts,
    shrunk,
)
from rota.check.piece_kernels import middle_of
from rota.check.shadow_kernels import CUTS, blocked_part, hides, shadows_of
from rota.check.tiling_kernels import cell_of, in_cell
from rota.check.tolerances import SAME_CORNER_M, SAME_TIME
from rota.compiled.kernel import allocation_free, kernel


class View(NamedTuple):
    """One stretch of a leg as a piece sees it: from its middle (x, y) to a place (px, py) that the middle sees.

    turn: 1 where the leg runs counterclockwise, -1 where clockwise. (ahead_x, ahead_y): across the leg, from the piece
    towards it.
    """

    x: float
    y: float
    px: float
    py: float
    turn: float
    ahead_x: float
    ahead_y: float


class Stretch(NamedTuple):
    """A leg (4,) x0, y0, x1, y1, the part lo..hi of it in 0..1 from which a piece is in range, and a place in that."""

    leg: Floats
    lo: float
    hi: float
    place: float


@allocation_free
def _cross(ax, ay, bx, by):
    """The cross product of two vectors in the plane."""
    return ax * by - ay * bx


@allocation_free
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


@allocation_free
def _ahead(piece, view, x, y):
    """Whether (x, y) lies ahead of all of the piece."""
    least = math.inf
    for q in range(len(piece)):
        least = min(least, view.ahead_x * (x - piece[q, 0]) + view.ahead_y * (y - piece[q, 1]))
    return least > 0


@allocation_free
def _end_of_hidden(wall, piece, slack_m, view):
    """Which part of the leg a wall hides: 1 before (x, y) as each point of the piece sees it, -1 behind it, 0: unclear.

    Returns that and (x, y).
    """
    first_x, first_y, last_x, last_y, sure = _ends(wall, piece, slack_m, view.turn)
    x, y = view.px - view.x, view.py - view.y
    if sure and view.turn * _cross(last_x - view.x, last_y - view.y, x, y) >= 0:
        return (1 if _ahead(piece, view, last_x, last_y) else 0), last_x, last_y
    if sure and view.turn * _cross(first_x - view.x, first_y - view.y, x, y) <= 0:
        return (-1 if _ahead(piece, view, first_x, first_y) else 0), first_x, first_y
    return 0, 0.0, 0.0


@allocation_free
def _in_order(piece, turn, before, behind):
    """Whether a(q) <= b(q) for all corners q of the piece and all ends (n, 2) of walls before and (m, 2) behind."""
    for i in range(len(before)):
        for j in range(len(behind)):
            if math.hypot(before[i, 0] - behind[j, 0], before[i, 1] - behind[j, 1]) < SAME_CORNER_M:
                return False
            for q in range(len(piece)):
                x, y = piece[q, 0], piece[q, 1]
                if turn * _cross(before[i, 0] - x, before[i, 1] - y, behind[j, 0] - x, behind[j, 1] - y) < 0:
                    return False
    return True


@kernel
def _sees_round(stretch, piece, middle, walls, shadows, slack_m):
    """Whether each point of the piece is seen from somewhere on the ``Stretch`` round its place.

    piece: (c, 2); middle: (2,) of it; shadows: those of the whole piece.
    """
    leg, lo, hi, place = stretch
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    px, py = leg[0] + place * dx, leg[1] + place * dy
    turn = 1.0 if _cross(leg[0] - middle[0], leg[1] - middle[1], dx, dy) > 0 else -1.0
    view = View(middle[0], middle[1], px, py, turn, turn * dy, -turn * dx)
    if not _ahead(piece, view, px, py):
        return False
    before, behind = np.empty((shadows.number + 1, 2)), np.empty((shadows.number + 1, 2))
    n_before, n_behind = 1, 1
    for w in range(shadows.number):
        if not hides(shadows, w, piece, slack_m):
            continue
        if shadows.known[w] == CUTS:
            return False
        start, stop = blocked_part(shadows.sides[w], leg, lo, hi)
        if not start < stop:
            continue
        kind, x, y = _end_of_hidden(walls.segments_m[shadows.walls[w]], piece, slack_m, view)
        if kind == 1:
            before[n_before, 0], before[n_before, 1] = x, y
            n_before += 1
        elif kind == -1:
            behind[n_behind, 0], behind[n_behind, 1] = x, y
            n_behind += 1
        elif stop <= place:
            lo = stop
        elif start >= place:
            hi = start
        else:
            return False
    before[0, 0], before[0, 1] = leg[0] + lo * dx, leg[1] + lo * dy
    behind[0, 0], behind[0, 1] = leg[0] + hi * dx, leg[1] + hi * dy
    return _in_order(piece, turn, before[:n_before], behind[:n_behind])


@allocation_free
def _same_leg(one, other):
    """Whether two legs (4,) are the same: not ``(one == other).all()``, which compiles messages about shapes."""
    return one[0] == other[0] and one[1] == other[1] and one[2] == other[2] and one[3] == other[3]


@kernel
def _gap_of_followers(first, passing, legs, team, limit_s):
    """Worst gap between looks at one point by all robots that drive the same leg as the first, one after the other.

    first: a leg. passing (n,): the legs from which each point of a piece is seen, robot by robot. Robots with another
    sensor may see the point from another place of the leg, and do not count; nor do those that drive it by another
    law of time. Bends that differ by e put no place of the leg off by more than the share e of its time.
    """
    leader = legs.robots[first]
    lasts_s, bend = legs.times_s[first, 1] - legs.times_s[first, 0], legs.bends[first]
    ends, robots = np.empty(len(passing)), np.empty(len(passing), np.int64)
    bounds = np.zeros(len(passing) + 1, np.int64)
    n = np.int64(0)
    for m in passing:
        robot = legs.robots[m]
        same = _same_leg(legs.near.segments_m[m], legs.near.segments_m[first])
        off_s = abs(legs.times_s[m, 1] - legs.times_s[m, 0] - lasts_s) + abs(legs.bends[m] - bend) * lasts_s
        same = same and off_s <= SAME_TIME
        same = same and team.reaches_m[robot] == team.reaches_m[leader] and team.squares[robot] == team.squares[leader]
        # a robot that drives the leg twice in its loop counts once
        if same and (n == 0 or robots[n - 1] != robot):
            ends[n], robots[n] = legs.times_s[m, 1], robot
            n += 1
            bounds[n] = n
    gap, _, _ = team_gap(SeenTimes(ends, ends, bounds, robots), n, team.loops, limit_s)
    return gap + 2 * SAME_TIME


@kernel
def passing_gaps(offsets, corners, limits_s, slack_m, grid, legs, team, walls):
    """Times (n,) that no point of each piece waits longer for a look, and first looks (n,), in seconds; inf: not told.

    The arguments are those of ``kernels.worst_gaps``. A point is seen at the same moment of each turn of a loop, but
    another point at another moment. So robots that drive the same leg count together, and all others by themselves.
    """
    n_pieces = len(offsets) - 1
    gaps, firsts = np.full(n_pieces, np.inf), np.full(n_pieces, np.inf)
    parts = Parts(np.empty(FIRST_ROOM), np.empty(FIRST_ROOM))
    ways, passed_in = legs.ways, np.full(len(legs.ways.reaches_m), -1, np.int64)
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        middle = np.empty((1, 2))
        middle[0, 0], middle[0, 1] = middle_of(piece)
        cell = cell_of(middle[0, 0], middle[0, 1], grid)
        of_piece = shadows_of(piece, walls, cell, slack_m, ways.widest_m)
        of_middle = shadows_of(middle, walls, cell, slack_m, ways.widest_m)
        if of_piece.number < 0 or of_middle.number < 0:
            continue
        parts = room_for_parts(parts, of_middle)
        for w in in_cell(ways.near, cell):
            way, reach_m, square = ways.near.segments_m[w], ways.reaches_m[w], ways.squares[w]
            lo, hi = part_in_range(piece, way, reach_m, square)
            if not lo < hi:
                continue
            from_lo, to_hi = part_in_range(middle, way, reach_m, square)
            kept = 0 if from_lo > to_hi else leg_sights(middle, way, from_lo, to_hi, of_middle, slack_m, parts)
            for p in range(kept):
                place = 0.5 * (max(lo, parts.starts[p]) + min(hi, parts.ends[p]))
                if lo <= place <= hi and _sees_round(
                    Stretch(way, lo, hi, place), piece, middle[0], walls, of_piece, slack_m
                ):
                    passed_in[w] = k
                    break
        near_legs = in_cell(legs.near, cell)
        passing, count = np.empty(len(near_legs), np.int64), 0
        for m in near_legs:
            if legs.kinds[m] == LOOP and passed_in[legs.way_of[m]] == k:
                passing[count] = m
                count += 1
        passing = passing[:count]
        for m in passing:
            gaps[k] = min(gaps[k], _gap_of_followers(m, passing, legs, team, limits_s[k]))
            firsts[k] = min(firsts[k], legs.times_s[m, 1])
    return gaps, firsts

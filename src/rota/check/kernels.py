# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the revisit check: when a convex piece is seen whole, and the worst gap between its sights.

Pieces are convex polygons in one array of corners with offsets; a piece with one corner is a point. Coordinates are
small (the caller shifts them), times are seconds. ``slack_m`` is the tolerance: pieces and walls are thinner by it.
"""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Parts, SeenTimes, Views
from rota.check.gap_kernels import team_gap
from rota.check.piece_kernels import middle_of, with_room
from rota.check.shadow_kernels import blocked_part, hides, shadows_of
from rota.check.tiling_kernels import cell_of, half_width, in_cell
from rota.check.timing_kernels import time_along
from rota.check.tolerances import NO_LENGTH
from rota.compiled.kernel import allocation_free, kernel, noinline

TRANSIENT, LOOP, HOLD = 0, 1, 2
FIRST_ROOM = 64  # parts and times that there is room for at first


@kernel
def shrunk(corners, start, stop, slack_m):
    """The piece with all its sides moved inwards by at least ``slack_m``, (c, 2): scaled about the mean of its corners.

    corners[start:stop] are its corners in metres. A point or a segment stays as it is.
    """
    piece = corners[start:stop].copy()
    if stop - start < 3:
        return piece
    factor = 1.0 - min(0.5, slack_m / max(half_width(corners, start, stop), slack_m))
    cx, cy = middle_of(piece)
    for i in range(len(piece)):
        piece[i, 0] = cx + factor * (piece[i, 0] - cx)
        piece[i, 1] = cy + factor * (piece[i, 1] - cy)
    return piece


@allocation_free
def part_in_range(piece, leg, reach_m, square):
    """The part (lo, hi) of a leg, in 0..1, from which every corner of a piece is in range; lo > hi when there is none.

    piece: (c, 2) metres. leg: (4,) x0, y0, x1, y1. reach_m: a disc's radius, or half the side of a square.
    """
    lo, hi = 0.0, 1.0
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    length2 = dx * dx + dy * dy
    for i in range(len(piece)):
        rx, ry = piece[i, 0] - leg[0], piece[i, 1] - leg[1]
        if square:
            for r, d in ((rx, dx), (ry, dy)):
                if abs(d) < NO_LENGTH:
                    if abs(r) > reach_m:
                        return 1.0, 0.0
                else:
                    ua, ub = (r - reach_m) / d, (r + reach_m) / d
                    lo, hi = max(lo, min(ua, ub)), min(hi, max(ua, ub))
        elif length2 < NO_LENGTH:
            if rx * rx + ry * ry > reach_m * reach_m:
                return 1.0, 0.0
        else:
            across = dx * ry - dy * rx
            half2 = reach_m * reach_m - across * across / length2
            if half2 < 0:
                return 1.0, 0.0
            along, half = (rx * dx + ry * dy) / length2, math.sqrt(half2 / length2)
            lo, hi = max(lo, along - half), min(hi, along + half)
        if lo > hi:
            return 1.0, 0.0
    return lo, hi


@allocation_free
def _cut_out(parts, n, a, b):
    """Take the open part a..b out of the n parts of a leg; returns how many parts there are then."""
    kept = 0
    # room is made from the back: at most one more part than before
    for i in range(n - 1, -1, -1):
        parts.starts[i + 1], parts.ends[i + 1] = parts.starts[i], parts.ends[i]
    for i in range(1, n + 1):
        start, end = parts.starts[i], parts.ends[i]
        if b <= start or a >= end:
            parts.starts[kept], parts.ends[kept] = start, end
            kept += 1
            continue
        if a > start:
            parts.starts[kept], parts.ends[kept] = start, a
            kept += 1
        if b < end:
            parts.starts[kept], parts.ends[kept] = b, end
            kept += 1
    return kept


@noinline
def leg_sights(piece, leg, lo, hi, shadows, slack_m, parts):
    """Number of parts of a leg (4,) from which the whole piece (c, 2) is seen; ``parts`` takes them, ascending.

    lo..hi: the part of the leg in 0..1 from which the piece is in range. ``parts`` has room for ``shadows.number`` + 2
    parts.
    """
    parts.starts[0], parts.ends[0] = lo, hi
    n = 1
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    still = dx * dx + dy * dy < NO_LENGTH
    lo_x, lo_y, hi_x, hi_y = leg[0] + lo * dx, leg[1] + lo * dy, leg[0] + hi * dx, leg[1] + hi * dy
    x0, y0 = min(shadows.box[0], lo_x, hi_x), min(shadows.box[1], lo_y, hi_y)
    x1, y1 = max(shadows.box[2], lo_x, hi_x), max(shadows.box[3], lo_y, hi_y)
    boxes = shadows.boxes
    for w in range(shadows.number):
        if boxes[w, 0] > x1 or boxes[w, 2] < x0 or boxes[w, 1] > y1 or boxes[w, 3] < y0:
            continue
        if not hides(shadows, w, piece, slack_m):
            continue
        a, b = blocked_part(shadows.sides[w], leg, lo, hi)
        if a <= b and (still or lo == hi):
            return 0
        if not a < b:
            continue
        n = _cut_out(parts, np.int64(n), a, b)
        if n == 0:
            return 0
    # between two neighbouring walls the tolerance leaves a slit through which nothing is seen
    slit = 8 * slack_m / max(NO_LENGTH, math.sqrt(dx * dx + dy * dy))
    kept = 0
    for i in range(n):
        if parts.starts[i] > lo and parts.ends[i] < hi and parts.ends[i] - parts.starts[i] < slit:
            continue
        parts.starts[kept], parts.ends[kept] = parts.starts[i], parts.ends[i]
        kept += 1
    return kept


@kernel
def room_for_parts(parts, shadows):
    """``parts`` where it has room for the parts of one leg among these shadows, else larger ones.

    A leg begins as one part. Each shadow adds at most one. Cutting needs room for one more.
    """
    if shadows.number + 4 > len(parts.starts):
        return Parts(np.empty(2 * shadows.number + 4), np.empty(2 * shadows.number + 4))
    return parts


@kernel
def first_views(n_ways):
    """Room for what each of so many ways sees, which grows where it is too small."""
    seen_in, firsts, counts = np.full(n_ways, -1, np.int64), np.empty(n_ways, np.int64), np.empty(n_ways, np.int64)
    shares, one = np.empty((2, FIRST_ROOM)), np.empty((2, FIRST_ROOM))
    return Views(seen_in, firsts, counts, Parts(shares[0], shares[1]), Parts(one[0], one[1]))


@kernel(noinline=True)
def views_of(turn, piece, cell, ways, walls, slack_m, views):
    """From where on the ways near a cell the whole piece (c, 2) is seen, as that of the turn; ``views`` or larger ones.

    Walls are asked for once some way has the piece in range.
    """
    farther_m = slack_m if len(piece) == 1 else 0.0
    seen_in, firsts, counts, shares, one = views
    asked, n = False, 0
    for w in in_cell(ways.near, cell):
        way = ways.near.segments_m[w]
        lo, hi = part_in_range(piece, way, ways.reaches_m[w] + farther_m, ways.squares[w])
        if lo > hi:
            continue
        if not asked:
            asked, shadows = True, shadows_of(piece, walls, cell, slack_m, ways.widest_m)
            if shadows.number < 0:
                break
            one = room_for_parts(one, shadows)
        kept = leg_sights(piece, way, lo, hi, shadows, slack_m, one)
        if kept == 0:
            continue
        if n + kept > len(shares.starts):
            shares = Parts(with_room(shares.starts, n + kept), with_room(shares.ends, n + kept))
        seen_in[w], firsts[w], counts[w] = turn, n, kept
        for p in range(kept):
            shares.starts[n], shares.ends[n] = one.starts[p], one.ends[p]
            n += 1
    return Views(seen_in, firsts, counts, shares, one)


@kernel
def times_of_sights(turn, cell, legs, views, times):
    """When robots see the piece of that turn from the legs near a cell, as ``views`` tell.

    Returns the ``SeenTimes``, which are ``times`` or larger ones; the number of robots in them; the time in seconds of
    the first sight (inf: none); and whether a robot that stays for ever sees the piece.
    """
    starts, ends, bounds, robots = times
    parts = views.shares
    n_robots, n, always, first_s = 0, 0, False, np.inf
    for m in in_cell(legs.near, cell):
        way = legs.way_of[m]
        if views.seen_in[way] != turn:
            continue
        robot, first, kept = legs.robots[m], views.firsts[way], views.counts[way]
        t0, t1, bend = legs.times_s[m, 0], legs.times_s[m, 1], legs.bends[m]
        first_s = min(first_s, time_along(t0, t1, bend, parts.starts[first]))
        if legs.kinds[m] == TRANSIENT:
            continue
        if legs.kinds[m] == HOLD:
            always = True
            continue
        # legs come robot by robot, so that each robot is noted once at most
        if n_robots == 0 or robots[n_robots - 1] != robot:
            robots[n_robots], bounds[n_robots] = robot, n
            n_robots += 1
        if n + kept > len(starts):
            starts, ends = with_room(starts, n + kept), with_room(ends, n + kept)
        for p in range(first, first + kept):
            start, end = time_along(t0, t1, bend, parts.starts[p]), time_along(t0, t1, bend, parts.ends[p])
            if n > bounds[n_robots - 1] and start <= ends[n - 1]:
                ends[n - 1] = max(end, ends[n - 1])
            else:
                starts[n], ends[n] = start, end
                n += 1
    bounds[n_robots] = n
    return SeenTimes(starts, ends, bounds, robots), n_robots, first_s, always


@kernel
def nothing_seen(n_pieces):
    """What ``worst_gaps`` returns of pieces that nobody sees."""
    inf = np.full(n_pieces, np.inf)
    return inf, np.full(n_pieces, np.nan), inf.copy(), np.ones(n_pieces, np.bool_)


@kernel
def first_room(n_team):
    """Room for the times of sights of one piece, which grows where it is too small."""
    bounds, robots = np.zeros(n_team + 1, np.int64), np.empty(n_team, np.int64)
    return SeenTimes(np.empty(FIRST_ROOM), np.empty(FIRST_ROOM), bounds, robots)


@kernel
def worst_gaps(offsets, corners, limits_s, slack_m, grid, legs, team, walls):
    """Worst gap of each piece: an upper bound for its points, exact for a single point.

    offsets (n + 1,), corners (c, 2): the pieces. limits_s (n,): gaps above it are worth more effort. grid, legs, team,
    walls: ``Grid``, ``Legs``, ``Team`` and ``Binned``. Returns (n,) gaps_s (inf: never seen whole), begins_s, the time
    at which the gap begins (nan: not known), firsts_s, the time of the first sight (inf: never), and whether gaps are
    exact.
    """
    n_pieces = len(offsets) - 1
    gaps, begins, firsts, exact = nothing_seen(n_pieces)
    times, views = first_room(len(team.reaches_m)), first_views(len(legs.ways.reaches_m))
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        x, y = middle_of(piece)
        cell = cell_of(x, y, grid)
        views = views_of(np.int64(k), piece, cell, legs.ways, walls, slack_m, views)
        times, n, firsts[k], always = times_of_sights(np.int64(k), cell, legs, views, times)
        if always:
            gaps[k], begins[k] = 0.0, team.loops.from_s
        elif n:
            gaps[k], begins[k], exact[k] = team_gap(times, np.int64(n), team.loops, limits_s[k])
    return gaps, begins, firsts, exact

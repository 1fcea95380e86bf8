# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the revisit check: when a convex piece is seen whole, and the worst gap between its sights.

Pieces are convex polygons in one array of corners with offsets; a piece with one corner is a point. Coordinates are
small (the caller shifts them), times are seconds. ``slack_m`` is the tolerance: pieces and walls are thinner by it.
"""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Parts, SeenTimes, Shadows
from rota.check.gap_kernels import team_gap
from rota.check.tiling_kernels import cell_of, half_width, in_cell
from rota.check.tolerances import CONE_M, NO_LENGTH
from rota.compiled.kernel import kernel

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
    cx, cy = piece[:, 0].mean(), piece[:, 1].mean()
    for i in range(len(piece)):
        piece[i, 0] = cx + factor * (piece[i, 0] - cx)
        piece[i, 1] = cy + factor * (piece[i, 1] - cy)
    return piece


@kernel
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


@kernel
def _shadow(piece, wall, slack_m, shadow):
    """Fill ``shadow`` with the half-planes in whose intersection ``wall`` cuts the piece from every position.

    shadow: (9,) three times nx, ny, c: n.p > c. piece Q: (c, 2) metres. wall W: (4,). The positions p whose hull with Q
    meets W are W + cone(W - Q), which is convex. Two of its sides run along the extreme directions of the cone; the
    third is the wall's line where Q lies on one side of it. Returns 0 when the wall hides nothing, 1 when ``shadow``
    was filled, 2 when the wall cuts the piece itself, which is then never seen whole.
    """
    ax, ay = wall[0], wall[1]
    wx, wy = wall[2] - ax, wall[3] - ay
    length = math.hypot(wx, wy)
    if length == 0:
        return 0  # which rounding has made of a side that was short
    wx, wy = wx / length, wy / length
    low, high = math.inf, -math.inf
    for i in range(len(piece)):
        side = wx * (piece[i, 1] - ay) - wy * (piece[i, 0] - ax)
        low, high = min(low, side), max(high, side)
    if len(piece) == 1 and abs(low) <= slack_m:
        return 0
    facing = 0.0
    if low >= -slack_m:
        facing = -1.0
    elif high <= slack_m:
        facing = 1.0
    nx, ny = -wy * facing, wx * facing
    e1x, e1y, e2x, e2y = 0.0, 0.0, 0.0, 0.0
    for i in range(len(piece)):
        for end in range(2):
            vx, vy = wall[2 * end] - piece[i, 0], wall[2 * end + 1] - piece[i, 1]
            if facing != 0:
                # a piece that touches the wall's line must not turn the cone into more than a half-plane
                away = vx * nx + vy * ny
                if away < CONE_M:
                    vx, vy = vx + (CONE_M - away) * nx, vy + (CONE_M - away) * ny
            if i == 0 and end == 0:
                e1x, e1y, e2x, e2y = vx, vy, vx, vy
            if e1x * vy - e1y * vx < 0:
                e1x, e1y = vx, vy
            if e2x * vy - e2y * vx > 0:
                e2x, e2y = vx, vy
    if facing == 0:
        for i in range(len(piece)):
            for end in range(2):
                vx, vy = wall[2 * end] - piece[i, 0], wall[2 * end + 1] - piece[i, 1]
                if e1x * vy - e1y * vx < 0 or e2x * vy - e2y * vx > 0:
                    return 2
        if e1x * e2y - e1y * e2x <= 0:
            return 2
    l1, l2 = math.hypot(e1x, e1y), math.hypot(e2x, e2y)
    shadow[0], shadow[1] = -e1y / l1, e1x / l1
    shadow[2] = slack_m + min(shadow[0] * ax + shadow[1] * ay, shadow[0] * wall[2] + shadow[1] * wall[3])
    shadow[3], shadow[4] = e2y / l2, -e2x / l2
    shadow[5] = slack_m + min(shadow[3] * ax + shadow[4] * ay, shadow[3] * wall[2] + shadow[4] * wall[3])
    shadow[6], shadow[7] = nx, ny
    shadow[8] = slack_m + nx * ax + ny * ay if facing != 0 else -math.inf
    return 1


@kernel(noinline=True)
def shadows_of(piece, walls, cell, slack_m, reach_m):
    """The ``Shadows`` of the walls near a cell that may hide part of the piece (c, 2) within reach_m, nearest first."""
    x0, x1, y0, y1 = piece[:, 0].min(), piece[:, 0].max(), piece[:, 1].min(), piece[:, 1].max()
    near = in_cell(walls, cell)
    sides, boxes, distances = np.empty((len(near), 9)), np.empty((len(near), 4)), np.empty(len(near))
    index = np.empty(len(near), np.int64)
    n = 0
    for k in near:
        wall = walls.segments_m[k]
        wx0, wx1 = min(wall[0], wall[2]), max(wall[0], wall[2])
        wy0, wy1 = min(wall[1], wall[3]), max(wall[1], wall[3])
        gap = max(max(wx0 - x1, x0 - wx1), max(wy0 - y1, y0 - wy1))
        if gap > reach_m:
            continue
        outcome = _shadow(piece, wall, slack_m, sides[n])
        if outcome == 2:
            return Shadows(sides, boxes, index, -1)
        if outcome == 1:
            boxes[n, 0], boxes[n, 1], boxes[n, 2], boxes[n, 3] = wx0, wy0, wx1, wy1
            distances[n] = gap
            index[n] = k
            n += 1
    if n > 4:
        order = np.argsort(distances[:n])
        sides, boxes, index = sides[order], boxes[order], index[order]
    return Shadows(sides, boxes, index, n)


@kernel
def blocked_part(shadow, leg, lo, hi):
    """The open part from, to of lo..hi of a leg (4,) inside a shadow (9,); empty when from is not below to."""
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    for k in range(0, 9, 3):
        inside = shadow[k] * leg[0] + shadow[k + 1] * leg[1] - shadow[k + 2]
        slope = shadow[k] * dx + shadow[k + 1] * dy
        if slope > 0:
            lo = max(lo, -inside / slope)
        elif slope < 0:
            hi = min(hi, -inside / slope)
        elif not inside > 0:
            return 1.0, 0.0
    return lo, hi


@kernel
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


@kernel(noinline=True)
def leg_sights(piece, leg, lo, hi, shadows, slack_m, parts):
    """Number of parts of a leg (4,) from which the whole piece (c, 2) is seen; ``parts`` takes them, ascending.

    lo..hi: the part of the leg in 0..1 from which the piece is in range. ``parts`` has room for ``shadows.number`` + 2
    parts.
    """
    parts.starts[0], parts.ends[0] = lo, hi
    n = 1
    dx, dy = leg[2] - leg[0], leg[3] - leg[1]
    still = dx * dx + dy * dy < NO_LENGTH
    qx0, qx1, qy0, qy1 = piece[:, 0].min(), piece[:, 0].max(), piece[:, 1].min(), piece[:, 1].max()
    x0 = min(qx0, leg[0] + lo * dx, leg[0] + hi * dx)
    x1 = max(qx1, leg[0] + lo * dx, leg[0] + hi * dx)
    y0 = min(qy0, leg[1] + lo * dy, leg[1] + hi * dy)
    y1 = max(qy1, leg[1] + lo * dy, leg[1] + hi * dy)
    boxes = shadows.boxes
    for w in range(shadows.number):
        if boxes[w, 0] > x1 or boxes[w, 2] < x0 or boxes[w, 1] > y1 or boxes[w, 3] < y0:
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
def times_of_sights(piece, cell, legs, team, shadows, slack_m, parts, times):
    """When robots see the whole piece (c, 2) from the legs near a cell.

    Returns the ``SeenTimes``, which are ``times`` or larger ones; the number of robots in them; the time in seconds of
    the first sight (inf: none); and whether a robot that stays for ever sees the piece.
    """
    starts, ends, bounds, robots = times
    farther_m = slack_m if len(piece) == 1 else 0.0
    n_robots, n, always, first_s = 0, 0, False, np.inf
    for m in in_cell(legs.near, cell):
        robot = legs.robots[m]
        leg = legs.near.segments_m[m]
        lo, hi = part_in_range(piece, leg, team.reaches_m[robot] + farther_m, team.squares[robot])
        if lo > hi:
            continue
        kept = leg_sights(piece, leg, lo, hi, shadows, slack_m, parts)
        if kept == 0:
            continue
        t0, t1 = legs.times_s[m, 0], legs.times_s[m, 1]
        first_s = min(first_s, t0 + parts.starts[0] * (t1 - t0))
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
            starts, ends = np.append(starts, np.empty(n + kept)), np.append(ends, np.empty(n + kept))
        for p in range(kept):
            start = t0 if parts.starts[p] == 0 else t0 + parts.starts[p] * (t1 - t0)
            end = t1 if parts.ends[p] == 1 else t0 + parts.ends[p] * (t1 - t0)
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
    """Room for the times of sights of one piece, which grows where it is too small, and for those between shadows."""
    bounds, robots = np.zeros(n_team + 1, np.int64), np.empty(n_team, np.int64)
    times = SeenTimes(np.empty(FIRST_ROOM), np.empty(FIRST_ROOM), bounds, robots)
    return times, Parts(np.empty(FIRST_ROOM), np.empty(FIRST_ROOM))


@kernel(nogil=True)
def worst_gaps(offsets, corners, limits_s, slack_m, grid, legs, team, walls):
    """Worst gap of each piece: an upper bound for its points, exact for a single point.

    offsets (n + 1,), corners (c, 2): the pieces. limits_s (n,): gaps above it are worth more effort. grid, legs, team,
    walls: ``Grid``, ``Legs``, ``Team`` and ``Binned``. Returns (n,) gaps_s (inf: never seen whole), begins_s, the time
    at which the gap begins (nan: not known), firsts_s, the time of the first sight (inf: never), and whether gaps are
    exact.
    """
    n_pieces, n_team = len(offsets) - 1, len(team.reaches_m)
    gaps, begins, firsts, exact = nothing_seen(n_pieces)
    times, parts = first_room(n_team)
    widest = team.reaches_m.max() if n_team else 0.0
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        cell = cell_of(piece[:, 0].mean(), piece[:, 1].mean(), grid)
        shadows = shadows_of(piece, walls, cell, slack_m, widest)
        if shadows.number < 0:
            continue
        parts = room_for_parts(parts, shadows)
        times, n, firsts[k], always = times_of_sights(piece, cell, legs, team, shadows, slack_m, parts, times)
        if always:
            gaps[k], begins[k] = 0.0, team.loops.from_s
        elif n:
            gaps[k], begins[k], exact[k] = team_gap(times, np.int64(n), team.loops, limits_s[k])
    return gaps, begins, firsts, exact

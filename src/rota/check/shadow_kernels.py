# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that tell from where walls hide part of a convex piece: the shadow of each wall, and what is in it.

Most walls near a piece lie beside all legs that pass it, so that a shadow is worked out when a leg first asks for it.
"""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Shadows
from rota.check.piece_kernels import box_of
from rota.check.tiling_kernels import in_cell
from rota.check.tolerances import CONE_M, GRID_MARGIN_M
from rota.compiled.kernel import allocation_free, kernel

RINGS = 16  # by the distance from the piece, into which walls are sorted
UNKNOWN, CLEAR, HIDES, CUTS = 0, 1, 2, 3  # of a wall: not asked yet, hides nothing, hides part, cuts the piece


@allocation_free
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
    """The ``Shadows`` of the walls near a cell that may hide part of the piece (c, 2) within reach_m, nearest first.

    "Nearest" is by rings: it decides nothing but how soon a leg that is hidden is known to be. None is worked out yet.
    """
    x0, x1, y0, y1 = box_of(piece)
    near = in_cell(walls, cell)
    ring, first = np.empty(len(near), np.int64), np.zeros(RINGS + 1, np.int64)
    sides = np.empty((len(near), 9))
    n = 0
    for i in range(len(near)):
        wall = walls.segments_m[near[i]]
        gap = max(
            max(min(wall[0], wall[2]) - x1, x0 - max(wall[0], wall[2])),
            max(min(wall[1], wall[3]) - y1, y0 - max(wall[1], wall[3])),
        )
        ring[i] = -1
        if gap > reach_m:
            continue
        # what is no farther off may cut the piece itself
        if gap <= GRID_MARGIN_M and _shadow(piece, wall, slack_m, sides[n]) == 2:
            return Shadows(sides, np.empty((0, 4)), np.empty((0, 4)), ring, ring, -1, np.empty(0))
        ring[i] = min(RINGS - 1, int(RINGS * max(gap, 0.0) / reach_m)) if reach_m > 0 else 0
        first[ring[i] + 1] += 1
        n += 1
    for r in range(RINGS):
        first[r + 1] += first[r]
    boxes, ends, index, box = np.empty((n, 4)), np.empty((n, 4)), np.empty(n, np.int64), np.empty(4)
    box[0], box[1], box[2], box[3] = x0, y0, x1, y1
    for i in range(len(near)):
        if ring[i] < 0:
            continue
        wall, at = walls.segments_m[near[i]], first[ring[i]]
        first[ring[i]] += 1
        index[at] = near[i]
        for side in range(4):
            ends[at, side] = wall[side]
        boxes[at, 0], boxes[at, 1] = min(wall[0], wall[2]), min(wall[1], wall[3])
        boxes[at, 2], boxes[at, 3] = max(wall[0], wall[2]), max(wall[1], wall[3])
    return Shadows(sides, boxes, ends, index, np.zeros(n, np.int64), n, box)


@allocation_free
def hides(shadows, w, piece, slack_m):
    """Whether the w-th wall hides part of the piece (c, 2) from anywhere; its row of ``sides`` is then filled."""
    if shadows.known[w] == UNKNOWN:
        outcome = _shadow(piece, shadows.ends[w], slack_m, shadows.sides[w])
        shadows.known[w] = CLEAR + outcome
        if outcome == 2:
            # which rounding alone may say of a wall that is off the piece: it hides the piece from everywhere
            shadows.sides[w, :] = 0.0
            shadows.sides[w, 2::3] = -math.inf
    return shadows.known[w] >= HIDES


@allocation_free
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

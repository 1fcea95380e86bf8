# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Curves of arcs and straight lines past the vertices of tours, for robots with a turn radius (compiled).

A path from one vertex and heading to the next is one of six words: three pieces that turn left, turn right or go
straight. The shortest of them is the shortest path of bounded curvature (Dubins 1957, "On curves of minimal length with
a constraint on average curvature"; the formulas are those of Shkel & Lumelsky 2001, "Classification of the Dubins
set"). Lengths are in metres, headings and turns in radians. An arc is driven as straight legs that touch it, so that
the arc itself fits into its corners.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.geometry.kernels import segment_is_free
from rota.model.arrays import Floats


class _Side(NamedTuple):
    """Whither a piece of a path turns."""

    LEFT: int = 1
    STRAIGHT: int = 0
    RIGHT: int = -1


Side = _Side()


WORDS = np.array(  # the pieces of each word
    [
        [Side.LEFT, Side.STRAIGHT, Side.LEFT],
        [Side.RIGHT, Side.STRAIGHT, Side.RIGHT],
        [Side.LEFT, Side.STRAIGHT, Side.RIGHT],
        [Side.RIGHT, Side.STRAIGHT, Side.LEFT],
        [Side.RIGHT, Side.LEFT, Side.RIGHT],
        [Side.LEFT, Side.RIGHT, Side.LEFT],
    ]
)
STEP_RAD = math.pi / 16  # at most this much is turned at a corner of an arc
MOST_CORNERS = 3 * (int(2 * math.pi / STEP_RAD) + 1)  # of the three arcs of a word
NO_TURN_RAD = 1e-7  # smaller turns are rounding, and left out: legs beside such a corner have hardly any length
BLOCKED_M = 1e9  # added to the length of a path that meets walls: any free one is shorter


class Leg(NamedTuple):
    """From one point (2,) to the next (2,), and the headings that may be had at each: (h,) and (g,)."""

    a: Floats
    b: Floats
    headings_a: Floats
    headings_b: Floats


@allocation_free
def _wrap(angle):
    """The angle in 0..2 pi; what rounding leaves just below 2 pi is 0."""
    angle = angle % math.tau
    return 0.0 if angle > math.tau - NO_TURN_RAD else angle


@allocation_free
def word_pieces(word, d, a, b, pieces):
    """The three pieces (3,) of a word in units of the radius, turns as angles; False where it does not lead there.

    d: the distance over the radius. a, b: the headings at both ends, from the direction of the far end.
    """
    sa, sb, ca, cb = math.sin(a), math.sin(b), math.cos(a), math.cos(b)
    cab = math.cos(a - b)
    if word == 0:
        p2 = 2 + d * d - 2 * cab + 2 * d * (sa - sb)
        turn = math.atan2(cb - ca, d + sa - sb)
        first, last = turn - a, b - turn
    elif word == 1:
        p2 = 2 + d * d - 2 * cab + 2 * d * (sb - sa)
        turn = math.atan2(ca - cb, d - sa + sb)
        first, last = a - turn, turn - b
    elif word == 2:
        p2 = -2 + d * d + 2 * cab + 2 * d * (sa + sb)
        if p2 < -(NO_TURN_RAD**2):
            return False
        p2 = max(p2, 0.0)
        turn = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, math.sqrt(p2))
        first, last = turn - a, turn - b
    elif word == 3:
        p2 = -2 + d * d + 2 * cab - 2 * d * (sa + sb)
        if p2 < -(NO_TURN_RAD**2):
            return False
        p2 = max(p2, 0.0)
        turn = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, math.sqrt(p2))
        first, last = a - turn, b - turn
    else:
        side = 1.0 if word == 4 else -1.0
        cosine = (6 - d * d + 2 * cab + side * 2 * d * (sa - sb)) / 8
        if abs(cosine) > 1:
            return False
        middle = math.tau - math.acos(cosine)
        if word == 4:
            first = a - math.atan2(ca - cb, d - sa + sb) + middle / 2
            last = a - b - first + middle
        else:
            first = -a - math.atan2(ca - cb, d + sa - sb) + middle / 2
            last = b - a - first + middle
        pieces[:] = _wrap(first), middle, _wrap(last)
        return True
    if p2 < NO_TURN_RAD**2 and word < 2:  # one arc: where it would go straight has no direction
        first, last = (b - a, 0.0) if word == 0 else (a - b, 0.0)
    pieces[:] = _wrap(first), math.sqrt(max(p2, 0.0)), _wrap(last)
    return True


@allocation_free
def word_corners(word, x, y, heading, pieces, radius_m, corners):
    """The corners (k, 2) of the legs along a word that begins at (x, y), without both its ends; returns k."""
    k = 0
    for piece in range(3):
        side = WORDS[word, piece]
        if side == Side.STRAIGHT:
            x += radius_m * pieces[piece] * math.cos(heading)
            y += radius_m * pieces[piece] * math.sin(heading)
            continue
        if pieces[piece] <= NO_TURN_RAD:
            continue
        steps = math.ceil(pieces[piece] / STEP_RAD)
        turn = pieces[piece] / steps
        tangent_m = radius_m * math.tan(turn / 2)
        for _ in range(steps):
            x += tangent_m * math.cos(heading)
            y += tangent_m * math.sin(heading)
            corners[k, 0], corners[k, 1] = x, y
            k += 1
            heading += side * turn
            x += tangent_m * math.cos(heading)
            y += tangent_m * math.sin(heading)
    return k


@kernel
def _corners_are_free(ax, ay, corners, count, bx, by, grid):
    """Whether the legs from a past the corners to b stay in the space."""
    x, y = ax, ay
    for k in range(count):
        if not segment_is_free(x, y, corners[k, 0], corners[k, 1], grid):
            return False
        x, y = corners[k, 0], corners[k, 1]
    return segment_is_free(x, y, bx, by, grid)


@allocation_free
def _relative(a, b, heading_a, heading_b, radius_m):
    """What word_pieces takes: the distance over the radius, and the headings from the direction of the far end."""
    along = math.atan2(b[1] - a[1], b[0] - a[0])
    return math.hypot(b[0] - a[0], b[1] - a[1]) / radius_m, heading_a - along, heading_b - along


@allocation_free
def _length_m(word, pieces, radius_m):
    """The length of a word, as the legs beside its arcs are driven."""
    total = 0.0
    for piece in range(3):
        turned = pieces[piece]
        if WORDS[word, piece] != Side.STRAIGHT and turned > NO_TURN_RAD:
            steps = math.ceil(turned / STEP_RAD)
            turned = 2 * steps * math.tan(turned / steps / 2)
        total += turned
    return radius_m * total


@kernel
def shortest_words(leg, radius_m, grid, looks, lengths, words):
    """The shortest path along a leg for each pair of headings: its length and its word, both (h, g).

    looks: whether paths must be free of walls; a pair without a free one has its shortest, BLOCKED_M longer.
    """
    a, b, headings_a, headings_b = leg
    pieces, corners = np.zeros(3), np.zeros((MOST_CORNERS, 2))
    for i in range(len(headings_a)):
        for j in range(len(headings_b)):
            d, begins, ends = _relative(a, b, headings_a[i], headings_b[j], radius_m)
            best = free = np.inf
            words[i, j] = 0
            for word in range(6):
                if not word_pieces(word, d, begins, ends, pieces):
                    continue
                length = _length_m(word, pieces, radius_m)
                if length < best and free == np.inf:
                    best = length
                    words[i, j] = word
                if looks and length < free:
                    count = word_corners(word, a[0], a[1], headings_a[i], pieces, radius_m, corners)
                    if _corners_are_free(a[0], a[1], corners, count, b[0], b[1], grid):
                        free = length
                        words[i, j] = word
            lengths[i, j] = best if not looks else free if free < np.inf else best + BLOCKED_M


@kernel
def is_free(a, b, heading_a, heading_b, word, radius_m, grid):
    """Whether the path by a word from a to b (2,) stays in the space."""
    pieces, corners = np.zeros(3), np.zeros((MOST_CORNERS, 2))
    d, begins, ends = _relative(a, b, heading_a, heading_b, radius_m)
    word_pieces(word, d, begins, ends, pieces)
    count = word_corners(word, a[0], a[1], heading_a, pieces, radius_m, corners)
    return _corners_are_free(a[0], a[1], corners, count, b[0], b[1], grid)


@kernel
def chosen_headings(lengths, closed):
    """The headings (n,) by number, of the shortest way past n vertices; a closed one comes back to the first.

    lengths: (legs, h, h), from each heading at a leg's first vertex to each at its second; inf where there is none.
    """
    legs, h = lengths.shape[0], lengths.shape[1]
    came_from = np.zeros((legs, h), dtype=np.int64)
    best, chosen = np.inf, np.zeros(legs + 1, dtype=np.int64)
    for begin in range(h if closed else 1):
        reached = np.zeros(h)
        if closed:
            reached[:] = np.inf
            reached[begin] = 0.0
        for k in range(legs):
            after = np.full(h, np.inf)
            for i in range(h):
                for j in range(h):
                    if reached[i] + lengths[k, i, j] < after[j]:
                        after[j] = reached[i] + lengths[k, i, j]
                        came_from[k, j] = i
            reached = after
        end = begin if closed else int(np.argmin(reached))
        if reached[end] < best:
            best = reached[end]
            chosen[legs] = end
            for k in range(legs - 1, -1, -1):
                chosen[k] = came_from[k, chosen[k + 1]]
    return chosen


@kernel
def look_for_walls(points, headings, chosen, radius_m, grid, lengths, words, looked):
    """Look for walls along all paths of the legs by whose chosen headings walls would be met; whether there were any.

    points: (n, 2). headings: (n, h), chosen: (n,) by number. lengths, words: (n - 1, h, h). looked (n - 1,): whether a
    leg's lengths and words heed walls already.
    """
    some = False
    for k in range(len(points) - 1):
        i, j = chosen[k], chosen[k + 1]
        a, b, word = points[k], points[k + 1], words[k, i, j]
        if looked[k] or is_free(a, b, headings[k, i], headings[k + 1, j], word, radius_m, grid):
            continue
        leg = Leg(a, b, headings[k], headings[k + 1])
        shortest_words(leg, radius_m, grid, True, lengths[k], words[k])
        looked[k] = some = True
    return some


@kernel
def curve_corners(points, headings, words, radius_m):
    """The corners (m, 2) of the curve past the points (n, 2) with these headings (n,) by these words (n - 1,).

    The first point and the last are among them.
    """
    out = np.zeros((len(points) * MOST_CORNERS + 2, 2))
    out[0] = points[0]
    pieces, count = np.zeros(3), 1
    for k in range(len(points) - 1):
        d, begins, ends = _relative(points[k], points[k + 1], headings[k], headings[k + 1], radius_m)
        word_pieces(words[k], d, begins, ends, pieces)
        count += word_corners(words[k], points[k, 0], points[k, 1], headings[k], pieces, radius_m, out[count:])
    out[count] = points[-1]
    return out[: count + 1]


@kernel
def lengths_between(begins, ends, headings_a, headings_b, radius_m, grid, lengths, words):
    """The shortest free paths from each pose to each other: their lengths and words, both (n, m, 1, 1).

    begins: (n, 2), headings_a: (n, 1), in which they are left. ends: (m, 2), headings_b: (m, 1), in which they are
    come to. Without a free path a pair has its shortest, BLOCKED_M longer.
    """
    for i in range(len(begins)):
        for j in range(len(ends)):
            leg = Leg(begins[i], ends[j], headings_a[i], headings_b[j])
            shortest_words(leg, radius_m, grid, True, lengths[i, j], words[i, j])

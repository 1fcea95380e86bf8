# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that look through triangles of ground: whether a place, or any of a piece, can be seen by a body.

A look goes from triangle to triangle through the sides that they share, and knows which part of each side lines of
sight can pass. It ends at walls, and where a side is the border of where bodies can stand. See ``triangles``.
"""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import WALL
from rota.check.piece_kernels import middle_of
from rota.check.tiling_kernels import cell_of
from rota.check.tolerances import NO_WAY_THROUGH_M
from rota.compiled.kernel import allocation_free, kernel

MOST_STEPS = 4  # times as many triangles as there are: a look that takes more, which none should, sees


@allocation_free
def _inner_side(corners_m, a, b, x, y):
    """How many metres (x, y) lies inwards of the side of a triangle from corner a to corner b."""
    ax, ay = corners_m[a, 0], corners_m[a, 1]
    dx, dy = corners_m[b, 0] - ax, corners_m[b, 1] - ay
    length = math.hypot(dx, dy)
    return (dx * (y - ay) - dy * (x - ax)) / length if length > 0 else 0.0


@allocation_free
def _triangle_at(ground, x, y):
    """The triangle of the ``Triangles`` that holds (x, y), or the nearest by rounding; -1 where there is none."""
    best, best_m = -1, -NO_WAY_THROUGH_M
    cell = cell_of(x, y, ground.grid)
    for at in range(ground.offsets[cell], ground.offsets[cell + 1]):
        t = ground.items[at]
        inside_m = math.inf
        for k in range(3):
            a, b = ground.triangles[t, k], ground.triangles[t, (k + 1) % 3]
            inside_m = min(inside_m, _inner_side(ground.corners_m, a, b, x, y))
        if inside_m > best_m:
            best, best_m = t, inside_m
    return best


@allocation_free
def _overlap_m(ground, t, piece):
    """By how many metres a triangle and a convex piece (c, 2) overlap at most, below 0 where they lie apart.

    Of a piece of one corner: how far inside it lies.
    """
    least = math.inf
    for k in range(3):
        a, b = ground.triangles[t, k], ground.triangles[t, (k + 1) % 3]
        most = -math.inf
        for i in range(len(piece)):
            most = max(most, _inner_side(ground.corners_m, a, b, piece[i, 0], piece[i, 1]))
        least = min(least, most)
    turn = 0.0
    for i in range(1, len(piece) - 1):
        turn += (piece[i, 0] - piece[0, 0]) * (piece[i + 1, 1] - piece[0, 1])
        turn -= (piece[i, 1] - piece[0, 1]) * (piece[i + 1, 0] - piece[0, 0])
    for i in range(len(piece) if len(piece) > 2 else 0):
        j = (i + 1) % len(piece)
        dx, dy = piece[j, 0] - piece[i, 0], piece[j, 1] - piece[i, 1]
        length = math.hypot(dx, dy)
        if length == 0:
            continue
        if turn < 0:
            dx, dy = -dx, -dy
        most = -math.inf
        for k in range(3):
            corner = ground.triangles[t, k]
            x, y = ground.corners_m[corner, 0] - piece[i, 0], ground.corners_m[corner, 1] - piece[i, 1]
            most = max(most, (dx * y - dy * x) / length)
        least = min(least, most)
    return least


@allocation_free
def _triangles_under(ground, piece, middle, room):
    """How many triangles a piece (c, 2) touches, from the one at its middle on: the first rows of ``room`` (t,)."""
    room[0], count, done = middle, 1, 0
    while done < count:
        t = room[done]
        done += 1
        for k in range(3):
            other = ground.beyond[t, k]
            if other < 0 or _overlap_m(ground, other, piece) < -NO_WAY_THROUGH_M:
                continue
            known = False
            for i in range(count):
                known = known or room[i] == other
            if not known:
                room[count] = other
                count += 1
    return count


@allocation_free
def _near_m(x, y, ax, ay, bx, by, square):
    """How near a segment comes to (x, y): in metres, or by the larger of both axes for a square sensor."""
    ax, ay, bx, by = ax - x, ay - y, bx - x, by - y
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    if not square:
        u = min(1.0, max(0.0, -(ax * dx + ay * dy) / length2)) if length2 > 0 else 0.0
        return math.hypot(ax + u * dx, ay + u * dy)
    nearest = min(max(abs(ax), abs(ay)), max(abs(bx), abs(by)))
    # it is smallest at an end, on an axis, or on a diagonal
    for nx, ny in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)):
        a, b = nx * ax + ny * ay, nx * bx + ny * by
        if (a < 0.0 < b) or (b < 0.0 < a):
            u = a / (a - b)
            nearest = min(nearest, max(abs(ax + u * dx), abs(ay + u * dy)))
    return nearest


@allocation_free
def _sight_through(view, ax, ay, bx, by):
    """The part from, to in 0..1 of the way from (ax, ay) to (bx, by) that lines of a view pass; see ``_narrow``."""
    low, high = 0.0, 1.0
    for side in range(2):
        px, py = view[4 * side], view[4 * side + 1]
        qx, qy = view[4 * side + 2] - px, view[4 * side + 3] - py
        # the right border has what is seen on its left, the left border on its right
        sign = 1.0 if side == 0 else -1.0
        a = sign * (qx * (ay - py) - qy * (ax - px))
        b = sign * (qx * (by - py) - qy * (bx - px))
        if a < 0.0 and b < 0.0:
            return 1.0, 0.0
        if a < 0.0 <= b:
            low = max(low, a / (a - b))
        elif b < 0.0 <= a:
            high = min(high, a / (a - b))
    return low, high


@allocation_free
def _narrow(view, ax, ay, bx, by):
    """Narrow a view to the lines that pass a side with its right end at (ax, ay) and its left end at (bx, by).

    A view (8,): the left end of what looks, and the side's end that bounds to the right what is seen from it; then
    the right end of what looks, and the end that bounds it to the left. Each line of sight goes from between the
    looking ends through all sides passed: beyond these it keeps left of the one border and right of the other. That
    holds where the looking end is inwards of the side, so that only such ends bound anything; an end that is still the
    looking end itself bounds nothing.
    """
    length = math.hypot(bx - ax, by - ay)
    for side in range(2):
        px, py = view[4 * side], view[4 * side + 1]
        if (bx - ax) * (py - ay) - (by - ay) * (px - ax) <= NO_WAY_THROUGH_M * length:
            continue
        qx, qy = view[4 * side + 2] - px, view[4 * side + 3] - py
        x, y = (ax, ay) if side == 0 else (bx, by)
        turn = qx * (y - py) - qy * (x - px)
        if (qx == 0.0 and qy == 0.0) or (turn > 0.0 if side == 0 else turn < 0.0):
            view[4 * side + 2], view[4 * side + 3] = x, y


@allocation_free
def _begin(view, source, is_left, ax, ay, bx, by):
    """The view from a source (4,), a segment, through a side; is_left: the source begins with its left end."""
    left, right = (0, 2) if is_left else (2, 0)
    view[0], view[1], view[2], view[3] = source[left], source[left + 1], source[left], source[left + 1]
    view[4], view[5], view[6], view[7] = source[right], source[right + 1], source[right], source[right + 1]
    _narrow(view, ax, ay, bx, by)


@kernel
def _goes_on(ground, t, came_from, view, around, square, looks, count):
    """What a view that comes into a triangle passes next, put behind ``count`` others; -1 where it sees a body.

    around: (x, y, metres): nothing is seen farther from there. Returns how many there are to be gone on with.
    """
    room, views = looks
    came_by = 0
    for k in range(3):
        if ground.beyond[t, k] == came_from:
            came_by = k
    for turn in range(1, 3):
        k = (came_by + turn) % 3
        other = ground.beyond[t, k]
        if other == WALL:
            continue
        a, b = ground.triangles[t, k], ground.triangles[t, (k + 1) % 3]
        ax, ay = ground.corners_m[a, 0], ground.corners_m[a, 1]
        bx, by = ground.corners_m[b, 0], ground.corners_m[b, 1]
        low, high = _sight_through(view, ax, ay, bx, by)
        dx, dy = bx - ax, by - ay
        if (high - low) * math.hypot(dx, dy) <= NO_WAY_THROUGH_M:
            continue
        near_m = _near_m(around[0], around[1], ax + low * dx, ay + low * dy, ax + high * dx, ay + high * dy, square)
        if near_m > around[2]:
            continue
        if other < 0 or count >= len(room):
            return -1
        room[count, 0], room[count, 1] = other, t
        views[count] = view
        _narrow(views[count], ax, ay, bx, by)
        count += 1
    return count


@kernel
def _looks_out(ground, t, k, source, around, square, room, views):
    """Whether a source (4,), a segment in or beside a triangle, sees a body's place through the k-th side of it."""
    a, b = ground.triangles[t, k], ground.triangles[t, (k + 1) % 3]
    ax, ay = ground.corners_m[a, 0], ground.corners_m[a, 1]
    bx, by = ground.corners_m[b, 0], ground.corners_m[b, 1]
    dx, dy = source[2] - source[0], source[3] - source[1]
    # who looks past the source to its left has its beginning on the left, and to its right on the right
    side_a = dx * (ay - source[1]) - dy * (ax - source[0])
    side_b = dx * (by - source[1]) - dy * (bx - source[0])
    count, middle, is_left = 1, 1.0, side_a + side_b > 0.0
    if max(abs(side_a), abs(side_b)) <= NO_WAY_THROUGH_M * math.hypot(dx, dy):
        is_left = dx * (bx - ax) + dy * (by - ay) < 0.0
    elif (side_a < 0.0 < side_b) or (side_b < 0.0 < side_a):
        count, middle, is_left = 2, side_a / (side_a - side_b), side_a > 0.0
    for i in range(count):
        u, v = (0.0, middle) if i == 0 else (middle, 1.0)
        room[i, 0], room[i, 1] = ground.beyond[t, k], t
        _begin(
            views[i], source, is_left == (i == 0),
            ax + u * (bx - ax), ay + u * (by - ay), ax + v * (bx - ax), ay + v * (by - ay),
        )  # fmt: skip
    view = np.empty(8)
    steps = 0
    while count > 0:
        count -= 1
        steps += 1
        for i in range(8):
            view[i] = views[count, i]
        count = _goes_on(ground, room[count, 0], room[count, 1], view, around, square, (room, views), count)
        if count < 0 or steps > MOST_STEPS * len(ground.triangles):
            return True
    return False


@kernel
def _sources_of(piece, sources):
    """Fill sources (n, 4) with segments that every line through a convex piece (c, 2) crosses; how many they are."""
    c = len(piece)
    if c == 4:
        count, step = 2, 2
    else:
        count, step = max(1, c - 1), 1
    for i in range(count):
        for axis in range(2):
            sources[i, axis], sources[i, 2 + axis] = piece[i, axis], piece[(i + step) % c, axis]
    return count


@kernel
def _sees_any(ground, piece, reach_m, square, slack_m, under, room, views):
    """Whether any of a piece (c, 2), or a place (1, 2), is seen by a body; True where the ground does not hold it.

    Bodies that touch the piece, or whose ground it reaches into, see it. The rest is seen along lines that leave the
    triangles under it by their sides: who looks along such a line crosses a source of the piece.
    """
    x, y = middle_of(piece)
    middle = _triangle_at(ground, x, y)
    if middle < 0:
        return True
    radius_m = 0.0
    for i in range(len(piece)):
        radius_m = max(radius_m, math.hypot(piece[i, 0] - x, piece[i, 1] - y))
    around = (x, y, reach_m + radius_m)
    count = _triangles_under(ground, piece, middle, under)
    least_m = slack_m if len(piece) > 1 else -NO_WAY_THROUGH_M
    starts = 0
    for i in range(count):
        # what only touches the piece is looked into as all that lies beyond it
        if under[i] == middle or _overlap_m(ground, under[i], piece) > least_m:
            under[starts], under[i] = under[i], under[starts]
            starts += 1
    sources = np.empty((max(2, len(piece)), 4))
    number = _sources_of(piece, sources)
    for i in range(starts):
        t = under[i]
        for k in range(3):
            other = ground.beyond[t, k]
            if other == WALL:
                continue
            if other < 0:
                a, b = ground.corners_m[ground.triangles[t, k]], ground.corners_m[ground.triangles[t, (k + 1) % 3]]
                if _near_m(x, y, a[0], a[1], b[0], b[1], square) <= around[2]:
                    return True
                continue
            inner = False
            for j in range(starts):
                inner = inner or under[j] == other
            if inner:
                continue
            for s in range(number):
                if _looks_out(ground, t, k, sources[s], around, square, room, views):
                    return True
    return False


@kernel(noinline=True)
def are_seen(ground, offsets, corners_m, reach_m, square, slack_m):
    """Whether any of each piece is seen from where bodies stand, within reach_m: (n,) bool; see ``Triangles``.

    The corners of the k-th piece, which is convex, are corners_m[offsets[k] : offsets[k + 1]]; one corner is a place.
    square: reach_m is half of a square's side. slack_m: what of a piece lies so near to its border does not count.
    """
    seen = np.ones(len(offsets) - 1, np.bool_)
    most = len(ground.triangles) + 4
    under, room, views = np.empty(most, np.int64), np.empty((most, 2), np.int64), np.empty((most, 8))
    for k in range(len(seen)):
        piece = corners_m[offsets[k] : offsets[k + 1]]
        seen[k] = _sees_any(ground, piece, reach_m, square, slack_m, under, room, views)
    return seen

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of a disc that bounces in a polygon: straight lines, exact contacts, one bounce after the other.

The rim is where the disc's centre is when it touches: for each wall its parallel at a body's radius, for each corner
that points into the free space an arc round it. A row of ``elements`` is a wall (x, y, tx, ty, length, arc: its start,
its unit direction with the free space on the left, its length and the arc length where it begins) or an arc (x, y,
angle, 0, length, arc: its centre and the angle of its first normal; it runs clockwise); its kind is WALL or ARC. Parts
of the rim that lie within a radius of another wall are never reached, and nobody need know which: the nearest contact
wins.

A state is (element, s, j): the disc touches rim element number ``element`` at the length s from its beginning and has
turned j times by the bouncing angle from its first heading. Counting turns instead of adding angles keeps headings
exact for ever: after ``whole`` turns (0: never) the heading is the first one again.
"""

from __future__ import annotations

from math import atan2, cos, floor, hypot, inf, log, nan, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import kernel
from rota.model.arrays import Floats, Ints

WALL, ARC = 0, 1
TURN, FROM_WALL = 0, 1
TOUCH_M = 1e-9  # centres this close to the rim are on it; rays that pass an arc this closely graze it
APPROACH = 1e-9  # a heading nearer to parallel than this slides along the wall
MOST_TURNS = 720  # turns in one place after which the disc is stuck
CLOSE_M = 1e-7  # a return this close may be that of a cycle
SAME_M = 1e-8  # and this close, after Newton's steps, it is
LEAST_SLOPE = 1e-300  # stands for a slope of 0 in logarithms
SETTLED, UNSETTLED, STUCK = 0, 1, 2


class RimElements(NamedTuple):
    """The rim as compiled loops read it: elements (n, 6), their kinds (n,) and the disc's radius in metres."""

    elements: Floats
    kinds: Ints
    radius_m: float


class Turning(NamedTuple):
    """What a disc does at a contact: the rule TURN or FROM_WALL, and by which angle in radians.

    whole: the turns after which the heading is the first one again; 0: never.
    """

    rule: int
    angle_rad: float
    whole: int


class Discs(NamedTuple):
    """n discs before their first contact, (n,) each: places in metres, first headings, and turns made since."""

    x: Floats
    y: Floats
    first_headings_rad: Floats
    turned: Ints


class CyclesReached(NamedTuple):
    """What n discs came to.

    ints (n, 4): SETTLED, UNSETTLED or STUCK; element, turns and period of a state on the cycle. floats (n, 4): its s,
    the cycle's length, the return map's slope; mean logarithm of the slope per bounce over the first bounces. marks
    (n,): of the cycle, see ``once_round``.
    """

    floats: Floats
    ints: Ints
    marks: NDArray[np.uint64]


@kernel
def place_on(rim, e, s):
    """Centre of the disc and unit tangent of the rim there."""
    elements, kinds, radius = rim
    if kinds[e] == WALL:
        tx, ty = elements[e, 2], elements[e, 3]
        return elements[e, 0] - radius * ty + s * tx, elements[e, 1] + radius * tx + s * ty, tx, ty
    angle = elements[e, 2] - s / radius
    nx, ny = cos(angle), sin(angle)
    return elements[e, 0] + radius * nx, elements[e, 1] + radius * ny, ny, -nx


@kernel
def is_blocked(rim, x, y, dx, dy):
    """Whether something that the disc at (x, y) touches stops it from moving along (dx, dy)."""
    elements, kinds, radius = rim
    near2 = (radius + 2 * TOUCH_M) ** 2
    for e in range(len(elements)):
        qx, qy = x - elements[e, 0], y - elements[e, 1]
        if kinds[e] == WALL:
            tx, ty = elements[e, 2], elements[e, 3]
            along, away = qx * tx + qy * ty, ty * dx - tx * dy
            near = abs(qy * tx - qx * ty - radius) <= TOUCH_M and -TOUCH_M <= along <= elements[e, 4] + TOUCH_M
            if near and away > APPROACH:
                return True
        elif qx * qx + qy * qy < near2:  # so that few roots are drawn
            towards = -(qx * dx + qy * dy) > APPROACH * radius
            if towards and abs(hypot(qx, qy) - radius) <= TOUCH_M:
                return True
    return False


@kernel
def first_contact(rim, x, y, dx, dy):
    """The rim element that the disc touches first along the unit vector (dx, dy), where on it, and after how far.

    The element is -1 where there is none: the disc is outside.
    """
    elements, kinds, radius = rim
    best, element, where = inf, -1, 0.0
    for e in range(len(elements)):
        qx, qy = x - elements[e, 0], y - elements[e, 1]
        if kinds[e] == WALL:
            tx, ty = elements[e, 2], elements[e, 3]
            approach = ty * dx - tx * dy
            gap = qy * tx - qx * ty - radius
            if approach <= APPROACH or gap <= TOUCH_M or gap > best * approach:
                continue
            way = gap / approach
            along = qx * tx + qy * ty + way * (dx * tx + dy * ty)
            if way < best - TOUCH_M and -TOUCH_M <= along <= elements[e, 4] + TOUCH_M:
                best, element, where = way, e, min(max(along, 0.0), elements[e, 4])
        else:
            approach, miss = -(qx * dx + qy * dy), qx * dy - qy * dx
            if approach <= 0.0 or abs(miss) >= radius - TOUCH_M or approach > best + radius:
                continue
            if hypot(qx, qy) - radius <= TOUCH_M:
                continue
            way = approach - sqrt(radius * radius - miss * miss)
            if way < best - TOUCH_M:
                turned = elements[e, 2] - atan2(qy + way * dy, qx + way * dx)
                turned -= 2 * pi * floor(turned / (2 * pi))
                if turned > 1.5 * pi:  # before the arc's beginning, by rounding
                    turned = 0.0
                best, element, where = way, e, min(turned * radius, elements[e, 4])
    return element, where, best


@kernel
def leave(rim, turning, first_heading, e, s, j):
    """Place, unit tangent, heading and number of turns with which the disc leaves the rim; no turns: it is stuck.

    ``rule`` TURN: left by ``angle`` from where it came, again and again until nothing it touches is in the way (Eq. 6
    of Alam and Bobadilla). FROM_WALL: at ``angle`` from the wall it hit; in a corner, from the first wall that lets it.
    """
    elements, kinds, radius = rim
    angle, whole = turning.angle_rad, turning.whole
    x, y, tx, ty = place_on(rim, e, s)
    if turning.rule == TURN:
        for k in range(1, MOST_TURNS + 1):
            turns = (j + k) % whole if whole > 0 else j + k
            heading = first_heading + (turns * angle) % (2 * pi)
            if not is_blocked(rim, x, y, cos(heading), sin(heading)):
                return x, y, tx, ty, heading, turns, k
        return x, y, tx, ty, nan, j, 0
    heading = atan2(ty, tx) + angle
    if not is_blocked(rim, x, y, cos(heading), sin(heading)):
        return x, y, tx, ty, heading, 0, 1
    for other in range(len(elements)):
        if other == e or kinds[other] != WALL:
            continue
        ux, uy = elements[other, 2], elements[other, 3]
        qx, qy = x - elements[other, 0], y - elements[other, 1]
        along = qx * ux + qy * uy
        if abs(qy * ux - qx * uy - radius) <= TOUCH_M and -TOUCH_M <= along <= elements[other, 4] + TOUCH_M:
            heading = atan2(uy, ux) + angle
            if not is_blocked(rim, x, y, cos(heading), sin(heading)):
                return x, y, ux, uy, heading, 0, 1
    return x, y, tx, ty, nan, 0, 0


@kernel
def bounce(rim, turning, first_heading, e, s, j):
    """The next state, the way to it, the heading on that way, and d s' / d s; element -1: the disc is stuck."""
    x, y, tx, ty, heading, turns, tried = leave(rim, turning, first_heading, e, s, j)
    if tried == 0:
        return -1, 0.0, j, 0.0, nan, 0.0
    dx, dy = cos(heading), sin(heading)
    e1, s1, way = first_contact(rim, x, y, dx, dy)
    if e1 < 0:
        return -1, 0.0, j, 0.0, heading, 0.0
    _, _, ux, uy = place_on(rim, e1, s1)
    aside = dx * ty - dy * tx  # a step along the rim, seen across the way
    if abs(aside) <= APPROACH:
        aside = 0.0
    if turning.rule == FROM_WALL and rim.kinds[e] == ARC:
        aside -= way / rim.radius_m  # the wall's direction turns by -1 / radius per metre, and the way with it
    return e1, s1, turns, way, heading, aside / (dx * uy - dy * ux)


@kernel
def follow(rim, turning, first_heading, e, s, j, out):
    """Fill rows of ``out`` (p, 6) with states in turn: element, s, turns, then heading, way and slope to the next.

    Returns how many rows were filled; fewer than there are where the disc got stuck.
    """
    for k in range(len(out)):
        e1, s1, j1, way, heading, slope = bounce(rim, turning, first_heading, e, s, j)
        if e1 < 0:
            return k
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4], out[k, 5] = e, s, j, heading, way, slope
        e, s, j = e1, s1, j1
    return len(out)


@kernel
def once_round(rim, turning, first_heading, e, s, j, period):
    """The state after ``period`` bounces, the way, the return map's slope, and a mark of the places on the way.

    The mark is the same wherever on a cycle one begins. Cycles that touch other elements, or the same elements in
    another order or with other headings, have another mark.
    """
    way, slope, mark = 0.0, 1.0, np.uint64(0)
    for _ in range(period):
        e1, s1, j1, step, _, part = bounce(rim, turning, first_heading, e, s, j)
        if e1 < 0:
            return -1, 0.0, j, 0.0, 0.0, mark
        mixed = np.uint64(e * 1000003 + e1 + 1) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(j)
        mixed = (mixed ^ (mixed >> np.uint64(31))) * np.uint64(0xBF58476D1CE4E5B9)
        mark += mixed ^ (mixed >> np.uint64(29))
        way, slope = way + step, slope * part
        e, s, j = e1, s1, j1
    return e, s, j, way, slope, mark


@kernel
def cycles_reached(rim, turning, discs, bounces, longest, reached):
    """Let a disc go from each place of ``Discs``, and write the cycle it comes to, if any, into ``CyclesReached``.

    Discs must come to their cycles within ``bounces``; a cycle's period is at most ``longest``.
    """
    x, y, turned, whole, angle = discs.x, discs.y, discs.turned, turning.whole, turning.angle_rad
    floats, ints, marks = reached
    for k in range(len(x)):
        first_heading = discs.first_headings_rad[k]
        ints[k, 0], floats[k, 3] = STUCK, 0.0
        j, blocked = turned[k], True
        # a start on the rim may have to turn before all else
        for turns in range(MOST_TURNS if turning.rule == TURN else 1):
            j = (turned[k] + turns) % whole if whole > 0 else turned[k] + turns
            heading = first_heading + (j * angle) % (2 * pi)
            dx, dy = cos(heading), sin(heading)
            blocked = is_blocked(rim, x[k], y[k], dx, dy)
            if not blocked:
                break
        if blocked:
            continue
        e, s, _ = first_contact(rim, x[k], y[k], dx, dy)
        for _ in range(bounces):
            if e < 0:
                break
            e, s, j, _, _, part = bounce(rim, turning, first_heading, e, s, j)
            floats[k, 3] += log(max(abs(part), LEAST_SLOPE)) / bounces
        if e < 0:
            continue
        ints[k, 0] = UNSETTLED
        period = _return_time(rim, turning, first_heading, e, s, j, longest)
        if period == 0:
            continue
        for _ in range(3):  # Newton's steps; on straight walls the map is affine and one is enough
            e1, s1, _, way, slope, mark = once_round(rim, turning, first_heading, e, s, j, period)
            if e1 != e or abs(s1 - s) > CLOSE_M:
                break
            if abs(s1 - s) <= SAME_M:
                ints[k, 0], ints[k, 1], ints[k, 2], ints[k, 3] = SETTLED, e, j, period
                floats[k, 0], floats[k, 1], floats[k, 2], marks[k] = s, way, slope, mark
            if abs(slope) > 1 - 1e-6:
                break
            s = min(max(s + (s1 - s) / (1 - slope), 0.0), rim.elements[e, 4])


@kernel
def _return_time(rim, turning, first_heading, e, s, j, longest):
    """Bounces until the state comes back to within CLOSE_M, or 0 where ``longest`` are not enough."""
    e1, s1, j1 = e, s, j
    for k in range(1, longest + 1):
        e1, s1, j1, _, _, _ = bounce(rim, turning, first_heading, e1, s1, j1)
        if e1 < 0:
            return 0
        if e1 == e and abs(s1 - s) <= CLOSE_M and (j1 == j or turning.rule == FROM_WALL):
            return k
    return 0

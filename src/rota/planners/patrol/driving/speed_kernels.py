# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Times of rounds with limited accelerations in closed form: of a ring, of a stretch of one, and as vertices move.

Speeds and times are those of ``rounded_kernels``, but for jerk, of which only the time that it takes longer is counted.
A search weighs changes with them, many thousand times a second.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rota.compiled.kernel import allocation_free, noinline
from rota.planners.patrol.tolerances import SAME_PLACE_M, STRAIGHT, TIE

BESIDE = 6  # places on either side of one that moves: what it changes beyond is left out


class _Row(NamedTuple):
    """Rows of a window: place, metres to the next one, sine of half the turn, square of the speed, what they cost."""

    X: int = 0
    Y: int = 1
    WAY: int = 2
    SINE: int = 3
    SPEED2: int = 4
    LEG: int = 5
    CORNER: int = 6


Row = _Row()


class _Limit(NamedTuple):
    """Numbers of limits, see ``rounded_kernels.Limits``; PACE is what a second is in metres."""

    TOP2: int = 0
    ALONG: int = 1
    ACROSS: int = 2
    CUT: int = 3
    RISE: int = 4
    TURN: int = 5
    PACE: int = 6


Limit = _Limit()


@allocation_free
def _length(x, y):
    return math.sqrt(x * x + y * y)


@allocation_free
def across_m_s2(sine, limits):
    """The greatest acceleration round a corner; see ``rounded_kernels``."""
    return limits[Limit.ACROSS] if sine < 1 - TIE else min(limits[Limit.ACROSS], limits[Limit.ALONG])


@allocation_free
def fastest2(from2, from_sine, way_m, to_sine, limits):
    """Square of the greatest speed at a corner that a leg leaves room for, from that at its other end, and no less."""
    half = 0.5 / limits[Limit.ALONG]
    ahead = way_m + from2 * (half - from_sine / across_m_s2(from_sine, limits))
    return max(from2, ahead / (half + to_sine / across_m_s2(to_sine, limits)))


@noinline
def weighed_m(n, closed, w, limits):
    """What the n places of the window cost as metres at the pace; of an open way without the corners at its ends.

    w: a row for each ``Row``, with their places; the rest is written, but for sines and speeds at the ends of an open
    way, which are taken as they are.
    """
    if n < 2:
        w[Row.SINE, 0], w[Row.SPEED2, 0], w[Row.LEG, 0], w[Row.CORNER, 0] = 0.0, 0.0, 0.0, 0.0
        return 0.0
    legs = n if closed else n - 1
    for i in range(legs):
        j = i + 1 if i + 1 < n else 0
        w[Row.WAY, i] = max(SAME_PLACE_M, _length(w[Row.X, j] - w[Row.X, i], w[Row.Y, j] - w[Row.Y, i]))
    inner, end = (0, n) if closed else (1, n - 1)
    for i in range(inner, end):
        h, j = i - 1 if i > 0 else n - 1, i + 1 if i + 1 < n else 0
        before, after = w[Row.WAY, h], w[Row.WAY, i]
        ux, uy = (w[Row.X, i] - w[Row.X, h]) / before, (w[Row.Y, i] - w[Row.Y, h]) / before
        sine = min(1.0, _length((w[Row.X, j] - w[Row.X, i]) / after - ux, (w[Row.Y, j] - w[Row.Y, i]) / after - uy) / 2)
        w[Row.SINE, i], w[Row.SPEED2, i] = sine, limits[Limit.TOP2]
        if sine >= STRAIGHT:
            a = across_m_s2(sine, limits)
            cut2 = min(2 * a * limits[Limit.CUT] / (sine * sine), a * min(before, after) / (2 * sine))
            w[Row.SPEED2, i] = min(limits[Limit.TOP2], cut2 if limits[Limit.CUT] > 0 else 0.0)
    for _ in range(2 if closed else 1):
        for i in range(inner, end):
            h = i - 1 if i > 0 else n - 1
            w[Row.SPEED2, i] = min(
                w[Row.SPEED2, i], fastest2(w[Row.SPEED2, h], w[Row.SINE, h], w[Row.WAY, h], w[Row.SINE, i], limits)
            )
    for _ in range(2 if closed else 1):
        for i in range(end - 1, inner - 1, -1):
            j = i + 1 if i + 1 < n else 0
            w[Row.SPEED2, i] = min(
                w[Row.SPEED2, i], fastest2(w[Row.SPEED2, j], w[Row.SINE, j], w[Row.WAY, i], w[Row.SINE, i], limits)
            )
    total = 0.0
    for i in range(inner, end):
        turning_s = 2 * math.sqrt(w[Row.SPEED2, i]) * w[Row.SINE, i] / across_m_s2(w[Row.SINE, i], limits)
        if limits[Limit.TURN] > 0:
            turning_s += 2 * math.asin(w[Row.SINE, i]) * limits[Limit.TURN]
        w[Row.CORNER, i] = turning_s * limits[Limit.PACE]
        total += w[Row.CORNER, i]
    for i in range(legs):
        w[Row.LEG, i] = leg_s(i, i + 1 if i + 1 < n else 0, w, limits) * limits[Limit.PACE]
        total += w[Row.LEG, i]
    return total


@allocation_free
def leg_s(i, j, w, limits):
    """Seconds of the window's leg from place i to j, between where both corners are rounded."""
    along = limits[Limit.ALONG]
    from2, to2 = w[Row.SPEED2, i], w[Row.SPEED2, j]
    room_m = w[Row.WAY, i] - from2 * w[Row.SINE, i] / across_m_s2(w[Row.SINE, i], limits)
    room_m = max(0.0, room_m - to2 * w[Row.SINE, j] / across_m_s2(w[Row.SINE, j], limits))
    top2 = max(min(limits[Limit.TOP2], along * room_m + (from2 + to2) / 2), max(from2, to2))
    top, begins, ends = math.sqrt(top2), math.sqrt(from2), math.sqrt(to2)
    steady_m = max(0.0, room_m - (2 * top2 - from2 - to2) / (2 * along))
    if top == 0:
        return 0.0
    ramps_s = (2 * top - begins - ends) / along + later_s(begins, top, limits) + later_s(ends, top, limits)
    return ramps_s + steady_m / top


@allocation_free
def later_s(slow, top, limits):
    """By how much later one is after a change of speed if its acceleration takes time to rise."""
    rise, along = limits[Limit.RISE], limits[Limit.ALONG]
    change = top - slow
    if rise == 0 or change <= 0:
        return 0.0
    longer_s = rise if change > along * rise else 2 * math.sqrt(change * rise / along) - change / along
    return longer_s * change / (2 * top)  # the way that it takes longer is driven meanwhile


@noinline
def slopes(ring, near, limits, step_m, growth, bends):
    """What a ring costs more for each metre that a vertex moves along an axis (n, 2), and for each that it bends it.

    ring: a row for each ``Row``, with its n places; near: room for 2 BESIDE + 1 of them. bends: (n, 2) what a move
    costs whichever way it goes, as corners on a straight way do. All vertices but one stay where they are, and a few at
    either side of it keep their speeds.
    """
    n = ring.shape[1]
    weighed_m(n, True, ring, limits)
    beside = min(BESIDE, (n - 1) // 2)
    count = 2 * beside + 1
    for v in range(n):
        for axis in range(2):
            costs = (0.0, 0.0, 0.0)
            for turn in range(3):
                for i in range(count):
                    j = (v - beside + i) % n
                    near[Row.X, i], near[Row.Y, i] = ring[Row.X, j], ring[Row.Y, j]
                    near[Row.SINE, i], near[Row.SPEED2, i] = ring[Row.SINE, j], ring[Row.SPEED2, j]
                near[axis, beside] += (turn - 1) * step_m
                costs = (costs[1], costs[2], weighed_m(count, False, near, limits))
            growth[v, axis] = (costs[2] - costs[0]) / (2 * step_m)
            bends[v, axis] = max(0.0, (costs[2] + costs[0] - 2 * costs[1]) / (2 * step_m))

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Times of rounds with limited accelerations in closed form: of a ring, of a stretch of one, and as vertices move.

Speeds and times are those of ``rounded_kernels``, but for jerk, of which only the time that it takes longer is counted.
A search weighs changes with them, many thousand times a second.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import kernel
from rota.planners.patrol.driving.rounded_kernels import STRAIGHT, STRAIGHT_BACK

OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
SHORTEST_M = 1e-9
# rows of a window: place, metres to the next one, sine of half the turn, square of the speed, what leg and corner cost
X, Y, WAY, SINE, SPEED2, LEG, CORNER = range(7)
ROWS = 7
# numbers of limits; the last is what a second is in metres
TOP2, ALONG, ACROSS, CUT, RISE, TURN, PACE = range(7)
BESIDE = 6  # places on either side of one that moves: what it changes beyond is left out


@kernel(**OPTIONS)
def _length(x, y):
    return math.sqrt(x * x + y * y)


@kernel(**OPTIONS)
def across_m_s2(sine, limits):
    """The greatest acceleration round a corner; see ``rounded_kernels``."""
    return limits[ACROSS] if sine < STRAIGHT_BACK else min(limits[ACROSS], limits[ALONG])


@kernel(**OPTIONS)
def fastest2(from2, from_sine, way_m, to_sine, limits):
    """Square of the greatest speed at a corner that a leg leaves room for, from that at its other end, and no less."""
    half = 0.5 / limits[ALONG]
    ahead = way_m + from2 * (half - from_sine / across_m_s2(from_sine, limits))
    return max(from2, ahead / (half + to_sine / across_m_s2(to_sine, limits)))


@kernel(**OPTIONS, noinline=True)
def weighed_m(n, closed, w, limits):
    """What the n places of the window cost as metres at the pace; of an open way without the corners at its ends.

    w: (ROWS, more) with their places; the rest is written, but for sines and speeds at the ends of an open way, which
    are taken as they are.
    """
    if n < 2:
        w[SINE, 0], w[SPEED2, 0], w[LEG, 0], w[CORNER, 0] = 0.0, 0.0, 0.0, 0.0
        return 0.0
    legs = n if closed else n - 1
    for i in range(legs):
        j = i + 1 if i + 1 < n else 0
        w[WAY, i] = max(SHORTEST_M, _length(w[X, j] - w[X, i], w[Y, j] - w[Y, i]))
    inner, end = (0, n) if closed else (1, n - 1)
    for i in range(inner, end):
        h, j = i - 1 if i > 0 else n - 1, i + 1 if i + 1 < n else 0
        before, after = w[WAY, h], w[WAY, i]
        ux, uy = (w[X, i] - w[X, h]) / before, (w[Y, i] - w[Y, h]) / before
        sine = min(1.0, _length((w[X, j] - w[X, i]) / after - ux, (w[Y, j] - w[Y, i]) / after - uy) / 2)
        w[SINE, i], w[SPEED2, i] = sine, limits[TOP2]
        if sine >= STRAIGHT:
            a = across_m_s2(sine, limits)
            cut2 = min(2 * a * limits[CUT] / (sine * sine), a * min(before, after) / (2 * sine))
            w[SPEED2, i] = min(limits[TOP2], cut2 if limits[CUT] > 0 else 0.0)
    for _ in range(2 if closed else 1):
        for i in range(inner, end):
            h = i - 1 if i > 0 else n - 1
            w[SPEED2, i] = min(w[SPEED2, i], fastest2(w[SPEED2, h], w[SINE, h], w[WAY, h], w[SINE, i], limits))
    for _ in range(2 if closed else 1):
        for i in range(end - 1, inner - 1, -1):
            j = i + 1 if i + 1 < n else 0
            w[SPEED2, i] = min(w[SPEED2, i], fastest2(w[SPEED2, j], w[SINE, j], w[WAY, i], w[SINE, i], limits))
    total = 0.0
    for i in range(inner, end):
        turning_s = 2 * math.sqrt(w[SPEED2, i]) * w[SINE, i] / across_m_s2(w[SINE, i], limits)
        if limits[TURN] > 0:
            turning_s += 2 * math.asin(w[SINE, i]) * limits[TURN]
        w[CORNER, i] = turning_s * limits[PACE]
        total += w[CORNER, i]
    for i in range(legs):
        w[LEG, i] = leg_s(i, i + 1 if i + 1 < n else 0, w, limits) * limits[PACE]
        total += w[LEG, i]
    return total


@kernel(**OPTIONS)
def leg_s(i, j, w, limits):
    """Seconds of the window's leg from place i to j, between where both corners are rounded."""
    along = limits[ALONG]
    from2, to2 = w[SPEED2, i], w[SPEED2, j]
    room_m = w[WAY, i] - from2 * w[SINE, i] / across_m_s2(w[SINE, i], limits)
    room_m = max(0.0, room_m - to2 * w[SINE, j] / across_m_s2(w[SINE, j], limits))
    top2 = max(min(limits[TOP2], along * room_m + (from2 + to2) / 2), max(from2, to2))
    top, begins, ends = math.sqrt(top2), math.sqrt(from2), math.sqrt(to2)
    steady_m = max(0.0, room_m - (2 * top2 - from2 - to2) / (2 * along))
    if top == 0:
        return 0.0
    ramps_s = (2 * top - begins - ends) / along + later_s(begins, top, limits) + later_s(ends, top, limits)
    return ramps_s + steady_m / top


@kernel(**OPTIONS)
def later_s(slow, top, limits):
    """By how much later one is after a change of speed if its acceleration takes time to rise."""
    rise, along = limits[RISE], limits[ALONG]
    change = top - slow
    if rise == 0 or change <= 0:
        return 0.0
    longer_s = rise if change > along * rise else 2 * math.sqrt(change * rise / along) - change / along
    return longer_s * change / (2 * top)  # the way that it takes longer is driven meanwhile


@kernel(**OPTIONS, noinline=True)
def slopes(ring, near, limits, step_m, growth, bends):
    """What a ring costs more for each metre that a vertex moves along an axis (n, 2), and for each that it bends it.

    ring: (ROWS, n) with its places; near: room for (ROWS, 2 BESIDE + 1) of them. bends: (n, 2) what a move costs
    whichever way it goes, as corners on a straight way do. All vertices but one stay where they are, and a few at
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
                    near[X, i], near[Y, i] = ring[X, j], ring[Y, j]
                    near[SINE, i], near[SPEED2, i] = ring[SINE, j], ring[SPEED2, j]
                near[axis, beside] += (turn - 1) * step_m
                costs = (costs[1], costs[2], weighed_m(count, False, near, limits))
            growth[v, axis] = (costs[2] - costs[0]) / (2 * step_m)
            bends[v, axis] = max(0.0, (costs[2] + costs[0] - 2 * costs[1]) / (2 * step_m))

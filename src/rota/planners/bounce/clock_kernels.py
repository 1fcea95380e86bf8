# mypy: disable-error-code="no-any-return"
"""Compiled loops over pairs of limit cycles: in which phases robots stay apart however their clocks differ by a while.

Times are in steps, places in metres. A robot goes straight through each step. While two of them are in steps i and j,
what differences of their clocks make their centres come too near is one interval: the extent of an ellipse, or of a
strip, cut by both steps, along the difference of times.
"""

from __future__ import annotations

from math import ceil, floor, gcd, hypot, inf, sqrt

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Flags
from rota.planners.bounce.arrays import Floats, Longs

TOUCH_M = 1e-6  # bodies overlap by less than this where they touch
SAME = 1e-9  # of a step: differences of clocks this near are one
Pair = tuple[float, float]


@allocation_free
def _within(gx: float, gy: float, vx: float, vy: float, apart: float, until: float) -> tuple[float, float]:
    """First and last time in 0..until at which ``g + v * time`` is shorter than apart; first > last: never."""
    a, b, c = vx * vx + vy * vy, gx * vx + gy * vy, gx * gx + gy * gy - apart * apart
    if a <= 1e-24:
        return (0.0, until) if c < 0 else (1.0, 0.0)
    below = b * b - a * c
    if below <= 0:
        return 1.0, 0.0
    root = sqrt(below)
    return max((-b - root) / a, 0.0), min((-b + root) / a, until)


@allocation_free
def touching_differences(gap: Pair, v: Pair, w: Pair, apart: float, most_s: float, most_t: float) -> Pair:
    """The least and the largest s - t over s in 0..most_s, t in 0..most_t with ``gap + v s - w t`` shorter than apart.

    gap: metres. v, w: metres for each unit of time. The least is larger than the largest where there are none. The
    extremes lie on the sides of the rectangle of times, or at those of the ellipse within: there the gap is square to
    the difference of velocities.
    """
    gx, gy = gap
    vx, vy = v
    wx, wy = w
    low, high = inf, -inf
    for side in range(2):
        s, t = side * most_s, side * most_t
        first, last = _within(gx + s * vx, gy + s * vy, -wx, -wy, apart, most_t)
        if first <= last:
            low, high = min(low, s - last), max(high, s - first)
        first, last = _within(gx - t * wx, gy - t * wy, vx, vy, apart, most_s)
        if first <= last:
            low, high = min(low, first - t), max(high, last - t)
    ux, uy = vx - wx, vy - wy
    size, cross = hypot(ux, uy), vx * wy - vy * wx
    if size > 0 and abs(cross) > 1e-12:
        for sign in (-1.0, 1.0):
            rx, ry = -sign * apart * uy / size - gx, sign * apart * ux / size - gy
            s, t = (rx * wy - ry * wx) / cross, (vy * rx - vx * ry) / cross
            if 0 <= s <= most_s and 0 <= t <= most_t:
                low, high = min(low, s - t), max(high, s - t)
    return low, high


@allocation_free
def forbid_near_phases(
    places: Floats, apart: Floats, start: Longs, length: Longs, margin: float, bad: Flags, compatible: Flags
) -> None:
    """Clear compatible[p, q] of periodic states whose robots touch when their clocks differ by up to ``margin`` steps.

    places: (p, 2) metres of the states, cycle by cycle. apart: (c, c) metres between robots on each two cycles. start,
    length: (c,) of the cycles. bad: scratch as long as the longest cycle.
    """
    for a in range(len(start)):
        for b in range(a, len(start)):
            i0, j0, n, m = start[a], start[b], length[a], length[b]
            g = gcd(n, m)
            near = apart[a, b] - TOUCH_M
            if near <= 0:
                continue
            for d in range(g):
                bad[d] = False
            for i in range(n):
                px, py = places[i0 + i, 0], places[i0 + i, 1]
                following = i0 + (i + 1) % n
                vx, vy = places[following, 0] - px, places[following, 1] - py
                for j in range(m):
                    qx, qy = places[j0 + j, 0], places[j0 + j, 1]
                    other = j0 + (j + 1) % m
                    wx, wy = places[other, 0] - qx, places[other, 1] - qy
                    if hypot(px - qx, py - qy) >= near + hypot(vx, vy) + hypot(wx, wy):
                        continue
                    low, high = touching_differences((px - qx, py - qy), (vx, vy), (wx, wy), near, 1.0, 1.0)
                    if low >= high:
                        continue
                    first = floor(i - j + low - margin + SAME) + 1
                    last = ceil(i - j + high + margin - SAME) - 1
                    for d in range(first, min(last, first + g - 1) + 1):
                        bad[d % g] = True
            for i in range(n):
                for j in range(m):
                    if bad[(i - j) % g]:
                        compatible[i0 + i, j0 + j] = False
                        compatible[j0 + j, i0 + i] = False


@allocation_free
def nearest_touch(times: Floats, places: Floats, apart: float, shifts: Floats) -> float:
    """How far shifts of a closed way against itself are from shifts at which two centres come too near, in seconds.

    shifts: (k,) seconds, of any round. times (n + 1,), places (n + 1, 2): of the way's corners; the last place is the
    first one after one round. inf: nothing ever comes near.
    """
    legs, period = len(times) - 1, times[len(times) - 1]
    near, best = apart - TOUCH_M, inf
    for i in range(legs):
        long_s = times[i + 1] - times[i]
        vx, vy = (places[i + 1, 0] - places[i, 0]) / long_s, (places[i + 1, 1] - places[i, 1]) / long_s
        for j in range(legs):
            long_t = times[j + 1] - times[j]
            wx, wy = (places[j + 1, 0] - places[j, 0]) / long_t, (places[j + 1, 1] - places[j, 1]) / long_t
            gx, gy = places[i, 0] - places[j, 0], places[i, 1] - places[j, 1]
            if hypot(gx, gy) >= near + long_s * hypot(vx, vy) + long_t * hypot(wx, wy):
                continue
            low, high = touching_differences((gx, gy), (vx, vy), (wx, wy), near, long_s, long_t)
            if low >= high:
                continue
            low, high = low + times[i] - times[j], high + times[i] - times[j]
            for k in range(len(shifts)):
                below = floor((low - shifts[k]) / period) * period + shifts[k]
                best = min(best, max(low - below, 0.0), max(below + period - high, 0.0))
    return best

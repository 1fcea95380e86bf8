# mypy: disable-error-code="no-any-return"
"""Compiled loops over pairs of limit cycles: in which phases robots stay apart however their clocks differ by a while.

Times are in steps, places in metres. A robot goes straight through each step. While two of them are in steps i and j,
what differences of their clocks make their centres come too near is one interval: the extent of an ellipse, or of a
strip, cut by both steps, along the difference of times.
"""

from __future__ import annotations

from math import ceil, floor, hypot, inf, sqrt

from rota.planners.bounce.cycle_kernels import Flags
from rota.planners.bounce.kernels import Floats, Longs, compiled

TOUCH_M = 1e-6
SAME = 1e-9


@compiled
def _within(gx: float, gy: float, vx: float, vy: float, apart: float) -> tuple[float, float]:
    """First and last time in 0..1 at which ``g + v * time`` is shorter than apart; the first is later: never."""
    a, b, c = vx * vx + vy * vy, gx * vx + gy * vy, gx * gx + gy * gy - apart * apart
    if a <= 1e-24:
        return (0.0, 1.0) if c < 0 else (1.0, 0.0)
    below = b * b - a * c
    if below <= 0:
        return 1.0, 0.0
    root = sqrt(below)
    return max((-b - root) / a, 0.0), min((-b + root) / a, 1.0)


@compiled
def touching_differences(
    gx: float, gy: float, vx: float, vy: float, wx: float, wy: float, apart: float
) -> tuple[float, float]:
    """Extent of s - t over s, t in 0..1 with ``g + v s - w t`` shorter than apart; the least is larger: there are none.

    On each side of the square of times, and where the ellipse's own extremes lie within: there the gap is square to
    the difference of velocities.
    """
    low, high = inf, -inf
    for side in range(2):
        first, last = _within(gx + side * vx, gy + side * vy, -wx, -wy, apart)
        if first <= last:
            low, high = min(low, side - last), max(high, side - first)
        first, last = _within(gx - side * wx, gy - side * wy, vx, vy, apart)
        if first <= last:
            low, high = min(low, first - side), max(high, last - side)
    ux, uy = vx - wx, vy - wy
    size, cross = hypot(ux, uy), vx * wy - vy * wx
    if size > 0 and abs(cross) > 1e-12:
        for sign in (-1.0, 1.0):
            rx, ry = -sign * apart * uy / size - gx, sign * apart * ux / size - gy
            s, t = (rx * wy - ry * wx) / cross, (vy * rx - vx * ry) / cross
            if 0 <= s <= 1 and 0 <= t <= 1:
                low, high = min(low, s - t), max(high, s - t)
    return low, high


@compiled
def forbid_near_phases(
    places: Floats, apart: Floats, start: Longs, length: Longs, margin: float, bad: Flags, compatible: Flags
) -> None:
    """Clear compatible[p, q] of periodic states whose robots touch when their clocks differ by up to ``margin`` steps.

    places: (p, 2) of the states, cycle by cycle; apart: (c, c) metres, of the robots on each two cycles; start, length:
    (c,) of the cycles; bad: scratch as long as the longest cycle.
    """
    for a in range(len(start)):
        for b in range(a, len(start)):
            i0, j0, n, m = start[a], start[b], length[a], length[b]
            g, rest = n, m
            while rest != 0:
                g, rest = rest, g % rest
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
                    low, high = touching_differences(px - qx, py - qy, vx, vy, wx, wy, near)
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

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that find where on its planned route a robot is."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

# of the speed: metres away that a second of another lag weighs as much as; the second one where the first finds nothing
DOUBTS = (0.1, 0.001)


@njit(cache=True)
def _nearest_on_leg(t0, t1, ax, ay, bx, by, x, y, likely_s, weight):
    """The planned moment on a leg that fits a place best, and by how much it misses, in square metres."""
    vx, vy = (bx - ax) / (t1 - t0), (by - ay) / (t1 - t0)
    along = vx * (x - ax) + vy * (y - ay) + weight * (likely_s - t0)
    u = min(max(along / (vx * vx + vy * vy + weight), 0.0), t1 - t0)
    dx, dy, late = ax + vx * u - x, ay + vy * u - y, t0 + u - likely_s
    return t0 + u, dx * dx + dy * dy + weight * late * late


@njit(cache=True)
def _nearest_on_route(x, y, likely, weight, knots_s, knots_m, first, last, loop_start):
    """The planned moment on a route, knots first..last, that fits a place best, and how far it is away in metres."""
    loop = knots_s[last] - knots_s[loop_start]
    best, when = math.inf, likely
    for i in range(first, last):
        t0, t1 = knots_s[i], knots_s[i + 1]
        rounds = 0.0
        if loop > 0.0 and i >= loop_start:
            rounds = max(0.0, math.floor((likely - (t0 + t1) / 2) / loop + 0.5)) * loop
        ax, ay, bx, by = knots_m[i, 0], knots_m[i, 1], knots_m[i + 1, 0], knots_m[i + 1, 1]
        at, miss = _nearest_on_leg(t0 + rounds, t1 + rounds, ax, ay, bx, by, x, y, likely, weight)
        if miss < best:
            best, when = miss, at
    if loop == 0.0:
        # it stays: any moment from its arrival on fits
        at = max(likely, knots_s[last])
        miss = (knots_m[last, 0] - x) ** 2 + (knots_m[last, 1] - y) ** 2 + weight * (at - likely) ** 2
        if miss < best:
            best, when = miss, at
    return when, math.sqrt(max(0.0, best - weight * (when - likely) ** 2))


@njit(cache=True)
def locate(robots, times_s, places, lags_s, offsets, knots_s, knots_m, loop_starts, speeds_m_s, off_route_m):
    """Where on their planned routes robots are that were at places (m, 2) at times_s (m,).

    robots: (m,) whose they are. lags_s: (k,) how far each of all robots was behind its plan last. offsets (k + 1,),
    knots_s (n,), knots_m (n, 2): the timed points of all robots; loop_starts: (k,) index of the first in the loop.
    Returns (m,) how far each is behind its plan in seconds, and how far it is from its route in metres. Where that is
    more than off_route_m (k,), any other lag will do.
    """
    lags, away = np.empty(len(robots)), np.empty(len(robots))
    for m in range(len(robots)):
        k = robots[m]
        likely = times_s[m] - lags_s[k]
        for doubt in DOUBTS:
            weight = (doubt * speeds_m_s[k]) ** 2
            when, away[m] = _nearest_on_route(
                places[m, 0], places[m, 1], likely, weight, knots_s, knots_m, offsets[k], offsets[k + 1] - 1,
                loop_starts[k],
            )  # fmt: skip
            lags[m] = times_s[m] - when
            if away[m] <= off_route_m[k]:
                break
    return lags, away

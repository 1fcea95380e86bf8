# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that find where on its planned route a robot is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import kernel
from rota.model.arrays import Floats, Ints

# of the speed: metres away that a second of another lag weighs as much as; the second one where the first finds nothing
DOUBTS = (0.1, 0.001)


@by_reference
class PlannedRoutes(NamedTuple):
    """The timed points of k robots' routes: those of robot i are knots offsets[i] : offsets[i + 1].

    offsets: (k + 1,). knots_s: (n,), knots_m: (n, 2). loop_starts: (k,) index of the first knot in the loop.
    speeds_m_s: (k,) top speeds.
    """

    offsets: Ints
    knots_s: Floats
    knots_m: Floats
    loop_starts: Ints
    speeds_m_s: Floats


@kernel
def _nearest_on_leg(t0, t1, a, b, place, likely_s, weight):
    """The planned moment on a leg from a to b that fits a place best, and by how much it misses, in square metres."""
    ax, ay = a
    x, y = place
    vx, vy = (b[0] - ax) / (t1 - t0), (b[1] - ay) / (t1 - t0)
    along = vx * (x - ax) + vy * (y - ay) + weight * (likely_s - t0)
    u = min(max(along / (vx * vx + vy * vy + weight), 0.0), t1 - t0)
    dx, dy, late = ax + vx * u - x, ay + vy * u - y, t0 + u - likely_s
    return t0 + u, dx * dx + dy * dy + weight * late * late


@kernel
def _nearest_on_route(place, likely, weight, routes, robot):
    """The planned moment on a robot's route that fits a place best, and how far it is away in metres."""
    knots_s, knots_m, loop_start = routes.knots_s, routes.knots_m, routes.loop_starts[robot]
    first, last = routes.offsets[robot], routes.offsets[robot + 1] - 1
    loop = knots_s[last] - knots_s[loop_start]
    best, when = math.inf, likely
    for i in range(first, last):
        t0, t1 = knots_s[i], knots_s[i + 1]
        rounds = 0.0
        if loop > 0.0 and i >= loop_start:
            rounds = max(0.0, math.floor((likely - (t0 + t1) / 2) / loop + 0.5)) * loop
        a, b = (knots_m[i, 0], knots_m[i, 1]), (knots_m[i + 1, 0], knots_m[i + 1, 1])
        at, miss = _nearest_on_leg(t0 + rounds, t1 + rounds, a, b, place, likely, weight)
        if miss < best:
            best, when = miss, at
    if loop == 0.0:
        # it stays: any moment from its arrival on fits
        at = max(likely, knots_s[last])
        miss = (knots_m[last, 0] - place[0]) ** 2 + (knots_m[last, 1] - place[1]) ** 2 + weight * (at - likely) ** 2
        if miss < best:
            best, when = miss, at
    return when, math.sqrt(max(0.0, best - weight * (when - likely) ** 2))


@kernel
def locate(robots, times_s, places, lags_s, routes, off_route_m):
    """Where on their planned routes robots are that were at places (m, 2) at times_s (m,).

    robots: (m,) whose they are. lags_s: (k,) how far each of all robots was behind its plan last. Returns (m,) how far
    each is behind its plan in seconds, and how far it is from its route in metres. Where that is more than off_route_m
    (k,), any other lag will do.
    """
    lags, away = np.empty(len(robots)), np.empty(len(robots))
    for m in range(len(robots)):
        k = robots[m]
        likely = times_s[m] - lags_s[k]
        for doubt in DOUBTS:
            weight = (doubt * routes.speeds_m_s[k]) ** 2
            when, away[m] = _nearest_on_route((places[m, 0], places[m, 1]), likely, weight, routes, k)
            lags[m] = times_s[m] - when
            if away[m] <= off_route_m[k]:
                break
    return lags, away


@kernel
def _place_at(moment_s, routes, robot):
    """Where a robot is by plan at a moment; where its route begins before that."""
    knots_s, knots_m, start = routes.knots_s, routes.knots_m, routes.loop_starts[robot]
    first, last = routes.offsets[robot], routes.offsets[robot + 1] - 1
    loop = knots_s[last] - knots_s[start]
    if moment_s > knots_s[last] and loop > 0.0:
        moment_s = knots_s[start] + (moment_s - knots_s[start]) % loop
    i = min(max(np.searchsorted(knots_s[first : last + 1], moment_s), 1), max(last - first, 0)) + first
    if i == first:
        return knots_m[first, 0], knots_m[first, 1]
    share = min(max((moment_s - knots_s[i - 1]) / (knots_s[i] - knots_s[i - 1]), 0.0), 1.0)
    x = knots_m[i - 1, 0] + share * (knots_m[i, 0] - knots_m[i - 1, 0])
    return x, knots_m[i - 1, 1] + share * (knots_m[i, 1] - knots_m[i - 1, 1])


@kernel
def planned_m(robots, from_s, to_s, routes):
    """How far apart robots (m,) are by plan at moments from_s (m,) and to_s (m,): (m,) metres."""
    apart = np.empty(len(robots))
    for m in range(len(robots)):
        ax, ay = _place_at(from_s[m], routes, robots[m])
        bx, by = _place_at(to_s[m], routes, robots[m])
        apart[m] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    return apart

"""How far robots' clocks may differ before bodies touch, in closed form for each two legs of two robots.

Two robots are on legs a and b at times s and t of their own clocks. Where their centres are nearer than the bodies
allow is a convex set of pairs (s, t), an ellipse or a strip cut by the legs' times, so that the differences s - t at
which they touch are one interval. The nearest such interval to a difference that the plan itself has is the margin.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.check.motion import segment_distances
from rota.check.near_legs import near_ways
from rota.check.report import Violation
from rota.check.routes import HOLD, LOOP, Routes, routes_of
from rota.check.tolerances import CLOCK_TOLERANCE, PARALLEL, STILL_M2_S2, TOUCH_M
from rota.plan import Plan

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FOR_EVER_S = 1e12
CHUNK = 500_000


def clock_margin_s(plan: Plan) -> float | None:
    """The largest difference of two robots' clocks, in seconds, up to which no bodies touch; inf: they never touch.

    A robot whose clock is late does everything by that much later. Robots whose loops have no common period meet in
    every phase, so that the margin is 0 where their ways come near. None for plans of robots that do not bounce, and
    for fewer than two robots.
    """
    if plan.mission.planning.bouncing is None or len(plan.trajectories) < 2:
        return None
    routes = routes_of(plan)
    bodies = np.array([plan.mission.fleet.robot(trajectory.robot).body_radius_m for trajectory in plan])
    reach = float(np.sort(bodies)[-2:].sum())
    margin = math.inf
    for a, b in near_ways(routes, reach):
        for k in range(0, len(a), CHUNK):
            margin = min(margin, _margin(routes, bodies, a[k : k + CHUNK], b[k : k + CHUNK]))
    return margin


def clock_violations(plan: Plan, margin_s: float | None) -> list[Violation]:
    """The violation of clocks that may drift farther apart between two common signals than the margin allows."""
    rules = plan.mission.planning.bouncing
    if margin_s is None or rules is None:
        return []
    if margin_s >= rules.clock_margin_s * (1 - CLOCK_TOLERANCE):
        return []
    return [
        Violation(
            kind="clocks may differ",
            who=", ".join(trajectory.robot for trajectory in plan),
            place_m=None,
            time_s=None,
            value=rules.clock_margin_s,
            limit=margin_s,
            unit="s",
        )
    ]


def _margin(routes: Routes, bodies: Floats, a: Ints, b: Ints) -> float:
    """The margin over pairs of legs a and b (n,)."""
    apart = bodies[routes.robots[a]] + bodies[routes.robots[b]] - TOUCH_M
    near = segment_distances(routes.legs_m[a], routes.legs_m[b])[0] < apart
    a, b, apart = a[near], b[near], apart[near]
    if not len(a):
        return math.inf
    kind_a, kind_b = routes.kinds[a], routes.kinds[b]
    loops = (kind_a == LOOP) & (kind_b == LOOP)
    robot_a, robot_b = routes.robots[a], routes.robots[b]
    same = routes.classes[robot_a] == routes.classes[robot_b]
    # a robot that stays for ever is met in every round of the other
    endless = (loops & ~same) | ((kind_a == HOLD) & (kind_b == LOOP)) | ((kind_a == LOOP) & (kind_b == HOLD))
    if endless.any():
        return 0.0
    low, high = touching_shifts(routes, a, b, apart)
    touching = high > low
    a, b, low, high, loops = a[touching], b[touching], low[touching], high[touching], loops[touching]
    if not len(a):
        return math.inf
    robot_a, robot_b = routes.robots[a], routes.robots[b]
    parts = np.gcd(routes.parts[robot_a], routes.parts[robot_b])
    period = np.where(loops, parts * routes.units_s[routes.classes[robot_a]], 0.0)
    # of one loop and a way into another: the loop's rounds, from the first on
    once_a, once_b = (routes.kinds[a] == LOOP) & ~loops, (routes.kinds[b] == LOOP) & ~loops
    period = np.where(once_a, routes.durations_s[robot_a], np.where(once_b, routes.durations_s[robot_b], period))
    safe = np.where(period > 0, period, 1.0)
    below = np.where(period > 0, np.floor(low / safe) * safe, 0.0)  # a difference in the plan, below the interval
    above = np.where(period > 0, below + safe, 0.0)
    # in rounds before the first there is no loop: only differences on one side count
    below, above = np.where(once_a, np.minimum(below, 0.0), below), np.where(once_a, np.minimum(above, 0.0), above)
    below, above = np.where(once_b, np.maximum(below, 0.0), below), np.where(once_b, np.maximum(above, 0.0), above)
    margins = np.minimum(_distance(below, low, high), _distance(above, low, high))
    return float(margins.min())


def _distance(at: Floats, low: Floats, high: Floats) -> Floats:
    """Distances (n,) of numbers from open intervals; 0 inside."""
    return np.maximum(np.maximum(low - at, at - high), 0.0)


def touching_shifts(routes: Routes, a: Ints, b: Ints, apart_m: Floats) -> tuple[Floats, Floats]:
    """The least and the largest time on leg a minus time on leg b, (n,) seconds, at which centres are within apart_m.

    a, b: (n,) legs. apart_m: (n,). Both are equal where the centres are never that near.
    """
    p, v, length_a = _motion(routes, a)
    q, w, length_b = _motion(routes, b)
    gap, zero = p - q, np.zeros(len(a))
    found_s: list[Floats] = []
    found_t: list[Floats] = []

    def note(s: Floats, t: Floats) -> None:
        found_s.append(s)
        found_t.append(t)

    for s in (zero, length_a):
        for t in _roots(gap + s[:, None] * v, -w, apart_m, length_b):
            note(s, t)
    for t in (zero, length_b):
        for s in _roots(gap - t[:, None] * w, v, apart_m, length_a):
            note(s, t)
    turn = v - w
    size, cross = np.hypot(*turn.T), v[:, 0] * w[:, 1] - v[:, 1] * w[:, 0]
    ok = (size > 0) & (np.abs(cross) > PARALLEL)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = np.column_stack([-turn[:, 1], turn[:, 0]]) / size[:, None]
        for sign in (1.0, -1.0):
            rest = sign * apart_m[:, None] * normal - gap  # v s - w t = rest
            s = (rest[:, 1] * w[:, 0] - rest[:, 0] * w[:, 1]) / -cross
            t = (v[:, 0] * rest[:, 1] - v[:, 1] * rest[:, 0]) / -cross
            inside = ok & (s >= 0) & (s <= length_a) & (t >= 0) & (t <= length_b)
            note(np.where(inside, s, np.nan), np.where(inside, t, np.nan))
    shift = np.array(found_s) - np.array(found_t) + routes.times_s[a, 0] - routes.times_s[b, 0]
    none = np.isnan(shift).all(axis=0)
    shift[:, none] = 0.0
    return np.nanmin(shift, axis=0), np.nanmax(shift, axis=0)


def _motion(routes: Routes, legs: Ints) -> tuple[Floats, Floats, Floats]:
    """Beginnings (n, 2), velocities (n, 2) and durations (n,) of legs; robots that stay do so for ever."""
    ends, times = routes.legs_m[legs], routes.times_s[legs]
    length = times[:, 1] - times[:, 0]
    speed = (ends[:, 2:] - ends[:, :2]) / np.where(length > 0, length, 1.0)[:, None]
    return ends[:, :2], speed, np.where(routes.kinds[legs] == HOLD, FOR_EVER_S, length)


def _roots(gap: Floats, speed: Floats, apart_m: Floats, length: Floats) -> tuple[Floats, Floats]:
    """The first and last time in 0..length at which ``gap + speed * time`` is no longer than apart_m; nan: never."""
    a, b, c = (speed**2).sum(axis=1), (gap * speed).sum(axis=1), (gap**2).sum(axis=1) - apart_m**2
    still = a <= STILL_M2_S2
    below = b**2 - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(below, 0.0))
        first, last = (-b - root) / a, (-b + root) / a
    first, last = np.where(still, 0.0, np.maximum(first, 0.0)), np.where(still, length, np.minimum(last, length))
    never = np.where(still, c >= 0, below <= 0) | (first > last)
    return np.where(never, np.nan, first), np.where(never, np.nan, last)

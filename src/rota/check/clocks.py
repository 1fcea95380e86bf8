"""How far robots' clocks may differ before bodies touch, in closed form for each two even legs of two robots.

Two robots are on legs a and b at times s and t of their own clocks. Where their centres are nearer than the bodies
allow is a convex set of pairs (s, t), an ellipse or a strip cut by the legs' times, so that the differences s - t at
which they touch are one interval. The nearest such interval to a difference that the plan itself has is the margin.
Legs with an acceleration are cut into parts that a constant velocity misses by next to nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.check.arrays import Flags, Floats, Ints
from rota.check.distances import segment_distances
from rota.check.near_legs import near_ways
from rota.check.report import Violation, violation
from rota.check.routes import HOLD, LOOP, Routes, routes_of
from rota.check.tolerances import CLOCK_TOLERANCE, PARALLEL, STILL_M2_S2, TOUCH_M
from rota.model.plan import Plan

FOR_EVER_S = 1e12
CHUNK = 500_000
MOST_OFF_M = TOUCH_M / 10  # by which an even motion may be off a part of an accelerated one
MOST_PARTS = 1_000_000  # looked at together; of more, margins are told too small rather than too late


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
    who = ", ".join(trajectory.robot for trajectory in plan)
    return [violation("clocks may differ", who, None, None, rules.clock_margin_s, margin_s, "s")]


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

    Of legs with an acceleration the times are those of a distance longer by up to 1e-7 m: where it matters, the parts
    into which they are cut are so short. Of the others it is shown that they touch nowhere, or change nothing.
    """
    low, high = _even_shifts(_Even.of(routes, a), _Even.of(routes, b), apart_m)
    bent = np.flatnonzero((routes.bends[a] != 0) | (routes.bends[b] != 0))
    if len(bent):
        low[bent], high[bent] = _bent_shifts(_Bent.of(routes, a[bent]), _Bent.of(routes, b[bent]), apart_m[bent])
    from_a, from_b = routes.times_s[a, 0], routes.times_s[b, 0]
    low, high = low + from_a - from_b, high + from_a - from_b
    return np.where(np.isnan(low), 0.0, low), np.where(np.isnan(low), 0.0, high)


def _bent_shifts(a: _Bent, b: _Bent, apart_m: Floats) -> tuple[Floats, Floats]:
    """The same of n legs each whose robots may accelerate, from both legs' beginnings on; nan: never."""
    n = len(apart_m)
    pair, parts = np.arange(n), np.stack([np.zeros(n), a.lasts_s, np.zeros(n), b.lasts_s])
    found_low, found_high = np.full(n, np.inf), np.full(n, -np.inf)
    while len(pair):
        off_a_m, off_b_m = a.sag_m(pair, parts[1] - parts[0]), b.sag_m(pair, parts[3] - parts[2])
        wrong_m = off_a_m + off_b_m
        chords = a.chords(pair, parts[0], parts[1]), b.chords(pair, parts[2], parts[3])
        begins_s, sure_m = parts[0] - parts[2], apart_m[pair] - wrong_m
        low, high = (shift + begins_s for shift in _even_shifts(*chords, apart_m[pair] + wrong_m))
        sure_low, sure_high = (shift + begins_s for shift in _even_shifts(*chords, np.maximum(sure_m, 0.0)))
        done = (wrong_m <= MOST_OFF_M) | (len(pair) > MOST_PARTS)
        told = done | (sure_m > 0)
        np.fmin.at(found_low, pair[told], np.where(done, low, sure_low)[told])
        np.fmax.at(found_high, pair[told], np.where(done, high, sure_high)[told])
        left = ~done & ((low < found_low[pair]) | (high > found_high[pair]))
        pair, parts = _halve(pair[left], parts[:, left], (off_a_m >= off_b_m)[left])
    touch = found_low <= found_high
    return np.where(touch, found_low, np.nan), np.where(touch, found_high, np.nan)


def _halve(pair: Ints, parts: Floats, of_a: Flags) -> tuple[Ints, Floats]:
    """Parts (4, n) of two legs' times, from, to and from, to, with the one of the first leg or of the other halved."""
    first, second = parts.copy(), parts.copy()
    for leg, chosen in ((0, of_a), (2, ~of_a)):
        middle = (parts[leg] + parts[leg + 1]) / 2
        first[leg + 1] = np.where(chosen, middle, first[leg + 1])
        second[leg] = np.where(chosen, middle, second[leg])
    return np.tile(pair, 2), np.hstack([first, second])


class _Bent(NamedTuple):
    """Legs that robots may drive with an acceleration: from where and how far, (n, 2) metres, how long, how bent."""

    begin_m: Floats
    along_m: Floats
    lasts_s: Floats
    bends: Floats

    @classmethod
    def of(cls, routes: Routes, legs: Ints) -> _Bent:
        """Those legs (n,)."""
        ends = routes.legs_m[legs]
        lasts_s = np.where(routes.kinds[legs] == HOLD, FOR_EVER_S, np.diff(routes.times_s[legs], axis=1)[:, 0])
        return cls(ends[:, :2], ends[:, 2:] - ends[:, :2], lasts_s, routes.bends[legs])

    def sag_m(self, which: Ints, part_s: Floats) -> Floats:
        """How far robots may be off an even motion with the same ends in a part of some legs' times."""
        whole_s = np.where(self.lasts_s > 0, self.lasts_s, 1.0)[which]
        return np.asarray(np.abs(self.bends[which]) * np.hypot(*self.along_m[which].T) * (part_s / whole_s) ** 2 / 4)

    def chords(self, which: Ints, from_s: Floats, to_s: Floats) -> _Even:
        """The even motions with the same ends in parts of some legs' times."""
        whole_s, bends = np.where(self.lasts_s > 0, self.lasts_s, 1.0)[which], self.bends[which]
        shares = (from_s / whole_s, to_s / whole_s)
        begin, end = (share + bends * share * (share - 1) for share in shares)
        lasts_s = to_s - from_s
        speed = (end - begin)[:, None] * self.along_m[which] / np.where(lasts_s > 0, lasts_s, 1.0)[:, None]
        return _Even(self.begin_m[which] + begin[:, None] * self.along_m[which], speed, lasts_s)


class _Even(NamedTuple):
    """n motions at constant velocities: where they begin (n, 2), velocities (n, 2), how long they last (n,)."""

    begin_m: Floats
    velocity_m_s: Floats
    lasts_s: Floats

    @classmethod
    def of(cls, routes: Routes, legs: Ints) -> _Even:
        """Legs (n,) as if all were driven evenly; robots that stay do so for ever."""
        ends, times = routes.legs_m[legs], routes.times_s[legs]
        length = times[:, 1] - times[:, 0]
        velocity = (ends[:, 2:] - ends[:, :2]) / np.where(length > 0, length, 1.0)[:, None]
        return cls(ends[:, :2], velocity, np.where(routes.kinds[legs] == HOLD, FOR_EVER_S, length))


def _even_shifts(a: _Even, b: _Even, apart_m: Floats) -> tuple[Floats, Floats]:
    """The same of n even motions each, from both beginnings on; nan: never."""
    (p, v, length_a), (q, w, length_b) = a, b
    gap, zero = p - q, np.zeros(len(apart_m))
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
    shift = np.array(found_s) - np.array(found_t)
    return np.fmin.reduce(shift), np.fmax.reduce(shift)


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

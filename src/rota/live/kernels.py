# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that simulate a fleet ahead: when places are seen by plan, and when a period lapses that way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.check.arrays import HOLD, LOOP, Parts
from rota.check.kernels import FIRST_ROOM, leg_sights, part_in_range, room_for_parts
from rota.check.shadow_kernels import shadows_of
from rota.check.tiling_kernels import cell_of, in_cell
from rota.check.timing_kernels import time_along
from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import kernel
from rota.model.arrays import Flags, Floats, Ints

SAME_S = 1e-9  # a sight that ends no later than this after a moment brings nothing on
MOST_STEPS = 100_000  # sights that one place is followed through


@by_reference
class PlannedSights(NamedTuple):
    """When robots see each place by plan: those of place p are rows offsets[p] : offsets[p + 1] of the others.

    robots: (s,) which robot. starts_s, ends_s: (s,) seconds of the plan. again: (s,) whether it repeats with the loop.
    """

    offsets: Ints
    robots: Ints
    starts_s: Floats
    ends_s: Floats
    again: Flags


@by_reference
class Team(NamedTuple):
    """How k robots follow their plan: loops_s (k,) durations of their loops, 0 where they stay.

    lags_s: (k,) how far each is behind its plan. until_s: (k,) how long it goes on; -inf: it is not counted on.
    """

    loops_s: Floats
    lags_s: Floats
    until_s: Floats


@kernel
def planned_sights(points, slack_m, grid, legs, team, walls):
    """The sights of points (n, 2) by plan, as the arrays of ``PlannedSights``; the last four are those of the check."""
    offsets = np.zeros(len(points) + 1, np.int64)
    robots, starts, ends = np.empty(FIRST_ROOM, np.int64), np.empty(FIRST_ROOM), np.empty(FIRST_ROOM)
    again = np.empty(FIRST_ROOM, np.bool_)
    parts = Parts(np.empty(FIRST_ROOM), np.empty(FIRST_ROOM))
    widest = team.reaches_m.max() if len(team.reaches_m) else 0.0
    n = 0
    for k in range(len(points)):
        piece, first = points[k : k + 1], n
        cell = cell_of(piece[0, 0], piece[0, 1], grid)
        shadows = shadows_of(piece, walls, cell, slack_m, widest)
        parts = room_for_parts(parts, shadows)
        for m in in_cell(legs.near, cell):
            robot, leg = legs.robots[m], legs.near.segments_m[m]
            lo, hi = part_in_range(piece, leg, team.reaches_m[robot] + slack_m, team.squares[robot])
            if lo > hi:
                continue
            kept = leg_sights(piece, leg, lo, hi, shadows, slack_m, parts)
            t0, t1, bend = legs.times_s[m, 0], legs.times_s[m, 1], legs.bends[m]
            if n + kept > len(starts):
                room = n + kept
                robots, again = np.append(robots, np.empty(room, np.int64)), np.append(again, np.empty(room, np.bool_))
                starts, ends = np.append(starts, np.empty(room)), np.append(ends, np.empty(room))
            for p in range(kept):
                start, end = time_along(t0, t1, bend, parts.starts[p]), time_along(t0, t1, bend, parts.ends[p])
                if legs.kinds[m] == HOLD:
                    end = math.inf
                repeats = legs.kinds[m] == LOOP
                joined = n > first and robots[n - 1] == robot and again[n - 1] == repeats
                if joined and start <= ends[n - 1] + SAME_S:
                    ends[n - 1] = max(ends[n - 1], end)
                else:
                    robots[n], starts[n], ends[n], again[n] = robot, start, end, repeats
                    n += 1
        offsets[k + 1] = n
    return offsets, robots[:n].copy(), starts[:n].copy(), ends[:n].copy(), again[:n].copy()


@kernel
def next_sight(place, after_s, now_s, sights, team):
    """The first sight of a place that ends after a moment, and not before now: its start, end and robot.

    inf, inf, -1 where there is none. A sight that is going on starts now at the earliest: what robots saw until now
    they have reported.
    """
    from_s = max(after_s, now_s) + SAME_S
    best, until, who = math.inf, math.inf, -1
    for i in range(sights.offsets[place], sights.offsets[place + 1]):
        robot = sights.robots[i]
        if team.until_s[robot] <= now_s:
            continue
        start, end = sights.starts_s[i] + team.lags_s[robot], sights.ends_s[i] + team.lags_s[robot]
        if sights.again[i]:
            loop = team.loops_s[robot]
            rounds = max(0.0, math.floor((from_s - end) / loop) + 1.0)
            if end + rounds * loop <= from_s:
                rounds += 1.0  # which rounding had taken away
            start, end = start + rounds * loop, end + rounds * loop
        start, end = max(start, now_s), min(end, team.until_s[robot])
        if start <= end and end > from_s and (start < best or (start == best and end > until)):
            best, until, who = start, end, robot
    return best, until, who


@kernel
def lapse_of(place, seen_s, period_s, now_s, until_s, sights, team):
    """When the period of a place lapses if robots go on by plan, each with its lag; inf: not until until_s.

    seen_s: when it was seen last.
    """
    for _ in range(MOST_STEPS):
        start, end, _who = next_sight(place, seen_s, now_s, sights, team)
        if start - seen_s > period_s:
            return seen_s + period_s if seen_s + period_s <= until_s else math.inf
        seen_s = max(seen_s, end)
        if seen_s + period_s > until_s:
            return math.inf
    return math.inf


@kernel
def first_lapses(last_seen_s, demand, demands, periods_s, until_s, now_s, sights, team):
    """For each demand when its first place lapses (inf: none does), and which place: (demands,) each.

    until_s: (n,) until when each place is looked at.
    """
    when, where = np.full(demands, math.inf), np.full(demands, -1, np.int64)
    for p in range(len(last_seen_s)):
        k = demand[p]
        until = min(when[k], until_s[p])
        lapse = lapse_of(p, last_seen_s[p], periods_s[p] * (1 + SAME_S), now_s, until, sights, team)
        if lapse < when[k]:
            when[k], where[k] = lapse, p
    return when, where

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of one run: how robots get on, who waits for whom, and how full their batteries are meanwhile."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.check.tolerances import BATTERY_S, SAME_TIME
from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import kernel
from rota.model.arrays import Floats, Ints
from rota.model.limits import KEPT_SHARE


@by_reference
class Batteries(NamedTuple):
    """What k robots use by plan, leg by leg; those of robot r are rows firsts[r] : firsts[r + 1] of (m,).

    again: (k,) the row at which its loop begins, which takes loops_s (k,), 0 where it stays. begins_s, ends_s: by plan.
    uses: seconds of driving that a second of the leg takes. docks: the charger at which it is spent, -1: none. fills:
    what a second there adds; swaps_s: after how long all is full, inf: never. leaves_s: when it leaves its charger by
    plan. needs_s: what is used from the leg's end, or from leaving its charger, until it charges. endurance_s (inf: no
    limit), takeoff_s, reserve_s: (k,). landing_s, climbing_s: (k,) of its stays nothing is charged in these.
    """

    firsts: Ints
    again: Ints
    loops_s: Floats
    endurance_s: Floats
    takeoff_s: Floats
    landing_s: Floats
    climbing_s: Floats
    reserve_s: Floats
    begins_s: Floats
    ends_s: Floats
    uses: Floats
    docks: Ints
    fills: Floats
    swaps_s: Floats
    leaves_s: Floats
    needs_s: Floats


@by_reference
class Fills(NamedTuple):
    """How batteries are on the way: leg, turned_s: (k,) where each robot is by plan. levels_s: (k,) what is left.

    stood_s: (k,) how long it has been at its charger. least_s, least_at_s: (k,) the least that was left, and when.
    stay: (k,) its row of stays_s (s, 2), from when until when it was at a charger, -1: at none. stays: (s, 2) whose
    they are, and at which charger. noted: (1,) how many there are. left: (k,) how often it left a charger. hurries_s,
    hurries_at_s: (k,) by how much it was ahead of the clock at most since its battery did not let it wait, and when.
    """

    leg: Ints
    turned_s: Floats
    levels_s: Floats
    stood_s: Floats
    least_s: Floats
    least_at_s: Floats
    stay: Ints
    stays_s: Floats
    stays: Ints
    noted: Ints
    left: Ints
    hurries_s: Floats
    hurries_at_s: Floats


@by_reference
class Chance(NamedTuple):
    """What chance has in store for k robots.

    slowness: (k, g) times as long each takes, for ``gust`` ticks each. fails_s: (k,) when it fails. late_s: (k, d) by
    how much it is late each time that it leaves a charger. waits_s: (k,) by how much it may be late before all wait for
    it (inf: nobody does); for one that has failed nobody waits.
    """

    slowness: Floats
    gust: int
    fails_s: Floats
    late_s: Floats
    waits_s: Floats


@kernel
def drive(least_s, chance, batteries, fills, tick_s, first_tick, starts_s, clock_s):
    """When robots come to each moment of their plans, (k, n + 1) seconds, and the clock of all then, (n + 1,).

    least_s: (k, n) how long each takes at least for what its plan has in each tick. first_tick: of the run, at which
    the plan begins; starts_s: (k,) when each begins it; clock_s: the clock of all then. A robot is never early: it
    drives as slowly as the plan asks, and waits where all do, as long as its battery lets it come to its charger. It
    stays there for as long as its next flight needs; a relief is late on top of that.
    """
    robots, ticks = least_s.shape
    times_s, clocks_s = np.empty((robots, ticks + 1)), np.empty(ticks + 1)
    times_s[:, 0], clocks_s[0] = starts_s, clock_s
    for n in range(ticks):
        goal_s = clocks_s[n] + tick_s
        lost_s = 0.0
        for r in range(robots):
            own_s = times_s[r, n] + least_s[r, n] * chance.slowness[r, (first_tick + n) // chance.gust]
            if batteries.leaves_s[fills.leg[r]] + fills.turned_s[r] < (n + 2) * tick_s:
                own_s = max(own_s, _leaves_after(batteries, fills, chance, r, times_s[r, n], goal_s, n, tick_s))
            times_s[r, n + 1] = own_s
            if own_s < chance.fails_s[r]:
                lost_s = max(lost_s, own_s - goal_s - chance.waits_s[r])
        clocks_s[n + 1] = goal_s + lost_s
        for r in range(robots):
            latest_s = _waits_until(batteries, fills, r, n * tick_s, times_s[r, n], tick_s)
            waits_s = min(clocks_s[n + 1], latest_s)
            times_s[r, n + 1] = max(times_s[r, n + 1], waits_s)
            ahead_s = clocks_s[n + 1] - times_s[r, n + 1]
            if times_s[r, n] < chance.fails_s[r]:
                if ahead_s > fills.hurries_s[r] and batteries.docks[fills.leg[r]] < 0:
                    fills.hurries_s[r], fills.hurries_at_s[r] = ahead_s, times_s[r, n + 1]
                _spend(batteries, fills, r, n * tick_s, tick_s, times_s[r, n], times_s[r, n + 1])
    return times_s, clocks_s


@kernel
def _leaves_after(batteries, fills, chance, r, now_s, goal_s, n, tick_s):
    """When a robot that is about to leave its charger has done the last whole tick there, the n-th one.

    Its battery holds what the next flight needs and the reserve, or is full. A late relief comes after the clock of
    all.
    """
    leg = fills.leg[r]
    after_s = batteries.leaves_s[leg] + fills.turned_s[r] - (n + 1) * tick_s
    if batteries.docks[leg] < 0 or after_s < 0:
        return 0.0
    stays_s = 0.0
    full_s, level_s = batteries.endurance_s[r], fills.levels_s[r]
    # of what is left of its stay by plan it climbs in the last part, and lands in the first one
    grounding_s = min(batteries.climbing_s[r], after_s + tick_s) + max(batteries.landing_s[r] - fills.stood_s[r], 0.0)
    if full_s < math.inf:
        enough_s = min(batteries.needs_s[leg] + batteries.reserve_s[r], full_s) - BATTERY_S
        if level_s < enough_s:
            if batteries.swaps_s[leg] < math.inf:
                charged_s = max(fills.stood_s[r] - batteries.landing_s[r], 0.0)
                stays_s = batteries.swaps_s[leg] - charged_s - after_s + grounding_s
            elif batteries.fills[leg] > 0:
                stays_s = (enough_s - level_s) / batteries.fills[leg] - after_s + grounding_s
    late_s = chance.late_s[r, min(fills.left[r], chance.late_s.shape[1] - 1)]
    return max(now_s + stays_s, goal_s + late_s if late_s > 0 else 0.0)


@kernel
def _waits_until(batteries, fills, r, planned_s, now_s, tick_s):
    """Until when a robot can put off what it has to do in a tick, so that its battery takes it to its charger."""
    leg = fills.leg[r]
    if batteries.docks[leg] >= 0 or batteries.endurance_s[r] == math.inf or batteries.uses[leg] <= 0:
        return math.inf
    rest_s = max(batteries.ends_s[leg] + fills.turned_s[r] - planned_s, 0.0)
    needs_s = batteries.uses[leg] * rest_s + batteries.needs_s[leg]
    spare_s = fills.levels_s[r] - batteries.reserve_s[r] - (1 + KEPT_SHARE) * needs_s
    return now_s + tick_s + max(spare_s, 0.0) / batteries.uses[leg]


@kernel
def _spend(batteries, fills, r, planned_s, tick_s, from_s, until_s):
    """Let a robot do what its plan has in a tick from planned_s on, in the time from from_s until until_s."""
    pace = (until_s - from_s) / tick_s
    at_s, last_s = planned_s, planned_s + tick_s
    while at_s < last_s:
        leg = fills.leg[r]
        end_s = batteries.ends_s[leg] + fills.turned_s[r]
        to_s = min(end_s, last_s)
        lasts_s, begun_s = max(to_s - at_s, 0.0) * pace, from_s + (at_s - planned_s) * pace
        if batteries.docks[leg] >= 0:
            if fills.stay[r] < 0:
                _arrive(fills, r, batteries.docks[leg], begun_s)
            climbs_s = to_s - max(at_s, batteries.leaves_s[leg] + fills.turned_s[r] - batteries.climbing_s[r])
            _charge(batteries, fills, r, leg, lasts_s, max(climbs_s, 0.0))
        else:
            if fills.stay[r] >= 0:
                fills.stays_s[fills.stay[r], 1] = begun_s
                fills.stay[r] = -1
                fills.left[r] += 1
                fills.levels_s[r] -= batteries.takeoff_s[r]
            fills.levels_s[r] -= batteries.uses[leg] * lasts_s
            if fills.levels_s[r] < fills.least_s[r]:
                fills.least_s[r], fills.least_at_s[r] = fills.levels_s[r], begun_s + lasts_s
        at_s = max(to_s, at_s)
        if end_s <= last_s:
            fills.leg[r] += 1
            if fills.leg[r] == batteries.firsts[r + 1]:
                fills.leg[r] = batteries.again[r]
                fills.turned_s[r] += batteries.loops_s[r]


@kernel
def _arrive(fills, r, charger, time_s):
    """Note that a robot has come to a charger; it is there until it leaves."""
    row = fills.noted[0]
    fills.noted[0] += 1
    fills.stay[r], fills.stood_s[r] = row, 0.0
    fills.stays_s[row, 0], fills.stays_s[row, 1] = time_s, math.inf
    fills.stays[row, 0], fills.stays[row, 1] = r, charger


@kernel
def _charge(batteries, fills, r, leg, lasts_s, climbs_s):
    """Let a robot be at its charger for so long, of which it climbs for ``climbs_s`` in the end."""
    lands_s = max(batteries.landing_s[r] - fills.stood_s[r], 0.0)
    fills.stood_s[r] += lasts_s
    full_s = batteries.endurance_s[r]
    if batteries.swaps_s[leg] < math.inf:
        charged_s = fills.stood_s[r] - batteries.landing_s[r] - climbs_s
        if charged_s >= batteries.swaps_s[leg] * (1.0 - SAME_TIME):
            fills.levels_s[r] = full_s
    elif full_s < math.inf:
        charged_s = max(lasts_s - lands_s - climbs_s, 0.0)
        fills.levels_s[r] = min(full_s, fills.levels_s[r] + batteries.fills[leg] * charged_s)

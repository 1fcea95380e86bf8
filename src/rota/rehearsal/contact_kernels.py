# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that lay out where robots are in one run, and find when the bodies of two of them touch."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import kernel
from rota.model.arrays import Flags, Floats
from rota.rehearsal.kernels import real_time

SAMPLES = 16  # of a piece along which one robot accelerates
HALVINGS = 40


@by_reference
class Legs(NamedTuple):
    """One robot's plan: times_s (n,), places_m (n, 3), bends (n - 1,), and the index at which its loop begins.

    docked: (n - 1,) whether it spends a leg at a charger, in nobody's way.
    """

    times_s: Floats
    places_m: Floats
    bends: Floats
    docked: Flags
    loop_index: int


@by_reference
class Track(NamedTuple):
    """Where a robot is in one run: at places_m[i] (n, 3) at times_s[i], and straight between them.

    Of the share u of a piece's time it has done its way from i to i + 1 by u, and bows_m[i] (n, 3) times u (u - 1).
    docked: (n,) whether it spends that piece at a charger.
    """

    times_s: Floats
    places_m: Floats
    bows_m: Floats
    docked: Flags


@kernel
def lay_track(legs, driven, robot, track):
    """Write a robot's track into one with room for it; returns how many places it has.

    Pieces end where legs and ticks do, so that real time goes evenly along each.
    """
    times_s, places_m, bows_m, docked = track.times_s, track.places_m, track.bows_m, track.docked
    came_s = driven.times_s[robot]
    stops_s = min(driven.fails_s[robot], driven.end_s)
    last = len(legs.times_s) - 1
    loop_s = legs.times_s[last] - legs.times_s[legs.loop_index]
    leg, turned_s, tick, planned_s = 0, 0.0, 0, 0.0
    times_s[0], places_m[0] = came_s[0], legs.places_m[0]
    n = 0
    while leg < last and times_s[n] < stops_s:
        begin_s, end_s = legs.times_s[leg] + turned_s, legs.times_s[leg + 1] + turned_s
        to_s = min(end_s, (tick + 1) * driven.tick_s)
        low = max(0.0, (planned_s - begin_s) / (end_s - begin_s))
        high = 1.0 if to_s == end_s else (to_s - begin_s) / (end_s - begin_s)
        arrives_s = max(times_s[n], real_time(came_s, to_s / driven.tick_s))
        if arrives_s > stops_s:
            high = low + (high - low) * (stops_s - times_s[n]) / (arrives_s - times_s[n])
            arrives_s = stops_s
        along = legs.places_m[leg + 1] - legs.places_m[leg]
        bend = legs.bends[leg]
        n += 1
        times_s[n] = arrives_s
        places_m[n] = legs.places_m[leg] + (high + bend * high * (high - 1.0)) * along
        docked[n - 1] = legs.docked[leg]
        bows_m[n - 1] = bend * (high - low) ** 2 * along
        planned_s = to_s
        if (tick + 1) * driven.tick_s <= to_s:
            tick += 1
        if to_s == end_s:
            leg += 1
            if leg == last and loop_s > 0:
                leg, turned_s = legs.loop_index, turned_s + loop_s
    # it stands from then on
    bows_m[n], docked[n] = 0.0, n > 0 and docked[n - 1]
    times_s[n + 1], places_m[n + 1] = max(times_s[n], driven.end_s), places_m[n]
    return n + 2


@kernel
def _gap_at(gap, along, bow, share):
    """How far two robots are from each other at a share of a piece of time."""
    total = 0.0
    for k in range(3):
        away = gap[k] + share * along[k] + share * (share - 1.0) * bow[k]
        total += away * away
    return math.sqrt(total)


@kernel
def _nearest(gap, along, bow):
    """The share of a piece of time at which two robots are nearest to each other."""
    along2 = along[0] * along[0] + along[1] * along[1] + along[2] * along[2]
    toward = gap[0] * along[0] + gap[1] * along[1] + gap[2] * along[2]
    if bow[0] == 0.0 and bow[1] == 0.0 and bow[2] == 0.0:
        return 0.0 if along2 == 0.0 else min(1.0, max(0.0, -toward / along2))
    best = 0.0
    for k in range(1, SAMPLES + 1):
        if _gap_at(gap, along, bow, k / SAMPLES) < _gap_at(gap, along, bow, best):
            best = k / SAMPLES
    low, high = max(0.0, best - 1.0 / SAMPLES), min(1.0, best + 1.0 / SAMPLES)
    for _ in range(HALVINGS):
        one, other = low + (high - low) / 3.0, high - (high - low) / 3.0
        if _gap_at(gap, along, bow, one) < _gap_at(gap, along, bow, other):
            high = other
        else:
            low = one
    return (low + high) / 2.0


@kernel
def _part(track, i, from_s, to_s, begin, along, bow):
    """Write what a robot does from one time to another on piece i: where it begins, its way and its bow, (3,) each."""
    lasts_s = track.times_s[i + 1] - track.times_s[i]
    low = (from_s - track.times_s[i]) / lasts_s if lasts_s > 0 else 0.0
    high = (to_s - track.times_s[i]) / lasts_s if lasts_s > 0 else 1.0
    for k in range(3):
        way, curve = track.places_m[i + 1, k] - track.places_m[i, k], track.bows_m[i, k]
        begin[k] = track.places_m[i, k] + low * way + low * (low - 1.0) * curve
        along[k] = (high - low) * way + (high * (high - 1.0) - low * (low - 1.0)) * curve
        bow[k] = (high - low) ** 2 * curve


@kernel
def first_touch(one, other, apart_m, from_s, to_s):
    """When and where centres first are nearer than apart_m between two times: seconds, x, y; inf, nan, nan: never."""
    ways = np.empty((6, 3))
    gap, along, bow = np.empty(3), np.empty(3), np.empty(3)
    i = max(0, np.searchsorted(one.times_s, from_s) - 1)
    j = max(0, np.searchsorted(other.times_s, from_s) - 1)
    now_s = from_s
    while i + 1 < len(one.times_s) and j + 1 < len(other.times_s) and now_s < to_s:
        then_s = min(to_s, one.times_s[i + 1], other.times_s[j + 1])
        _part(one, i, now_s, then_s, ways[0], ways[1], ways[2])
        _part(other, j, now_s, then_s, ways[3], ways[4], ways[5])
        bowed = 0.0
        for k in range(3):
            gap[k], along[k], bow[k] = ways[3, k] - ways[0, k], ways[4, k] - ways[1, k], ways[5, k] - ways[2, k]
            bowed += bow[k] * bow[k]
        reach_m = apart_m + math.sqrt(bowed) / 4.0
        way2 = along[0] * along[0] + along[1] * along[1] + along[2] * along[2]
        far2 = gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]
        if not (one.docked[i] or other.docked[j]) and math.sqrt(far2) - math.sqrt(way2) < reach_m:
            share = _nearest(gap, along, bow)
            if _gap_at(gap, along, bow, share) < apart_m:
                bent = share * (share - 1.0)
                for k in range(3):
                    gap[k] = 0.5 * (ways[0, k] + ways[3, k] + share * (ways[1, k] + ways[4, k]))
                    gap[k] += 0.5 * bent * (ways[2, k] + ways[5, k])
                return now_s + share * (then_s - now_s), gap[0], gap[1]
        if one.times_s[i + 1] <= then_s:
            i += 1
        if other.times_s[j + 1] <= then_s:
            j += 1
        now_s = then_s
    return math.inf, math.nan, math.nan

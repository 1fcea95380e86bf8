# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of one run: when robots come to what they planned, and how long each place then stays unseen."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import kernel
from rota.model.arrays import Floats, Ints

ON_TIME = 1e-9  # the share of a period by which a gap may be longer


@by_reference
class Driven(NamedTuple):
    """How k robots drive in one run: at times_s[r, n] robot r is where its plan has it at n * tick_s.

    times_s: (k, n). loops_s: (k,) durations of their loops, 0 where they stay. fails_s: (k,) from when on each stands
    and sees nothing (inf: never). What is looked at begins at begin_s and ends at end_s.
    """

    times_s: Floats
    tick_s: float
    loops_s: Floats
    fails_s: Floats
    begin_s: float
    end_s: float


@by_reference
class Asked(NamedTuple):
    """What is asked of n places: of which demand each is, (n,), its period, (n,), and its weight among those, (n,)."""

    demand: Ints
    periods_s: Floats
    weights: Floats


@kernel
def real_time(times_s, ticks):
    """When a robot is where its plan has it after so many ticks; inf: after all that is looked at. times_s: (n,)."""
    whole = int(ticks)
    if whole + 1 >= len(times_s):
        return math.inf
    return times_s[whole] + (ticks - whole) * (times_s[whole + 1] - times_s[whole])


@kernel
def _streams_of(place, sights, streams):
    """Fill ``streams`` (k, 4) with those of a place, one for each robot that sees it; returns how many there are.

    Columns: the robot, the first of its rows in ``PlannedSights``, the first that repeats and the one after the last.
    """
    count, robot = 0, -1
    for i in range(sights.offsets[place], sights.offsets[place + 1]):
        if sights.robots[i] != robot:
            robot = sights.robots[i]
            streams[count, 0], streams[count, 1], streams[count, 2] = robot, i, -1
            count += 1
        streams[count - 1, 3] = i + 1
        if sights.again[i] and streams[count - 1, 2] < 0:
            streams[count - 1, 2] = i
    for m in range(count):
        if streams[m, 2] < 0:
            streams[m, 2] = streams[m, 3]
    return count


@kernel
def _most_sights(streams, driven):
    """How many sights streams (m, 4) have at most in a run."""
    count = 0
    for robot, first, again, stop in streams:
        count += again - first
        if again < stop:
            count += (stop - again) * (2 + int(driven.end_s / driven.loops_s[robot]))
    return count


@kernel(noinline=True)
def _run_along(stream, sights, driven, starts_s, ends_s):
    """Write when one robot sees one place in a run, ascending; returns how many times. Robots are never early."""
    robot, first, again, stop = stream
    times_s, loop_s = driven.times_s[robot], driven.loops_s[robot]
    last_s, per_tick = min(driven.fails_s[robot], driven.end_s), 1.0 / driven.tick_s
    begins_s, finishes_s = sights.starts_s, sights.ends_s
    n, turned_s = 0, 0.0
    while first < stop:
        for i in range(first, stop):
            start_s = real_time(times_s, (begins_s[i] + turned_s) * per_tick)
            if start_s > last_s:
                return n
            starts_s[n], ends_s[n] = start_s, last_s
            if finishes_s[i] < math.inf:
                ends_s[n] = min(last_s, real_time(times_s, (finishes_s[i] + turned_s) * per_tick))
            n += 1
        first = again
        turned_s += loop_s
    return n


@kernel(noinline=True)
def _merge(mine, k, other, m, out):
    """Write two ascending lists of times, of k and m of the columns of (2, n) starts and ends, as one."""
    i, j = 0, 0
    for n in range(k + m):
        if j == m or (i < k and mine[0, i] <= other[0, j]):
            out[0, n], out[1, n] = mine[0, i], mine[1, i]
            i += 1
        else:
            out[0, n], out[1, n] = other[0, j], other[1, j]
            j += 1


@kernel
def _note_late(from_s, to_s, weight, driven, late):
    """Add what of a time lies in each of the parts, (b,), into which what is looked at is cut."""
    part_s = (driven.end_s - driven.begin_s) / len(late)
    for b in range(int((from_s - driven.begin_s) / part_s), len(late)):
        low_s, high_s = driven.begin_s + b * part_s, driven.begin_s + (b + 1) * part_s
        if low_s >= to_s:
            return
        late[b] += weight * max(0.0, min(high_s, to_s) - max(low_s, from_s))


@kernel(noinline=True)
def _gaps_between(seen, n, allowed_s, weight, driven, late):
    """The seconds beyond a period and the longest gap between n sights, columns of (2, n) starts and ends, ascending.

    late: (b,) takes the seconds by weight and part of the time.
    """
    seen_s, worst_s, lapsed_s = driven.begin_s, 0.0, 0.0
    tolerated_s = allowed_s * (1 + ON_TIME)
    for i in range(n + 1):
        start_s = seen[0, i] if i < n else driven.end_s
        gap_s = start_s - seen_s
        worst_s = max(worst_s, gap_s)
        if gap_s > tolerated_s:
            lapsed_s += gap_s - allowed_s
            _note_late(seen_s + allowed_s, start_s, weight, driven, late)
        if i < n:
            seen_s = max(seen_s, seen[1, i])
    return lapsed_s, worst_s


@kernel
def watch_places(sights, driven, asked, late, late_s, worst_s):
    """How long each place is unseen: late_s, worst_s (n,) take the seconds beyond its period, and the longest gap.

    late: (demands, b) the same seconds by demand and part of the time, by weight. A gap begins no sooner than all that
    is looked at, and one that goes on in the end counts as far as it has gone.
    """
    streams = np.empty((len(driven.loops_s), 4), np.int64)
    seen, more, joined = np.empty((2, 1)), np.empty((2, 1)), np.empty((2, 1))
    for place in range(len(asked.demand)):
        count = _streams_of(place, sights, streams)
        most = _most_sights(streams[:count], driven)
        if most > seen.shape[1]:
            seen, more, joined = np.empty((2, 2 * most)), np.empty((2, 2 * most)), np.empty((2, 2 * most))
        n = 0
        for m in range(count):
            k = _run_along(streams[m], sights, driven, more[0], more[1])
            if n == 0:
                seen, more, n = more, seen, k
                continue
            _merge(seen, n, more, k, joined)
            seen, joined, n = joined, seen, n + k
        late_s[place], worst_s[place] = _gaps_between(
            seen, n, asked.periods_s[place], asked.weights[place], driven, late[asked.demand[place]]
        )

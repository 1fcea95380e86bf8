# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that turn the times at which each robot sees a piece into the worst gap between any two sights.

``SeenTimes`` hold the sights of all robots, robot by robot; a robot's number is its place there, from 0 to n - 1. A
class of commensurable loops counts its periods in ``parts`` of one unit of time.
"""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import allocation_free, kernel

EXPAND_AT_ONCE, EXPAND_AT_MOST = 512, 100_000


@allocation_free
def _lone_gap(times, m, period_s):
    """Worst gap of the m-th robot alone, whose loop takes ``period_s``, and the time at which it begins."""
    starts, ends, lo, hi = times.starts_s, times.ends_s, times.bounds[m], times.bounds[m + 1]
    worst, when = starts[lo] + period_s - ends[hi - 1], ends[hi - 1]
    for i in range(lo + 1, hi):
        if starts[i] - ends[i - 1] > worst:
            worst, when = starts[i] - ends[i - 1], ends[i - 1]
    return max(worst, 0.0), when


@kernel(noinline=True)
def _shared_gap(times, members, parts, unit_s, common):
    """Worst gap of several robots over their common period of ``common`` units, and the time at which it begins."""
    starts, ends, bounds, robots = times
    count = 0  # of what the loops below write, at most EXPAND_AT_MOST
    for m in members:
        count += (bounds[m + 1] - bounds[m]) * (common // parts[robots[m]])
    begin, finish = np.empty(count), np.empty(count)
    n, covered = 0, -np.inf
    for m in members:
        part = parts[robots[m]]
        for i in range(bounds[m], bounds[m + 1]):
            first = starts[i] % (part * unit_s)
            for k in range(common // part):
                begin[n] = first + k * part * unit_s
                finish[n] = begin[n] + (ends[i] - starts[i])
                covered = max(covered, finish[n])
                n += 1
    order = np.argsort(begin)
    covered -= common * unit_s
    worst, when = 0.0, 0.0
    for i in order:
        if begin[i] - covered > worst:
            worst, when = begin[i] - covered, covered
        covered = max(covered, finish[i])
    return worst, when


@kernel
def pair_gap(times, a, b, period_a, period_b, shared_s):
    """Worst gap in seconds of robots a and b whose phases differ by any multiple of ``shared_s``.

    ``shared_s`` is the common measure of both periods. A gap of the two is the overlap of a gap of each; the overlap is
    largest when their middles are nearest.
    """
    starts, ends = times.starts_s, times.ends_s
    lo_a, hi_a, lo_b, hi_b = times.bounds[a], times.bounds[a + 1], times.bounds[b], times.bounds[b + 1]
    worst = 0.0
    for i in range(lo_a, hi_a):
        a0, a1 = ends[i], (starts[i + 1] if i + 1 < hi_a else starts[lo_a] + period_a)
        if a1 - a0 <= worst:
            continue
        for j in range(lo_b, hi_b):
            b0, b1 = ends[j], (starts[j + 1] if j + 1 < hi_b else starts[lo_b] + period_b)
            if b1 - b0 <= worst:
                continue
            # whole numbers as floats, since those of tiny measures are no int64
            shift = np.floor((a0 + a1 - b0 - b1) / (2 * shared_s) + 0.5) * shared_s
            worst = max(worst, min(a1, b1 + shift) - max(a0, b0 + shift))
    return worst


@allocation_free
def _divisor(a, b):
    """The greatest common divisor of two whole numbers."""
    while b:
        a, b = b, a % b
    return a


@kernel
def _class_gap(times, members, parts, unit_s, limit_s):
    """Worst gap of commensurable loops, the time at which it begins, its period, and whether it is exact.

    members: (n,) robots whose loops these are; parts: (k,) of the whole team. A gap of at most ``limit_s`` need not be
    exact.
    """
    bounds, robots = times.bounds, times.robots
    if len(members) == 1:
        m = members[0]
        period = parts[robots[m]] * unit_s
        gap, when = _lone_gap(times, m, period)
        return gap, when, period, True
    common, count = parts[robots[members[0]]], 0
    for m in members:
        part = parts[robots[m]]
        common = min(common // _divisor(common, part) * part, 1 << 40)
    for m in members:
        count += min((bounds[m + 1] - bounds[m]) * (common // parts[robots[m]]), 1 << 40)
    if common < 1 << 40 and count <= EXPAND_AT_ONCE:
        gap, when = _shared_gap(times, members, parts, unit_s, common)
        return gap, when, common * unit_s, True
    best = math.inf
    for i in range(len(members)):
        a = members[i]
        period_a = parts[robots[a]] * unit_s
        for j in range(i):
            b = members[j]
            period_b = parts[robots[b]] * unit_s
            shared = _divisor(parts[robots[a]], parts[robots[b]]) * unit_s
            best = min(best, pair_gap(times, a, b, period_a, period_b, shared))
    if len(members) == 2 or best <= limit_s:
        return best, math.nan, 1.0, len(members) == 2
    if common < 1 << 40 and count <= EXPAND_AT_MOST:
        gap, when = _shared_gap(times, members, parts, unit_s, common)
        return gap, when, common * unit_s, True
    return best, math.nan, 1.0, False


@kernel(noinline=True)
def team_gap(times, n, loops, limit_s):
    """Worst gap in seconds of the n robots in ``times``, the time at which it begins, and whether it is exact.

    The time is nan where it is not known. Classes of loops without a common period meet in every phase, so that
    together they are as bad as the best of them. A gap of at most ``limit_s`` seconds need not be exact.
    """
    best, when, exact = math.inf, math.nan, True
    heads = 0
    for i in range(n):
        kind = loops.classes[times.robots[i]]
        first = True
        for j in range(i):
            if loops.classes[times.robots[j]] == kind:
                first = False
        if not first:
            continue
        members, count = np.empty(n - i, np.int64), 0
        for j in range(i, n):
            if loops.classes[times.robots[j]] == kind:
                members[count] = j
                count += 1
        gap, start, period, sure = _class_gap(times, members[:count], loops.parts, loops.units_s[kind], limit_s)
        heads += 1
        exact = exact and sure
        if gap < best:
            best, when = gap, start + np.ceil((loops.from_s - start) / period) * period
    return best, (when if heads == 1 else math.nan), exact

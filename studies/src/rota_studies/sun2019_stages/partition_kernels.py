# mypy: disable-error-code="no-any-return"
"""Compiled partition of a closed frame: segments and their times in constant time, and dynamic programming over them.

Waypoints 0..n-1 follow each other round the frame; a segment is ``count`` waypoints from ``first`` on, past the end as
well, 1 <= count <= n.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.tolerances import TIE


class Ring(NamedTuple):
    """The frame twice round, so that no segment wraps.

    along_m: (2 n,) metres from waypoint 0. period_s: (levels, 2 n) the smallest period of 2 ** level waypoints from
    each on. level: (n + 1,) the largest level not above log2 of a number. around_m: what the route has besides twice
    the segment, 2 pi r_s. joining: 1 where the leg before a segment's first waypoint is part of it. route_s: (n, n) the
    time round the segment of k + 1 waypoints from each on, or (0, 0): then it is taken for twice the segment's length
    and around_m.
    """

    along_m: Any
    period_s: Any
    level: Any
    speed_m_s: float
    around_m: float
    joining: int
    route_s: Any


class Layers(NamedTuple):
    """Room for the dynamic programming: the best way to cut the first ``at`` waypoints into k segments.

    late: (segments + 1, n + 1) by k and at, seconds that its segments are late together; inf where there is none.
    uneven: (segments + 1, n + 1) the sum of the squares of its times / periods. chosen: (segments + 1, n + 1)
    waypoints of its last segment. least_at: (segments + 1,) by k, the smallest ``at`` from which the segments left can
    still reach the end.
    """

    late: Any
    uneven: Any
    chosen: Any
    least_at: Any


@allocation_free
def segment_period_s(first: int, count: int, ring: Ring) -> float:
    """Eq. 23: the smallest period of the segment's waypoints."""
    level = ring.level[count]
    return min(ring.period_s[level, first], ring.period_s[level, first + count - (1 << level)])


@allocation_free
def segment_time_s(first: int, count: int, ring: Ring) -> float:
    """Eq. 26: seconds of the closed route round the segment, looked up or taken as twice its length and 2 pi r_s."""
    if ring.route_s.shape[0] > 0:
        return ring.route_s[first, count - 1]
    n = ring.level.shape[0] - 1
    long_m = ring.along_m[first + count - 1] - ring.along_m[first]
    if ring.joining:
        before = first - 1 if first > 0 else n - 1
        long_m += ring.along_m[before + 1] - ring.along_m[before]
    return (2.0 * long_m + ring.around_m) / ring.speed_m_s


@allocation_free
def longest_counts(share: float, ring: Ring, longest: Any) -> None:
    """Fill longest (n,) with the most waypoints, 1 or more, of a segment from each waypoint on within its period.

    Times are less than ``share`` of the period, as Eq. 25 asks. A longer segment takes longer and has no longer period,
    so that the ends only move on.
    """
    n = longest.shape[0]
    count = 1
    for first in range(n):
        count = max(1, count - 1)
        while count < n:
            time_s = segment_time_s(first, count + 1, ring)
            if time_s - share * segment_period_s(first, count + 1, ring) >= 0.0:
                break
            count += 1
        longest[first] = count


@allocation_free
def fewest_segments(longest: Any) -> int:
    """The fewest segments that make up the closed frame, none longer than longest (n,) allows.

    From each start the longest segments are the fewest; the best start counts.
    """
    n = longest.shape[0]
    best = n
    for first in range(n):
        at, segments = 0, 0
        while at < n and segments < best:
            at += longest[(first + at) % n]
            segments += 1
        if at >= n and segments < best:
            best = segments
    return best


@allocation_free
def narrowest_place(longest: Any) -> int:
    """The waypoint that the fewest segments reach over; some segment begins at it or at one of those before it."""
    n = longest.shape[0]
    place, fewest = 0, n + 1
    for at in range(n):
        back = starts_before(at, longest)
        if back < fewest:
            place, fewest = at, back
    return place


@allocation_free
def starts_before(at: int, longest: Any) -> int:
    """How many waypoints in a row, from ``at`` backwards, have a longest segment that reaches over ``at``."""
    n = longest.shape[0]
    back = 1
    while back < n and longest[(at - back) % n] > back:
        back += 1
    return back


@allocation_free
def better(late: float, uneven: float, than_late: float, than_uneven: float) -> bool:
    """Whether less is late, or as much and the shares of the periods are more even."""
    return late < than_late - TIE or (late <= than_late + TIE and uneven < than_uneven)


@allocation_free
def best_partition(segments: int, longest: Any, ring: Ring, layers: Layers, first: Any) -> bool:
    """Find the best partition into ``segments`` segments by dynamic programming; False where there is none.

    longest: (n,) the most waypoints of a segment, by its first one. first: (segments,) is filled with the segments'
    first waypoints. Best is the smallest sum of what segments are late, then the smallest sum of the squares of time /
    period. Each waypoint where a segment may begin is tried as the start.
    """
    n = longest.shape[0]
    place = narrowest_place(longest)
    best_late, best_uneven = math.inf, math.inf
    for back in range(starts_before(place, longest)):
        start = (place - back) % n
        lay_out_from(start, segments, longest, ring, layers)
        late, uneven = layers.late[segments, n], layers.uneven[segments, n]
        if better(late, uneven, best_late, best_uneven):
            best_late, best_uneven = late, uneven
            at = n
            for k in range(segments, 0, -1):
                at -= layers.chosen[k, at]
                first[k - 1] = (start + at) % n
    return best_late < math.inf


@allocation_free
def lay_out_from(start: int, segments: int, longest: Any, ring: Ring, layers: Layers) -> None:
    """Fill the layers with the best way to cut the first ``at`` waypoints from ``start`` on, for all at and k."""
    n = longest.shape[0]
    late, uneven, chosen, least_at = layers
    for k in range(segments + 1):
        for at in range(n + 1):
            late[k, at], uneven[k, at] = math.inf, math.inf
    late[0, 0], uneven[0, 0] = 0.0, 0.0
    # where the segments left can still reach the end; from farther on they can, too
    at = n
    for k in range(segments, -1, -1):
        least_at[k] = at
        while at > 0 and at - 1 + longest[(start + at - 1) % n] >= least_at[k]:
            at -= 1
    if least_at[0] > 0:
        return
    highest = 0
    for k in range(segments):
        farthest = n - (segments - k - 1)  # a waypoint each for the segments left
        next_highest = 0
        for at in range(max(k, least_at[k]), highest + 1):
            if late[k, at] == math.inf:
                continue
            first = (start + at) % n
            for count in range(max(1, least_at[k + 1] - at), min(longest[first], farthest - at) + 1):
                time = segment_time_s(first, count, ring)
                period = segment_period_s(first, count, ring)
                sum_late = late[k, at] + max(0.0, time - period)
                sum_uneven = uneven[k, at] + (time / period) ** 2
                to = at + count
                if better(sum_late, sum_uneven, late[k + 1, to], uneven[k + 1, to]):
                    late[k + 1, to], uneven[k + 1, to], chosen[k + 1, to] = sum_late, sum_uneven, count
                next_highest = max(next_highest, to)
        highest = next_highest

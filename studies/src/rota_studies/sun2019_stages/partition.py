"""The frame cut into segments, each with a closed route for one robot (Sun et al. 2019, Section 4.4, Eqs. 20-28).

A robot goes round its segment at the distance r_s. Eq. 26 has the length of that closed route, over the speed. Here it
is estimated: twice the segment and once round its ends, 2 x length + 2 pi r_s, which is the length of the widened
segment's border but for its bends, where the inner side saves a little, and for obstacles and lanes that merge (7 %
more than the routes in all on Figure 13's map).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.tolerances import BISECTIONS, TIE
from rota_studies.sun2019_stages.partition_kernels import (
    Layers,
    Ring,
    best_partition,
    fewest_segments,
    longest_counts,
    segment_period_s,
    segment_time_s,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Partition:
    """Segments of a frame, m of them in its order; together they hold each waypoint once.

    first, last: (m,) places in the frame (0..n-1) of each segment's first and last waypoint; a segment may go on from
    place n - 1 to 0. times_s: (m,) Eq. 26. periods_s: (m,) Eq. 23.
    """

    first: Ints
    last: Ints
    times_s: Floats
    periods_s: Floats

    @property
    def kept(self) -> bool:
        """Whether all routes are shorter than their periods (Eq. 25)."""
        return bool((self.times_s < self.periods_s).all())

    def places(self, segment: int, n: int) -> Ints:
        """The places in a frame of n waypoints that one segment holds, in its order."""
        count = (self.last[segment] - self.first[segment]) % n + 1
        return np.asarray((self.first[segment] + np.arange(count)) % n)


def partition_frame(
    legs_m: Floats,
    waypoint_periods_s: Floats,
    *,
    speed_m_s: float,
    sensor_radius_m: float,
    segments: int | None = None,
) -> Partition:
    """Cut a closed frame into segments whose routes keep their periods, as few as possible (Eqs. 24 and 25).

    legs_m: (n,) metres along the path from each waypoint to the next, from the last to the first; n >= 1.
    waypoint_periods_s: (n,) the period of the sub-region that each waypoint was deployed in; a segment's period is the
    smallest among its waypoints. speed_m_s: V. sensor_radius_m: r_s. segments: how many; None: as few as are needed.

    Of these partitions it takes those whose largest time / period is the smallest, also where the segments asked for
    are too few to keep all periods, and of those the one that is late by the least, then the one with the smallest sum
    of squares. A waypoint whose route round it alone takes too long gets a segment of its own; ``kept`` tells whether
    all periods are kept.

    Raises ValueError when an argument is not finite or not greater than 0 (a leg may be 0), and for more segments than
    waypoints.
    """
    ring = ring_of(legs_m, waypoint_periods_s, speed_m_s, sensor_radius_m)
    n = len(legs_m)
    if segments is not None and not 1 <= segments <= n:
        raise ValueError(f"segments: {segments!r} is not allowed; must be from 1 to the number of waypoints, {n}")
    return segments_of(exact_partition(ring, segments), ring)


def exact_partition(ring: Ring, segments: int | None) -> Ints:
    """The first waypoints (m,) of the best partition's segments; see ``partition_frame``."""
    n = len(ring.level) - 1
    longest = np.empty(n, dtype=np.int64)
    longest_counts(1.0, ring, longest)
    fewest = int(fewest_segments(longest))
    alone = max(segment_time_s(k, 1, ring) / segment_period_s(k, 1, ring) for k in range(n))
    if segments is None or (segments >= fewest and alone < 1):
        return _most_even(ring, segments or fewest, least=min(1.0, float(alone)), most=1.0)
    whole_s = max(segment_time_s(k, n, ring) for k in range(n))
    most = float(whole_s / ring.period_s[0].min()) * (1 + TIE)
    return _most_even(ring, segments, least=float(alone), most=most)


def segments_of(first: Ints, ring: Ring) -> Partition:
    """The partition whose segments have these first waypoints (m,)."""
    first, n = np.sort(first), len(ring.level) - 1
    counts = (np.roll(first, -1) - first - 1) % n + 1
    pairs = list(zip(first.tolist(), counts.tolist(), strict=True))
    return Partition(
        first=first,
        last=(np.roll(first, -1) - 1) % n,
        times_s=np.array([segment_time_s(at, count, ring) for at, count in pairs]),
        periods_s=np.array([segment_period_s(at, count, ring) for at, count in pairs]),
    )


def _most_even(ring: Ring, segments: int, *, least: float, most: float) -> Ints:
    """The first waypoints (m,) of the partition into ``segments`` segments whose largest share of a period is smallest.

    That share is at least ``least``. With shares up to ``most``, so many segments are surely enough; 1 where periods
    can be kept.
    """
    longest = np.empty(len(ring.level) - 1, dtype=np.int64)
    low, high = least, most
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        longest_counts(middle, ring, longest)
        low, high = (low, middle) if fewest_segments(longest) <= segments else (middle, high)
    # shares that differ by rounding are equal
    longest_counts(min(most, high * (1 + TIE)), ring, longest)
    return _best(ring, longest, segments)


def route_length_m(segment_m: float, sensor_radius_m: float) -> float:
    """Length of the closed route round a segment of that length: 2 x segment + 2 pi r_s (Figure 9a)."""
    return 2 * segment_m + 2 * math.pi * sensor_radius_m


def ring_of(legs_m: Floats, waypoint_periods_s: Floats, speed_m_s: float, sensor_radius_m: float) -> Ring:
    """The frame as the kernels hold it; ValueError names what is wrong with an argument of ``partition_frame``."""
    legs, periods = np.asarray(legs_m, dtype=np.float64), np.asarray(waypoint_periods_s, dtype=np.float64)
    if legs.ndim != 1 or not len(legs) or periods.shape != legs.shape:
        raise ValueError(
            f"legs_m, waypoint_periods_s: shapes {legs.shape} and {periods.shape} are not allowed; "
            "must be (n,) both, n at least 1"
        )
    for name, values, least in (("legs_m", legs, 0.0), ("waypoint_periods_s", periods, math.ulp(0.0))):
        for k in np.flatnonzero(~(np.isfinite(values) & (values >= least))):
            allowed = "0 or more" if least == 0 else "greater than 0"
            raise ValueError(f"{name}[{k}]: {values[k]!r} is not allowed; must be a finite number, {allowed}")
    for name, value in (("speed_m_s", speed_m_s), ("sensor_radius_m", sensor_radius_m)):
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name}: {value!r} is not allowed; must be a finite number greater than 0")
    n = len(legs)
    along = np.concatenate([[0.0], np.cumsum(np.tile(legs, 2))[: 2 * n - 1]])
    smallest = [np.tile(periods, 2)]
    while 2 ** len(smallest) <= n:
        reach = 2 ** (len(smallest) - 1)
        ahead = np.append(smallest[-1][reach:], np.full(reach, np.inf))
        smallest.append(np.minimum(smallest[-1], ahead))
    level = np.array([0] + [k.bit_length() - 1 for k in range(1, n + 1)], dtype=np.int64)
    around_m = route_length_m(0.0, sensor_radius_m)
    return Ring(along, np.array(smallest), level, float(speed_m_s), around_m, 0, np.empty((0, 0)))


def _best(ring: Ring, longest: Ints, segments: int) -> Ints:
    """The first waypoints (m,) of the best partition whose segments are no longer than longest (n,) allows."""
    n = len(longest)
    late, uneven = np.empty((2, segments + 1, n + 1))
    chosen = np.zeros((segments + 1, n + 1), dtype=np.int64)
    layers = Layers(late, uneven, chosen, least_at=np.empty(segments + 1, dtype=np.int64))
    first = np.empty(segments, dtype=np.int64)
    best_partition(segments, longest, ring, layers, first)
    return np.sort(first)

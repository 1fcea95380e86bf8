"""The frame cut into segments, each with a closed route for one robot (Sun et al. 2019, Section 4.4, Eqs. 20-28).

A robot goes round its segment at the distance r_s. Eq. 26 has the length of that closed route, over the speed; where
the lengths of all segments' routes are given (``route_lengths.py``), times are those. Without them a time is estimated:
twice the segment and once round its ends, 2 x length + 2 pi r_s, which is the length of the widened segment's border
but for its bends, where the inner side saves a little, and for obstacles and lanes that merge (7 % more than the routes
in all on Figure 13's map).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.methods.sun2019.cheapest_kernels import cheapest_partition
from rota.planners.patrol.methods.sun2019.frame_settings import PartitionSettings, TooFew
from rota.planners.patrol.methods.sun2019.partition_kernels import (
    Layers,
    Ring,
    best_partition,
    fewest_segments,
    longest_counts,
    segment_period_s,
    segment_time_s,
)
from rota.planners.patrol.methods.sun2019.pso import rules_of, swarm_partition
from rota.planners.patrol.methods.sun2019.pso_kernels import cost_of
from rota.planners.patrol.tolerances import BISECTIONS, TIE

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Partition:
    """Segments of a frame, m of them in its order; together they hold each waypoint once.

    first, last: (m,) places in the frame (0..n-1) of each segment's first and last waypoint; a segment may go on from
    place n - 1 to 0. times_s: (m,) Eq. 26. periods_s: (m,) Eq. 23. excess_s: (m,) by how much the time exceeds the
    period, 0 where it does not (the margin is not counted). cost: Eq. 28. history: the lowest cost by iteration of the
    particle swarms, beginning with their random positions; of the exact method only the cost.
    """

    first: Ints
    last: Ints
    times_s: Floats
    periods_s: Floats
    excess_s: Floats
    cost: float
    history: Floats

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
    route_lengths_m: Floats | None = None,
    settings: PartitionSettings | None = None,
    seed: int = 0,
) -> Partition:
    """Cut a closed frame into segments whose routes keep their periods, as few as possible (Eqs. 24 and 25).

    legs_m: (n,) metres along the path from each waypoint to the next, from the last to the first; n >= 1.
    waypoint_periods_s: (n,) the period of the sub-region that each waypoint was deployed in; a segment's period is the
    smallest among its waypoints. speed_m_s: V. sensor_radius_m: r_s. segments: how many; None: as few as are needed.
    route_lengths_m: (n, n) of the closed route round the k + 1 waypoints from each on; None: estimated by their
    lengths. seed: of the particle swarms.

    With route lengths the exact method gives the partition that Eq. 28 costs least; a longer segment may have a shorter
    route, so that the rest of this does not hold. Without route lengths it gives the fewest segments. Of these
    partitions it takes those whose largest (time + margin) / period is the smallest, and of those the one with the
    smallest sum of squares. A waypoint whose route round it alone takes too long gets a segment of its own; ``kept``
    tells whether all periods are kept.

    If the number of segments given cannot keep all periods, the sum by which routes are late (margin counted) is the
    smallest possible, and then the sum of squares. With ``settings.too_few`` "even" the largest share of a period is
    the smallest possible, as above. The swarms' best partition is as good as they find, by Eq. 28.

    Raises ValueError when an argument is not finite or not greater than 0 (a leg may be 0), and for more segments than
    waypoints.
    """
    settings = settings or PartitionSettings()
    ring = ring_of(
        legs_m, waypoint_periods_s, speed_m_s, sensor_radius_m, joining_legs=settings.joining_legs,
        route_lengths_m=route_lengths_m,
    )  # fmt: skip
    n = len(legs_m)
    if segments is not None and not 1 <= segments <= n:
        raise ValueError(f"segments: {segments!r} is not allowed; must be from 1 to the number of waypoints, {n}")
    if settings.method == "pso":
        legs, periods = np.asarray(legs_m, dtype=np.float64), np.asarray(waypoint_periods_s, dtype=np.float64)
        expected = float(((legs + np.roll(legs, 1)) / (speed_m_s * periods)).sum())
        last, history = swarm_partition(
            ring, termination_shares(legs), expected, settings, segments=segments, seed=seed
        )
        return _judge((np.roll(last, 1) + 1) % n, ring, settings, history)
    if route_lengths_m is not None:
        return _judge(_cheapest(ring, settings, segments), ring, settings, None)
    first = exact_partition(ring, settings.margin_s, segments, too_few=settings.too_few)
    return _judge(first, ring, settings, None)


def exact_partition(ring: Ring, margin_s: float, segments: int | None, *, too_few: TooFew = "least_late") -> Ints:
    """The first waypoints (m,) of the best partition's segments; see ``partition_frame``."""
    n = len(ring.level) - 1
    longest = np.empty(n, dtype=np.int64)
    longest_counts(1.0, 0.0, margin_s, ring, longest)
    fewest = int(fewest_segments(longest))
    alone = max((segment_time_s(k, 1, ring) + margin_s) / segment_period_s(k, 1, ring) for k in range(n))
    if segments is None or (segments >= fewest and alone < 1):
        return _most_even(ring, margin_s, segments or fewest, least=min(1.0, float(alone)), most=1.0)
    if too_few == "even":
        whole_s = max(segment_time_s(k, n, ring) for k in range(n)) + margin_s
        most = float(whole_s / ring.period_s[0].min()) * (1 + TIE)
        return _most_even(ring, margin_s, segments, least=float(alone), most=most)
    return _least_late(ring, margin_s, segments)


def _most_even(ring: Ring, margin_s: float, segments: int, *, least: float, most: float) -> Ints:
    """The first waypoints (m,) of the partition into ``segments`` segments whose largest share of a period is smallest.

    That share is at least ``least``. With shares up to ``most``, so many segments are surely enough; 1 where periods
    can be kept.
    """
    longest = np.empty(len(ring.level) - 1, dtype=np.int64)
    low, high = least, most
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        longest_counts(middle, 0.0, margin_s, ring, longest)
        low, high = (low, middle) if fewest_segments(longest) <= segments else (middle, high)
    # shares that differ by rounding are equal
    longest_counts(min(most, high * (1 + TIE)), 0.0, margin_s, ring, longest)
    return _best(ring, margin_s, longest, segments)


def _least_late(ring: Ring, margin_s: float, segments: int) -> Ints:
    """The first waypoints (m,) of the best partition where not all periods can be kept.

    First: how late some segment must be at least. Then: how late all are together if no segment is later than that. No
    single segment of the best partition is later than that sum.
    """
    longest = np.empty(len(ring.level) - 1, dtype=np.int64)
    low_s, high_s = 0.0, max(float(segment_time_s(k, len(longest), ring)) for k in range(len(longest))) + margin_s
    for _ in range(BISECTIONS):
        middle_s = (low_s + high_s) / 2
        longest_counts(1.0, middle_s, margin_s, ring, longest)
        low_s, high_s = (low_s, middle_s) if fewest_segments(longest) <= segments else (middle_s, high_s)
    longest_counts(1.0, high_s, margin_s, ring, longest)
    times_s, periods_s = _times_and_periods(_best(ring, margin_s, longest, segments), ring)
    together_s = float(np.maximum(0.0, times_s + margin_s - periods_s).sum())
    longest_counts(1.0, together_s + TIE, margin_s, ring, longest)
    return _best(ring, margin_s, longest, segments)


def route_length_m(segment_m: float, sensor_radius_m: float) -> float:
    """Length of the closed route round a segment of that length: 2 x segment + 2 pi r_s (Figure 9a)."""
    return 2 * segment_m + 2 * math.pi * sensor_radius_m


def normalised_lengths(legs_m: Floats) -> Floats:
    """Eqs. 20 and 21: each leg (n,) as a share of the whole frame; equal shares where the frame has no length."""
    whole_m = float(legs_m.sum())
    return np.asarray(legs_m / whole_m) if whole_m > 0 else np.full(len(legs_m), 1 / len(legs_m))


def termination_shares(legs_m: Floats) -> Floats:
    """Eq. 22: the share of the frame (n + 1,) at which each sensor lies, and 1 where the first sensor comes again.

    We read the sum up to the leg that leads to sensor K, since r(theta_i) = p(s_K). As printed it has one leg more.
    """
    shares = np.concatenate([[0.0], np.cumsum(normalised_lengths(legs_m))])
    shares[-1] = 1.0
    return shares


def ring_of(
    legs_m: Floats,
    waypoint_periods_s: Floats,
    speed_m_s: float,
    sensor_radius_m: float,
    *,
    joining_legs: bool,
    route_lengths_m: Floats | None = None,
) -> Ring:
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
    routes_m = np.empty((0, 0)) if route_lengths_m is None else np.ascontiguousarray(route_lengths_m, dtype=np.float64)
    if route_lengths_m is not None and not (
        routes_m.shape == (n, n) and (np.isfinite(routes_m) & (routes_m > 0)).all()
    ):
        raise ValueError(
            f"route_lengths_m: shape {routes_m.shape} or a value is not allowed; must be ({n}, {n}) finite numbers "
            "greater than 0"
        )
    along = np.concatenate([[0.0], np.cumsum(np.tile(legs, 2))[: 2 * n - 1]])
    smallest = [np.tile(periods, 2)]
    while 2 ** len(smallest) <= n:
        reach = 2 ** (len(smallest) - 1)
        ahead = np.append(smallest[-1][reach:], np.full(reach, np.inf))
        smallest.append(np.minimum(smallest[-1], ahead))
    level = np.array([0] + [k.bit_length() - 1 for k in range(1, n + 1)], dtype=np.int64)
    around_m = route_length_m(0.0, sensor_radius_m)
    return Ring(along, np.array(smallest), level, float(speed_m_s), around_m, int(joining_legs), routes_m / speed_m_s)


def _best(ring: Ring, margin_s: float, longest: Ints, segments: int) -> Ints:
    """The first waypoints (m,) of the best partition whose segments are no longer than longest (n,) allows."""
    n = len(longest)
    late, uneven = np.empty((2, segments + 1, n + 1))
    chosen = np.zeros((segments + 1, n + 1), dtype=np.int64)
    layers = Layers(late, uneven, chosen, least_at=np.empty(segments + 1, dtype=np.int64))
    first = np.empty(segments, dtype=np.int64)
    best_partition(segments, margin_s, longest, ring, layers, first)
    return np.sort(first)


def _cheapest(ring: Ring, settings: PartitionSettings, segments: int | None) -> Ints:
    """The first waypoints (m,) of the partition that Eq. 28 costs least."""
    n = len(ring.level) - 1
    layers = segments or 0
    price, first = np.empty((n, n)), np.empty(n, dtype=np.int64)
    cost, chosen = np.empty((layers + 1, n + 1)), np.zeros((layers + 1, n + 1), dtype=np.int64)
    count = cheapest_partition(layers, rules_of(settings), ring, price, cost, chosen, first)
    return np.sort(first[:count])


def _times_and_periods(first: Ints, ring: Ring) -> tuple[Floats, Floats]:
    """Times (Eq. 26) and periods (Eq. 23) in seconds, (m,) each, of the segments with these first waypoints (m,)."""
    n = len(ring.level) - 1
    counts = (np.roll(first, -1) - first - 1) % n + 1
    pairs = list(zip(first.tolist(), counts.tolist(), strict=True))
    times_s = np.array([segment_time_s(at, count, ring) for at, count in pairs])
    return times_s, np.array([segment_period_s(at, count, ring) for at, count in pairs])


def _judge(first: Ints, ring: Ring, settings: PartitionSettings, history: Floats | None) -> Partition:
    """The partition with these first waypoints (m,), and what it costs."""
    first = np.sort(first)
    times_s, periods_s = _times_and_periods(first, ring)
    rules = rules_of(settings)
    cost = float(sum(cost_of(late, rules) for late in (times_s - periods_s + settings.margin_s).tolist()))
    n = len(ring.level) - 1
    return Partition(
        first=first,
        last=(np.roll(first, -1) - 1) % n,
        times_s=times_s,
        periods_s=periods_s,
        excess_s=np.maximum(0.0, times_s - periods_s),
        cost=cost,
        history=np.array([cost]) if history is None else history,
    )

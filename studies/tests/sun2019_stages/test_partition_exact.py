"""The exact partition against all partitions of small frames, and on frames whose best one is plain."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, seed, settings, strategies as st

from rota_studies.sun2019_stages.partition import partition_frame

SPEED_M_S, RADIUS_M = 2.0, 1.0


class Rank(NamedTuple):
    """A partition's number of segments, what is late, the largest share of a period, and the sum of squares."""

    segments: int
    late_s: float
    largest: float
    uneven: float


def rank_of(first: tuple[int, ...], legs: list[float], periods: list[float]) -> tuple[Rank, bool]:
    """The partition whose segments begin there, and whether it is late only where a waypoint is alone."""
    n = len(legs)
    shares, late_s, only_alone = [], [], True
    for k, at in enumerate(first):
        count = (first[(k + 1) % len(first)] - at - 1) % n + 1
        long_m = sum(legs[(at + i) % n] for i in range(count - 1))
        time_s = (2 * long_m + 2 * math.pi * RADIUS_M) / SPEED_M_S
        period_s = min(periods[(at + i) % n] for i in range(count))
        only_alone &= count == 1 or time_s < period_s
        shares.append(time_s / period_s)
        late_s.append(max(0.0, time_s - period_s))
    return Rank(len(first), sum(late_s), max(shares), sum(share**2 for share in shares)), only_alone


def best_of_all(legs: list[float], periods: list[float], segments: int | None) -> Rank:
    """The best of all partitions, what differs by rounding being equal."""
    n = len(legs)
    ranked = [
        rank_of(first, legs, periods)
        for count in (range(1, n + 1) if segments is None else (segments,))
        for first in itertools.combinations(range(n), count)
    ]
    if segments is None:
        ranks = [rank for rank, only_alone in ranked if only_alone]
        fewest = min(rank.segments for rank in ranks)
        ranks = [rank for rank in ranks if rank.segments == fewest]
    else:
        ranks = [rank for rank, _ in ranked]
    smallest = min(rank.largest for rank in ranks)
    ranks = [rank for rank in ranks if rank.largest <= smallest + 1e-8]
    least_s = min(rank.late_s for rank in ranks)
    return min((rank for rank in ranks if rank.late_s <= least_s + 1e-8), key=lambda rank: rank.uneven)


@seed(1)
@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_against_all_partitions(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 8))
    legs = [eighths / 8 for eighths in data.draw(st.lists(st.integers(0, 80), min_size=n, max_size=n))]
    # some smaller than the time round a waypoint alone, 3.14 s
    periods = data.draw(st.lists(st.sampled_from([2.5, 5.0, 9.0, 20.0, 60.0]), min_size=n, max_size=n))
    segments = data.draw(st.none() | st.integers(1, n))
    found = partition_frame(
        np.array(legs), np.array(periods), speed_m_s=SPEED_M_S, sensor_radius_m=RADIUS_M, segments=segments,
    )  # fmt: skip
    ranked, _ = rank_of(tuple(found.first.tolist()), legs, periods)
    best = best_of_all(legs, periods, segments)
    assert ranked.segments == best.segments
    assert ranked.late_s == pytest.approx(best.late_s, abs=1e-7)
    assert ranked.uneven == pytest.approx(best.uneven, rel=1e-7)
    assert ranked.largest == pytest.approx(best.largest, rel=1e-7)
    shares = found.times_s / found.periods_s
    assert [shares.max(), (shares**2).sum()] == pytest.approx([ranked.largest, ranked.uneven])
    assert sorted(np.concatenate([found.places(k, n) for k in range(len(found.first))]).tolist()) == list(range(n))
    assert found.last.tolist() == [int(found.places(k, n)[-1]) for k in range(len(found.first))]
    assert found.kept == bool((found.times_s < found.periods_s).all())


def test_equal_waypoints_are_shared_out_evenly() -> None:
    # 12 waypoints 10 m apart, 10 m/s, r_s = 5 m: k waypoints take 2 (k - 1) + 3.14 s, so that six fit into 14 s
    for period_s, counts in ((14.0, [6, 6]), (13.0, [4, 4, 4]), (8.0, [3, 3, 3, 3]), (3.2, [1] * 12)):
        found = partition_frame(np.full(12, 10.0), np.full(12, period_s), speed_m_s=10, sensor_radius_m=5)
        assert [len(found.places(k, 12)) for k in range(len(found.first))] == counts
        assert found.times_s == pytest.approx([2 * (counts[0] - 1) + math.pi] * len(counts))
        assert found.kept


def test_one_robot_leaves_out_the_longest_leg() -> None:
    found = partition_frame(np.array([3.0, 9, 4, 5]), np.full(4, 60.0), speed_m_s=1, sensor_radius_m=1)
    assert (found.first.tolist(), found.last.tolist()) == ([2], [1])
    assert found.times_s == pytest.approx([2 * 12 + 2 * math.pi])


def test_a_segment_keeps_to_a_sub_region_with_a_short_period() -> None:
    # three waypoints every 10 s, nine every 60 s: 20 m and the circle take 7.1 s, 90 m and the circle 21.1 s
    periods = np.array([10.0] * 3 + [60] * 9)
    found = partition_frame(np.full(12, 10.0), periods, speed_m_s=10, sensor_radius_m=5)
    assert (found.first.tolist(), found.last.tolist()) == ([0, 3], [2, 11])
    assert found.periods_s.tolist() == [10, 60]


def test_a_period_that_is_just_met_is_not_kept() -> None:
    # Eq. 25 asks for less; one waypoint alone: pi seconds
    found = partition_frame(np.zeros(1), np.array([math.pi]), speed_m_s=2, sensor_radius_m=1)
    assert found.times_s.tolist() == [math.pi]
    assert not found.kept
    two = partition_frame(np.zeros(2), np.array([math.pi, 4]), speed_m_s=2, sensor_radius_m=1)
    assert len(two.first) == 2


def test_too_few_robots_are_late_alike() -> None:
    # Table 6's case 6 is of this kind: 11 robots, four of them late
    legs, periods = np.full(10, 10.0), np.full(10, 9.0)
    needed = partition_frame(legs, periods, speed_m_s=10, sensor_radius_m=5)
    assert len(needed.first) == 4
    found = partition_frame(legs, periods, speed_m_s=10, sensor_radius_m=5, segments=3)
    # 7 legs of 2 s in three routes, 3.14 s more each: two with two legs are in time, one with three is 0.14 s late
    assert sorted((found.times_s - found.periods_s).round(4).tolist())[-1] == round(6 + math.pi - 9, 4)
    assert not found.kept
    more = partition_frame(legs, periods, speed_m_s=10, sensor_radius_m=5, segments=7)
    assert len(more.first) == 7
    assert more.kept


def test_a_long_frame_needs_no_more_than_its_best_start_gives() -> None:
    # any partition is as long as the greedy one from some start; here tried from all of them
    rng = np.random.default_rng(8)
    legs, periods = rng.uniform(5, 15, 400), np.repeat([10.0, 40.0, 20.0, 40.0], 100)
    found = partition_frame(legs, periods, speed_m_s=10, sensor_radius_m=5)
    fewest = 400
    for start in range(400):
        count, at = 0, 0
        while at < 400:
            period_s, time_s, inside = periods[(start + at) % 400], math.pi, 1
            while at + inside < 400:
                period_s = min(period_s, periods[(start + at + inside) % 400])
                time_s += 2 * legs[(start + at + inside - 1) % 400] / 10
                if time_s >= period_s:
                    break
                inside += 1
            at, count = at + inside, count + 1
        fewest = min(fewest, count)
    assert len(found.first) == fewest
    assert found.kept

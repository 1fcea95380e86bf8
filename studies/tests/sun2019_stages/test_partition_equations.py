"""Eqs. 23-26 against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota_studies.sun2019_stages.partition import partition_frame, ring_of, route_length_m
from rota_studies.sun2019_stages.partition_kernels import segment_period_s, segment_time_s

LEGS_M = np.array([1.0, 2, 3, 4])


def test_equation_23_the_smallest_period_of_a_segment_s_waypoints() -> None:
    periods = [40.0, 8, 20, 40, 40]
    ring = ring_of(np.ones(5), np.array(periods), 20, 5)
    for first in range(5):
        for count in range(1, 6):
            expected = min(periods[(first + k) % 5] for k in range(count))
            assert segment_period_s(first, count, ring) == expected


def test_equation_26_twice_the_segment_and_once_round_its_ends() -> None:
    assert route_length_m(100, 5) == pytest.approx(231.4159, abs=1e-4)
    ring = ring_of(LEGS_M, np.full(4, 40.0), 20, 5)
    around = 2 * math.pi * 5
    # waypoints 1, 2, 3 are 2 + 3 m apart; 3, 0, 1 are 4 + 1 m apart; one alone has its circle
    assert segment_time_s(1, 3, ring) == pytest.approx((2 * 5 + around) / 20)
    assert segment_time_s(3, 3, ring) == pytest.approx((2 * 5 + around) / 20)
    assert segment_time_s(2, 1, ring) == pytest.approx(around / 20)
    assert segment_time_s(2, 4, ring) == pytest.approx((2 * 8 + around) / 20)
    joined = ring._replace(joining=1)
    # with the leg before: 1, 4 and 2 m more
    assert segment_time_s(1, 3, joined) == pytest.approx((2 * 6 + around) / 20)
    assert segment_time_s(0, 1, joined) == pytest.approx((2 * 4 + around) / 20)
    assert segment_time_s(2, 4, joined) == pytest.approx((2 * 10 + around) / 20)


def test_figure_9b_eighteen_sensors_in_four_segments() -> None:
    # s_2 to s_5, s_6 to s_9, s_10 to s_14, and s_15 to s_18 with s_1; places in the frame count from 0
    legs = np.full(18, 5.0)
    legs[[0, 4, 8, 13]] = 30  # behind s_1, s_5, s_9 and s_14: 60 m and a circle of 31.4 m take longer than 8 s
    found = partition_frame(legs, np.full(18, 8.0), speed_m_s=10, sensor_radius_m=5)
    assert (found.first.tolist(), found.last.tolist()) == ([1, 5, 9, 14], [4, 8, 13, 0])
    assert [found.places(k, 18).tolist() for k in (0, 3)] == [[1, 2, 3, 4], [14, 15, 16, 17, 0]]
    assert found.times_s == pytest.approx((2 * np.array([15, 15, 20, 20]) + 10 * math.pi) / 10)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"legs_m": np.array([1.0, -1])}, r"legs_m\[1\]: .*-1.0.* is not allowed; must be a finite number, 0 or more"),
        ({"legs_m": np.ones(3)}, r"shapes \(3,\) and \(2,\)"),
        ({"waypoint_periods_s": np.array([0.0, 1])}, r"waypoint_periods_s\[0\]"),
        ({"speed_m_s": 0}, "speed_m_s: 0"),
        ({"sensor_radius_m": math.nan}, "sensor_radius_m: nan"),
        ({"segments": 3}, "segments: 3 is not allowed; must be from 1 to the number of waypoints, 2"),
    ],
)
def test_what_cannot_be_used_is_refused(wrong: dict[str, object], message: str) -> None:
    right = {
        "legs_m": np.ones(2), "waypoint_periods_s": np.ones(2), "speed_m_s": 1.0, "sensor_radius_m": 1.0
    }  # fmt: skip
    with pytest.raises(ValueError, match=message):
        partition_frame(**(right | wrong))

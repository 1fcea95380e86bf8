"""Eqs. 20-28 against numbers worked out by hand, and against the costs that the paper prints for its own times."""

from __future__ import annotations

import math

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_4

from rota.errors import MissionError
from rota.planners.patrol.methods.sun2019.frame_settings import PartitionSettings
from rota.planners.patrol.methods.sun2019.partition import (
    normalised_lengths,
    partition_frame,
    ring_of,
    route_length_m,
    termination_shares,
)
from rota.planners.patrol.methods.sun2019.partition_kernels import segment_period_s, segment_time_s
from rota.planners.patrol.methods.sun2019.pso import rules_of
from rota.planners.patrol.methods.sun2019.pso_kernels import (
    Cuts,
    cost_of,
    end_sensors,
    inertia_at,
    nearest_sensor,
    next_velocity,
)

LEGS_M = np.array([1.0, 2, 3, 4])


def test_equations_20_to_22_lengths_as_shares_of_the_frame() -> None:
    assert normalised_lengths(LEGS_M).tolist() == [0.1, 0.2, 0.3, 0.4]
    assert termination_shares(LEGS_M) == pytest.approx([0, 0.1, 0.3, 0.6, 1])
    assert normalised_lengths(np.zeros(4)).tolist() == [0.25] * 4


def test_equation_23_the_smallest_period_of_a_segment_s_waypoints() -> None:
    periods = [40.0, 8, 20, 40, 40]
    ring = ring_of(np.ones(5), np.array(periods), 20, 5, joining_legs=False)
    for first in range(5):
        for count in range(1, 6):
            expected = min(periods[(first + k) % 5] for k in range(count))
            assert segment_period_s(first, count, ring) == expected


def test_equation_26_twice_the_segment_and_once_round_its_ends() -> None:
    assert route_length_m(100, 5) == pytest.approx(231.4159, abs=1e-4)
    ring = ring_of(LEGS_M, np.full(4, 40.0), 20, 5, joining_legs=False)
    around = 2 * math.pi * 5
    # waypoints 1, 2, 3 are 2 + 3 m apart; 3, 0, 1 are 4 + 1 m apart; one alone has its circle
    assert segment_time_s(1, 3, ring) == pytest.approx((2 * 5 + around) / 20)
    assert segment_time_s(3, 3, ring) == pytest.approx((2 * 5 + around) / 20)
    assert segment_time_s(2, 1, ring) == pytest.approx(around / 20)
    assert segment_time_s(2, 4, ring) == pytest.approx((2 * 8 + around) / 20)
    joined = ring_of(LEGS_M, np.full(4, 40.0), 20, 5, joining_legs=True)
    # with the leg before: 1, 4 and 2 m more
    assert segment_time_s(1, 3, joined) == pytest.approx((2 * 6 + around) / 20)
    assert segment_time_s(0, 1, joined) == pytest.approx((2 * 4 + around) / 20)
    assert segment_time_s(2, 4, joined) == pytest.approx((2 * 10 + around) / 20)


def test_equation_27_the_update_of_a_velocity() -> None:
    rules = rules_of(TABLE_4)
    # 0.9 * 0.05 + 2 * 0.5 * 0.2 - 2 * 0.5 * 0.2 = 0.045
    assert next_velocity(0.3, 0.05, 0.5, 0.1, 0.9, 0.5, 0.5, rules) == pytest.approx(0.045)
    # 0.4 * -0.02 + 2 * 0.1 * 0.1 + 2 * 0.2 * 0.2 = 0.092
    assert next_velocity(0.3, -0.02, 0.4, 0.5, 0.4, 0.1, 0.2, rules) == pytest.approx(0.092)
    # 0.045 + 0.2 is too fast, and so is the same backwards
    assert next_velocity(0.3, 0.05, 0.5, 0.3, 0.9, 0.5, 0.5, rules) == 0.1
    assert next_velocity(0.5, -0.05, 0.3, 0.5, 0.9, 0.5, 0.5, rules) == -0.1
    assert [inertia_at(k, rules) for k in (0, 49)] == pytest.approx([0.9, 0.4])
    assert inertia_at(7, rules) == pytest.approx(0.9 - 0.5 / 7)


def test_equation_28_by_hand() -> None:
    rules = rules_of(PartitionSettings(margin_s=0.5, weight_late=7, weight_segments=100, weight_early=3))
    # T_a = 7, T_c = 8, T_m = 0.5: early by 0.5 s; T_a = 9: late by 1.5 s; T_a = 7.5: neither
    assert cost_of(7 - 8 + 0.5, rules) == 100 + 3 * 0.5
    assert cost_of(9 - 8 + 0.5, rules) == 100 + 7 * 1.5
    assert cost_of(7.5 - 8 + 0.5, rules) == 100


def test_the_weights_give_the_cost_that_the_paper_prints() -> None:
    rules = rules_of(TABLE_4)

    def cost(*routes: tuple[float, float]) -> float:
        return sum(cost_of(taken_s - period_s + rules.margin_s, rules) for period_s, taken_s in routes)

    table_5 = cost((40, 36.37), (20, 18.81), (40, 37.29), (8, 6.75), (8, 7.19))
    assert table_5 == pytest.approx(5709.23, abs=5 * 100 * 0.005)  # as far as rounding the five times allows
    table_8 = cost((45, 44.12), (45, 37.65), (12, 10.12), (45, 39.17), (10, 7.86), (10, 8.00), (45, 39.14))
    assert table_8 + 100 == pytest.approx(9343.48, abs=7 * 100 * 0.005)  # one time a second less than printed


def test_table_4() -> None:
    assert (TABLE_4.iterations, TABLE_4.swarms, TABLE_4.particles) == (50, 500, 1000)
    assert (TABLE_4.velocity_min, TABLE_4.velocity_max) == (-0.1, 0.1)
    assert (TABLE_4.inertia_min, TABLE_4.inertia_max) == (0.4, 0.9)
    assert (TABLE_4.c1, TABLE_4.c2) == (2, 2)


def test_ends_are_the_nearest_sensors_in_the_order_of_the_frame() -> None:
    share = termination_shares(LEGS_M)  # 0, 0.1, 0.3, 0.6, 1
    for bins in (1, 3, 16, 50):
        nearby = np.searchsorted(share, np.arange(bins) / bins, side="right") - 1
        cuts = Cuts(share, np.clip(nearby, 0, 3).astype(np.int64))
        for theta in np.linspace(0, 1, 97):
            nearest = nearest_sensor(theta, cuts)
            assert abs(share[nearest] - theta) == np.abs(share - theta).min()
        ends = np.empty(6, dtype=np.int64)
        # 0.58 and 0.61 are the same sensor, 0.02 and 0.97 are where the frame begins
        count = end_sensors(np.array([0.61, 0.02, 0.31, 0.97, 0.58]), 5, cuts, ends)
        assert ends[:count].tolist() == [2, 3, 4]


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


def test_settings_that_cannot_be_are_refused() -> None:
    for wrong in ({"method": "greedy"}, {"margin_s": -1}, {"swarms": 0}, {"velocity_min": 0.2}):
        with pytest.raises(MissionError, match=next(iter(wrong))):
            PartitionSettings(**wrong)

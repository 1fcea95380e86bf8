"""Eqs. 20-28 against numbers worked out by hand, and against the costs that the paper prints for its own times."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_4

from rota.errors import MissionError
from rota_studies.sun2019_method.partition import PartitionSettings, normalised_lengths, termination_shares
from rota_studies.sun2019_method.pso import rules_of
from rota_studies.sun2019_method.pso_kernels import (
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


def test_settings_that_cannot_be_are_refused() -> None:
    for wrong in ({"method": "greedy"}, {"margin_s": -1}, {"swarms": 0}, {"velocity_min": 0.2}):
        with pytest.raises(MissionError, match=next(iter(wrong))):
            PartitionSettings(**wrong)

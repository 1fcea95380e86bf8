"""Algorithm 3: the swarms' partitions beside the exact optimum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_4

from rota_studies.sun2019_method.partition import CostedPartition, PartitionSettings, cut_frame

SMALL = replace(TABLE_4, swarms=40, particles=100)
LEGS_M = np.random.default_rng(3).uniform(8, 14, 60)
PERIODS_S = np.repeat([8.0, 40.0, 20.0, 40.0], [10, 25, 10, 15])


def cut(settings: PartitionSettings, *, seed: int = 0, segments: int | None = None) -> CostedPartition:
    return cut_frame(
        np.roll(LEGS_M, 1), np.roll(PERIODS_S, 1), speed_m_s=20, sensor_radius_m=5, settings=settings, seed=seed,
        segments=segments,
    )  # fmt: skip


def test_the_swarms_need_as_many_robots_as_the_optimum() -> None:
    exact = cut(replace(SMALL, method="exact"))
    assert exact.kept
    for seed in range(3):
        found = cut(SMALL, seed=seed)
        assert len(found.first) == len(exact.first)
        assert found.kept
        # the first segment begins behind the sensor where the frame begins
        assert found.last[-1] == 0


def test_all_positions_are_tried_by_a_swarm_that_can_see_them_all() -> None:
    # two ends among five sensors: the best of all ten pairs, and of fewer ends, by Eq. 28
    legs, periods = np.array([10.0, 30, 10, 10, 40, 10]), np.array([20.0, 9, 9, 20, 20, 20])
    settings = replace(SMALL, swarms=4)
    found = cut_frame(legs, periods, speed_m_s=10, sensor_radius_m=5, settings=settings, segments=3, seed=0)
    costs = []
    for ends in [(a, b) for a in range(1, 7) for b in range(a, 7)]:
        total, before = 0.0, 0
        for end in sorted({*ends, 6}):
            time_s = (2 * legs[before:end].sum() + 2 * np.pi * 5) / 10
            late_s = time_s + 0.5 - min(periods[k % 6] for k in range(before + 1, end + 1))
            total += 440 * max(0, late_s) + 1_000 + 100 * max(0, -late_s)
            before = end
        costs.append(total)
    assert found.cost == pytest.approx(min(costs))
    assert found.history[-1] == pytest.approx(min(costs))


def test_the_history_is_that_of_the_best_and_only_falls() -> None:
    found = cut(replace(SMALL, swarms=7, particles=20))
    assert found.history.shape == (51,)
    assert (np.diff(found.history) <= 0).all()
    assert found.history[0] > found.history[-1]
    assert found.history[-1] == pytest.approx(found.cost)


def test_the_seed_decides() -> None:
    tiny = replace(SMALL, swarms=6, particles=10, iterations=5)
    one, again, other = (cut(tiny, seed=seed) for seed in (1, 1, 2))
    assert one.first.tolist() == again.first.tolist()
    assert one.history.tolist() == again.history.tolist()
    assert one.history.tolist() != other.history.tolist()


def test_swarms_do_not_depend_on_each_other() -> None:
    # the random numbers of a swarm do not depend on how many swarms there are
    few, many = (cut(replace(SMALL, swarms=swarms, particles=10)) for swarms in (10, 20))
    assert (many.history <= few.history).all()


@pytest.mark.parametrize("n", [1, 2])
def test_hardly_any_waypoints(n: int) -> None:
    found = cut_frame(
        np.full(n, 5.0), np.full(n, 30.0), speed_m_s=10, sensor_radius_m=5, settings=replace(SMALL, swarms=5)
    )
    assert found.first.tolist() == [1 % n]
    assert found.times_s == pytest.approx([(2 * 5 * n + 2 * np.pi * 5) / 10])


def test_a_given_number_of_robots_is_not_exceeded() -> None:
    found = cut(SMALL, segments=3)
    assert len(found.first) <= 3
    assert found.excess_s.sum() > 0
    assert not found.kept

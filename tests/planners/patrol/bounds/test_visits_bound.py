"""The bound from the time that visits take, and from what one robot cannot do for ever."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.cyclic_visits import random_places
from tests.planners.patrol.cycles.test_one_robot import STAR, some_places
from tests.planners.patrol.cycles.test_teams import fewest_of_all_ways
from tests.seeds import seeds

from rota import make_plan
from rota.planners.patrol.bounds.visits_bound import times_near, visits_bound


def robots(leg_s: np.ndarray, period_s: np.ndarray, least: int = 1) -> int:
    return max(proof.robots for proof in visits_bound(leg_s * 2.0, period_s, 2.0, least))


def test_two_places_share_the_time_between_them() -> None:
    leg_s, period_s = np.array([[0.0, 10], [10, 0]]), np.array([12.0, 30])
    near_s = times_near(leg_s, period_s)
    # the nearer deadline weighs most: half of its period, and what is left of the way
    assert near_s == pytest.approx([6, 4])
    assert robots(leg_s, period_s) == 2  # 12 / 12 + 8 / 30
    assert robots(leg_s, 2 * period_s) == 1


def test_a_hub_with_ends_takes_a_second_robot_when_it_is_due_sooner() -> None:
    assert robots(STAR, np.array([20.5, 61.5, 61.5, 61.5])) == 1
    assert robots(STAR, np.array([19.5, 61.5, 61.5, 61.5])) == 2


def test_what_is_known_is_not_asked_again() -> None:
    leg_s, period_s = some_places(7, 6)
    assert [proof.robots for proof in visits_bound(leg_s, period_s, 1.0, 2)] == [1]
    assert list(visits_bound(np.zeros((1, 1)), np.array([5.0]), 1.0, 1)) == []


def test_places_that_are_one_or_in_two_parts_are_no_trouble() -> None:
    assert robots(np.zeros((3, 3)), np.array([5.0, 5, 9])) == 1
    apart = np.where(np.eye(2, dtype=bool), 0.0, np.inf)
    assert robots(apart, np.array([5.0, 9])) == 2


def test_no_bound_is_above_the_best_of_all_ways_to_share_the_places() -> None:
    proved = 0
    for seed in range(6):
        leg_s, period_s = some_places(seed, 5)
        period_s = period_s / (1 + seed % 3)
        fewest = fewest_of_all_ways(leg_s, period_s)
        assert robots(leg_s, period_s) <= fewest
        proved += robots(leg_s, period_s) == fewest
    assert proved >= 3


@pytest.mark.parametrize("seed", seeds(6, at_once=2))
def test_plans_take_no_fewer_robots_and_seldom_many_more(seed: int) -> None:
    plan = make_plan(random_places(seed, ("deadlines", "latencies")[seed % 2]), seed=0)
    assert plan.lower_bound_robots is not None
    assert plan.lower_bound_robots <= len(plan) <= plan.lower_bound_robots + 2

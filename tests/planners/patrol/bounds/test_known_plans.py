"""The proved bound is never above the robots of a plan that is known to meet the mission."""

from __future__ import annotations

import pytest
from benchmarks.known_plans import bound_of, known_plan, known_turning_plan

from rota.check import check_plan

SEEDS = pytest.mark.parametrize("seeds", [range(15), pytest.param(range(30), marks=pytest.mark.slow)], ids=str)


@SEEDS
def test_no_bound_is_above_a_plan_that_meets_the_mission(seeds: range) -> None:
    met, highest = 0, 0
    for seed in seeds:
        plan = known_plan(seed)
        robots, bound = len(plan.trajectories), bound_of(plan)
        assert 1 <= bound <= robots, seed
        met += bound == robots
        highest = max(highest, bound)
    # bounds of 1 for everything would pass, too
    assert highest >= 3
    assert met >= 2


@SEEDS
def test_no_bound_is_above_a_plan_of_robots_that_stop_to_turn(seeds: range) -> None:
    plans = [plan for seed in seeds if (plan := known_turning_plan(seed)) is not None]
    assert len(plans) >= 10
    assert all(1 <= bound_of(plan) <= len(plan.trajectories) for plan in plans)


def test_the_check_passes_the_known_plans() -> None:
    for seed in range(5):
        plan = known_plan(seed)
        assert check_plan(plan).verdict == "met"
        assert plan == known_plan(seed)

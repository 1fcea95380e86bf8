"""Where the period leaves no time to move, robots stand: nearly as few as discs that cover the ground."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from shapely import MultiPolygon, box

import rota
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.annealing.search import budget_penalties
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.standing import robots_stand, standing_tours
from rota.planners.patrol.planner_settings import PatrolSettings

SQUARE = Mission(
    name="square", area=MultiPolygon([box(0, 0, 10, 10)]), period_s=0.01,
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2.3)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


def test_standing_robots_cover_a_square_with_few_more_than_the_best_known_discs() -> None:
    # the best known covering of the unit square by 15 equal discs has radius 0.1803 (Nurmela and Ostergard 2000),
    # by 13 0.1944, by 12 0.2023, by 9 0.2306
    problem = set_up_problem(SQUARE)
    tours = standing_tours(problem, problem.points.region == 0, 0)
    assert 9 <= len(tours) <= 11
    assert prove_bound(problem).robots >= math.ceil(100 / (math.pi * 2.3**2) * 0.9)


def test_who_hardly_moves_stands() -> None:
    problem = set_up_problem(SQUARE)
    assert robots_stand(problem, 2.3)
    assert not robots_stand(problem, 2.4)


def test_a_metre_over_the_budget_costs_more_the_less_there_is() -> None:
    problem = set_up_problem(SQUARE)
    tour = standing_tours(problem, problem.points.region == 0, 0)[0]
    still, slow, free = (replace(tour, period_s=t) for t in (0.01, 1.0, 100.0))
    assert budget_penalties([still, slow, free], 4.0) == pytest.approx([920, 9.2, 4], rel=1e-3)


@pytest.mark.parametrize("period_s", [0.01, 1.5])
def test_a_plan_of_standing_robots_passes(period_s: float) -> None:
    shape = MultiPolygon([box(4, 4, 6, 8)])
    mission = replace(SQUARE, obstacles=(Obstacle(shape=shape),), period_s=period_s)
    plan = rota.make_plan(mission, seed=1)
    assert rota.check_plan(plan).verdict == "met"
    assert len(plan.trajectories) <= 2 * plan.lower_bound_robots + 1

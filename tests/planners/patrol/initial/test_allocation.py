"""What a team is taken to be able to see, and which tours it is begun with."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, MultiPolygon, Point, box
from tests.planners.patrol.searching import YARD

from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import allocations, as_lanes_m, period_groupings, slack_factor
from rota.planners.patrol.tours.tour import Tour

REACH_M = 2.0


def tour_with_budget(budget_m: float) -> Tour:
    """The tour of a robot of YARD that can drive so far in its period."""
    robot = YARD.fleet.equal_robot("one")
    seconds = budget_m / robot.speed_m_s / (1 - 1e-6)
    return Tour(vertices_m=np.zeros((1, 2)), period_class=0, period_s=seconds, robots=1, robot=robot)


@pytest.mark.parametrize("budget_m", [0.0, 1.0, 5.0, 4 * math.pi])
def test_a_short_tour_sees_as_much_ground_as_lanes_of_what_it_is_worth(budget_m: float) -> None:
    radius_m = budget_m / (2 * math.pi)
    seen_m2 = math.pi * (radius_m + REACH_M) ** 2  # round a circle of no more than the reach, nothing inside is missed
    assert as_lanes_m(tour_with_budget(budget_m)) * 2 * REACH_M == pytest.approx(seen_m2)


@pytest.mark.parametrize("budget_m", [0.5, 3.0, 8.0])
def test_going_to_and_fro_sees_no_more_than_a_short_tour_is_worth(budget_m: float) -> None:
    there = LineString([(0, 0), (budget_m / 2, 0)])
    assert as_lanes_m(tour_with_budget(budget_m)) * 2 * REACH_M >= there.buffer(REACH_M, quad_segs=64).area


@pytest.mark.parametrize("budget_m", [4 * math.pi, 20.0, 400.0])
def test_a_long_tour_is_worth_its_length(budget_m: float) -> None:
    assert as_lanes_m(tour_with_budget(budget_m)) == pytest.approx(budget_m)


def test_robots_that_hardly_move_are_tried_on_tours_of_their_own_where_lanes_would_be_too_short() -> None:
    ground = MultiPolygon([Point(x, 0).buffer(4.6) for x in (0, 40)])
    corridor = MultiPolygon([box(0, -1, 40, 1)])
    mission = Mission(
        name="two rooms", area=MultiPolygon([ground.union(corridor)]), period_s=6,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5)), planning=YARD.planning,
    )  # fmt: skip
    problem = set_up_problem(mission)
    settings = EFFORTS["quick"].allocation
    groupings = period_groupings(problem, 1)
    handed = groupings[0].with_robots([4])
    lanes_only = slack_factor(handed, worth_m=lambda tour: tour.budget_m)
    between = (lanes_only + slack_factor(handed, [replace(handed.tours[0], robots=1)] * 4)) / 2
    found = allocations(problem, groupings, 4, replace(settings, nested_slack_limit=0.0), least_slack=between)
    assert lanes_only < between
    assert [[tour.robots for tour in allocation.tours] for allocation in found] == [[1, 1, 1, 1]]

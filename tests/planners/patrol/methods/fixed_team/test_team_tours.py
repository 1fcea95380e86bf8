"""Spare robots that help and tours that are joined, in closed form; a robot for each component of the ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, MultiPolygon, Point, box

import rota
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.methods.fixed_team.team_tours import join_for_team, joined_tour, with_a_helper
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.tour import Tour, tour_length_m


@pytest.fixture(scope="module")
def problem() -> Problem:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=5))
    return set_up_problem(Mission(name="yard", area=MultiPolygon([box(0, 0, 30, 30)]), period_s=25, fleet=fleet))


def rings(problem: Problem, *corners_m: tuple[float, float, float]) -> list[Tour]:
    """Square tours, each given by its lower left corner and its side."""
    return [
        Tour(
            vertices_m=np.array([[x, y], [x + a, y], [x + a, y + a], [x, y + a]]), robots=1, robot=problem.robot,
            period_class=0, period_s=25.0, component=0,
        )
        for x, y, a in corners_m
    ]  # fmt: skip


def test_a_spare_robot_helps_where_the_budget_is_fullest(problem: Problem) -> None:
    tours = rings(problem, (0, 0, 5), (10, 0, 15), (0, 20, 8))
    for expected in ([1, 2, 1], [1, 2, 2], [1, 3, 2]):  # 20, 60 and 32 m
        tours = with_a_helper(tours)
        assert [one.robots for one in tours] == expected


def test_joined_tours_go_round_both_and_change_over_where_they_are_near(problem: Problem) -> None:
    a, b = rings(problem, (2, 2, 8), (14, 2, 10))
    b = replace(b, period_class=1, period_s=60.0)
    both = joined_tour(problem, a, b)
    # 4 m between (10, 2) and (14, 2), there and back
    assert tour_length_m(both) == pytest.approx(32 + 40 + 2 * 4)
    assert (both.period_class, both.period_s, both.robots) == (0, 25.0, 1)
    walked = LineString(np.vstack([both.vertices_m, both.vertices_m[:1]]))
    for one in (a, b):
        assert walked.buffer(1e-9).covers(LineString(np.vstack([one.vertices_m, one.vertices_m[:1]])))


def test_fewer_robots_than_tours_share_joined_tours(problem: Problem) -> None:
    tours = rings(problem, (0, 0, 4), (6, 0, 4), (20, 20, 10))
    two = join_for_team(problem, tours, 2)
    assert [one.robots for one in two] == [1, 1]
    # the two short ones are joined: 16 + 16 m and 2 m there and back
    assert sorted(tour_length_m(one) for one in two) == pytest.approx([36, 40])
    (alone,) = join_for_team(problem, tours, 1)
    assert alone.robots == 1
    assert tour_length_m(alone) > 76
    assert [one.robots for one in join_for_team(problem, tours, 4)] == [1, 1, 2]


def test_each_part_of_the_ground_gets_a_robot_of_its_own() -> None:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=5))
    parts = MultiPolygon([box(0, 0, 6, 6), box(20, 0, 26, 6), box(40, 0, 46, 6)])
    settings = PatrolSettings(effort="quick")
    plan = rota.make_plan(Mission(name="islands", area=parts, period_s=100, fleet=fleet, planning=settings))
    homes = [[part.covers(Point(one.positions_m[0])) for part in parts.geoms].index(True) for one in plan]
    assert sorted(homes) == [0, 1, 2]

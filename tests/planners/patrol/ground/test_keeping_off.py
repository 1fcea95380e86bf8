"""Room kept for a robot that stays in a part of the space of its own."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground.keeping_off import keeping_off
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.clear_of_stays import clear_of_who_stays
from rota.planners.patrol.tours.tour import Tour


@pytest.fixture(scope="module")
def hall() -> Problem:
    """A hall with a closet beside it, behind a wall of a centimetre: who stands there stays."""
    wall = Obstacle(shape=MultiPolygon([shapely.difference(box(-0.01, 3.99, 1.01, 5.01), box(0, 4, 1, 5))]))
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=3.0), body_radius_m=0.4)
    planning = PatrolSettings(effort="quick")
    area = MultiPolygon([box(-0.01, 0, 10, 10)])
    return set_up_problem(
        Mission(name="hall", area=area, obstacles=(wall,), fleet=fleet, period_s=200.0, planning=planning)
    )


def tour_of(problem: Problem, component: int, *places: tuple[float, float]) -> Tour:
    return Tour(
        vertices_m=np.array(places), period_class=0, period_s=200.0, robots=1, robot=problem.robot, component=component
    )


def test_others_keep_two_bodies_off_and_lose_no_part(hall: Problem) -> None:
    assert len(hall.paths.parts) == 2
    place = shapely.Point(0.6, 4.5)
    clear = keeping_off(hall, [place], [1])
    assert len(clear.paths.parts) == 2
    assert clear.paths.parts[0].distance(place) >= 0.8
    assert clear.paths.parts[0].distance(place) < 1.1
    ((part, ground),) = clear.kept_off
    assert part == 0
    assert shapely.intersection(ground, clear.space.geoms[0]).area < 1e-9
    assert shapely.equals(clear.paths.parts[1], hall.paths.parts[1])
    assert np.array_equal(clear.paths.part_of(clear.viewpoints.xy_m), clear.viewpoints.component)
    assert keeping_off(hall, [shapely.Point(8.0, 8.0)], [0]) is hall  # nobody else is near


def test_tours_are_led_round_who_stays(hall: Problem) -> None:
    stays, past = tour_of(hall, 1, (0.6, 4.5)), tour_of(hall, 0, (1.42, 2.0), (1.42, 7.0), (5.0, 5.0))
    clear, (still, round_it) = clear_of_who_stays(hall, [stays, past])
    assert np.array_equal(still.vertices_m, stays.vertices_m)
    line = shapely.linestrings(np.vstack([round_it.vertices_m, round_it.vertices_m[:1]]))
    assert shapely.distance(line, shapely.Point(0.6, 4.5)) >= 0.8
    assert shapely.covers(clear.space.buffer(1e-9), line)
    assert clear_of_who_stays(hall, [past]) == (hall, [past])

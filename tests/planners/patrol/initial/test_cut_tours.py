"""A shared tour cut into tours of one robot each: all of its legs are driven, by few robots, none over its budget."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.initial.cut_tours import cut, cut_where_bodies_touch
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.tour import Tour, over_budget_share, tour_length_m

CORRIDOR = box(0.0, 0.0, 60.0, 4.0)
ROOMS = [box(x, 4.5, x + 8.0, 12.0) for x in (1.0, 11.0, 21.0, 31.0, 41.0, 51.0)]
DOORS = [box(x + 3.5, 3.5, x + 4.5, 5.0) for x in (1.0, 11.0, 21.0, 31.0, 41.0, 51.0)]


@pytest.fixture(scope="module")
def offices() -> Problem:
    """Six rooms with doors too narrow for two robots, along a corridor."""
    free = shapely.union_all([CORRIDOR, *ROOMS, *DOORS])
    walls = Obstacle(shape=MultiPolygon([shapely.difference(box(-1, -1, 61, 13), free)]))
    return set_up_problem(
        Mission(
            name="offices",
            area=MultiPolygon([box(-1, -1, 61, 13)]),
            obstacles=(walls,),
            fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=2.0), body_radius_m=0.3),
            period_s=70.0,
            planning=PatrolSettings(effort="quick"),
        )
    )


@pytest.fixture
def shared(offices: Problem) -> Tour:
    """There along the corridor, into every room, and back the same way; four robots share it."""
    stops = [(0.5, 2.0)]
    for x in (5.0, 15.0, 25.0, 35.0, 45.0, 55.0):
        stops += [(x, 2.0), (x, 10.0), (x, 2.0)]
    places = np.array([*stops, *stops[-2:0:-1]])
    alone = Tour(vertices_m=places, period_class=0, period_s=70.0, robots=1, robot=offices.robot, component=0)
    return replace(alone, robots=int(np.ceil(tour_length_m(alone) / alone.budget_m)))


def test_parts_drive_all_legs_and_have_one_robot_each(offices: Problem, shared: Tour) -> None:
    parts = cut(offices, shared)
    assert {part.robots for part in parts} == {1}
    assert over_budget_share(parts) == 0
    assert len(parts) <= shared.robots + 2
    driven = shapely.union_all([shapely.linestrings(np.vstack([p.vertices_m, p.vertices_m[:1]])) for p in parts])
    whole = shapely.linestrings(np.vstack([shared.vertices_m, shared.vertices_m[:1]]))
    assert shapely.covers(driven.buffer(1e-9), whole)


def test_only_what_no_timing_keeps_apart_is_cut(offices: Problem, shared: Tour) -> None:
    lone = replace(shared, vertices_m=shared.vertices_m[:4], robots=1)
    assert cut_where_bodies_touch(offices, [lone]) == [lone]
    parts = cut_where_bodies_touch(offices, [shared])
    assert len(parts) > shared.robots
    apart = replace(offices, robot=replace(offices.robot, body_radius_m=0.0))
    assert cut_where_bodies_touch(apart, [shared]) == [shared]


def test_a_tour_with_a_place_too_far_for_one_robot_stays(offices: Problem, shared: Tour) -> None:
    hasty = replace(shared, period_s=4.0)
    assert cut(offices, hasty) == [hasty]

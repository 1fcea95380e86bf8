"""Lanes over districts: few robots share each route, routes see all of it, and little is lost to the cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import LinearRing, LineString, MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.methods.large.lanes import (
    groups_for,
    in_boxes,
    in_districts,
    in_rows,
    promising_rows,
    robots_shared,
    space_near,
)
from rota.planners.patrol.methods.large.rows import MOST_SHARING
from rota.planners.patrol.methods.sweeping.routes import SweepGround, sweep_grounds
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.tour import tour_length_m

FIELD = Mission(
    name="field",
    area=MultiPolygon([box(0, 0, 200, 120).difference(box(60, 40, 90, 70))]),
    period_s=20,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=5)),
    planning=PatrolSettings(effort="quick"),
)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return set_up_problem(FIELD)


@pytest.mark.parametrize(("robots", "groups", "shares"), [(1, 1, [1]), (9, 2, [5, 4]), (3, 3, [1, 1, 1])])
def test_robots_are_shared_evenly(robots: int, groups: int, shares: list[int]) -> None:
    assert robots_shared(robots, groups).tolist() == shares


@pytest.mark.parametrize(("robots", "corners", "groups"), [(12, 0, 1), (13, 0, 2), (12, 1000, 2), (3, 10_000, 3)])
def test_districts_have_few_robots_and_few_corners(problem: Problem, robots: int, corners: int, groups: int) -> None:
    (ground,) = sweep_grounds(problem, ((0,),))
    if corners:
        round_shape = MultiPolygon([shapely.Point(0, 0).buffer(50, quad_segs=corners // 4)])
        assert shapely.count_coordinates(round_shape) == corners + 1
        ground = replace(ground, shape=round_shape)
    assert groups_for(problem, ground, robots) == groups


def test_routes_fit_and_leave_nothing_out_of_range(problem: Problem) -> None:
    (ground,) = sweep_grounds(problem, ((0,),))
    tours = in_districts(problem, ground, 0.02, None)
    assert tours is not None
    assert len(tours) >= 2
    for tour in tours:
        assert tour.robots <= MOST_SHARING
        assert tour_length_m(tour) <= 0.98 * tour.robots * 20 * 10
    swept = shapely.union_all(
        [LineString([*tour.vertices_m, tour.vertices_m[0]]).buffer(5, quad_segs=64) for tour in tours]
    )
    assert shapely.difference(ground.shape, swept).area == pytest.approx(0, abs=0.1)
    # lanes that lose nothing at borders and cuts are area / swath long; here one of ten or so is half in vain
    robots = sum(tour.robots for tour in tours)
    assert robots <= 1.3 * ground.shape.area / (10 * 200 * 0.98) + 1


def test_too_few_robots_give_none(problem: Problem) -> None:
    (ground,) = sweep_grounds(problem, ((0,),))
    assert in_districts(problem, ground, 0.0, 11) is None  # 23,100 m2 take 11.55 robots that sweep 10 m


def test_periods_too_short_for_boxes_are_met_by_loops_that_many_share(problem: Problem) -> None:
    (ground,) = sweep_grounds(problem, ((0,),))
    soon = tuple(replace(region, period_s=9.9) for region in problem.regions)
    hasty = replace(problem, regions=soon)  # a robot drives 99 m, and the reach is 5 m
    assert in_boxes(hasty, ground, 0.0, None) is None
    tours = in_districts(hasty, ground, 0.0, None)
    assert tours is not None
    assert max(tour_length_m(tour) / (tour.robots * 99) for tour in tours) <= 1
    # 23,100 m2 in lanes of 10 m are 23.3 robots; the hole is small, and ways round it cost as much as it is long
    assert sum(tour.robots for tour in tours) <= 1.4 * 23.3


@pytest.mark.slow  # lanes for bodies over two large fields
def test_robots_with_bodies_share_loops_that_keep_apart_and_no_other_routes() -> None:
    bodies = replace(FIELD, fleet=replace(FIELD.fleet, body_radius_m=0.2))
    alone = set_up_problem(bodies)
    (ground,) = sweep_grounds(alone, ((0,),))
    boxes = in_boxes(alone, ground, 0.0, None)
    assert boxes is not None
    assert {tour.robots for tour in boxes} == {1}
    assert (
        in_rows(alone, ground, promising_rows(alone, ground, 200.0), 0.0, None) is None
    )  # past the hole they would meet
    alone = set_up_problem(replace(bodies, area=MultiPolygon([box(0, 0, 400, 120)])))
    (ground,) = sweep_grounds(alone, ((0,),))
    rows = in_rows(alone, ground, promising_rows(alone, ground, 200.0), 0.0, None)
    assert rows is not None
    assert max(tour.robots for tour in rows) > 1
    lines = np.array([LinearRing(tour.vertices_m) for tour in rows])
    apart_m = shapely.distance(lines[:, None], lines[None])[np.triu_indices(len(lines), 1)]
    assert apart_m.min() >= 2 * 0.2


def test_ways_are_looked_for_nearby_only_where_the_district_hangs_together() -> None:
    # a comb of two teeth, 100 m long: between their ends the way leads round by the back
    comb = replace(FIELD, area=MultiPolygon([box(0, 0, 200, 120).difference(box(60, 20, 140, 120))]))
    problem = set_up_problem(comb)
    teeth = MultiPolygon([box(0, 90, 60, 120), box(140, 90, 200, 120)])
    ends = SweepGround(shape=teeth, stops_m=problem.points.xy_m[:0], period_class=0, component=0)
    assert space_near(problem, ends) is None
    near = space_near(problem, replace(ends, shape=MultiPolygon([box(0, 90, 60, 120)])))
    assert near is not None
    assert shapely.equals(near, box(0, 70, 60, 120))

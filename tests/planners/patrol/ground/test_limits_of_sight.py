"""The last ground that can be seen at all is sampled, seen from the border of the space, and planned for."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, Polygon, affinity, box

import rota
from rota.geometry.free_space import DemandedRegion, standing_space
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Sensor, SquareSensor
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.ground.limits_of_sight import (
    FEW_CORNERS,
    area_in_range,
    limit_is_asked_for,
    limit_points,
    with_reach_for,
)
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.ground.samples import points_of
from rota.planners.patrol.ground.standing import fine_arc_corners
from rota.planners.patrol.planner_settings import PatrolSettings

DISC = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2)).equal_robot("r")
SQUARE = Fleet(speed_m_s=1, sensor=SquareSensor(side_m=4)).equal_robot("r")
CLOSED = box(4, 4, 9, 9.5)  # wider than twice the reach: 1 m x 1.5 m of it nobody sees
SPACE = MultiPolygon([box(0, 0, 14, 14).difference(CLOSED)])
GROUND = DemandedRegion(name="area", period_s=60, demand="every_point", shape=MultiPolygon([box(0, 0, 14, 14)]))
NO_WALLS = np.zeros((0, 4))


@pytest.mark.parametrize("robot", [DISC, SQUARE])
def test_the_area_in_range_is_all_of_it_but_for_chords(robot: Robot) -> None:
    space = MultiPolygon([Polygon([(0, 0), (6, 1), (2, 7)]), box(12, 0, 13, 1)])
    points = np.random.default_rng(3).uniform((-4, -4), (17, 11), (2000, 2))
    _, ranges = nearest_places(points, space, NO_WALLS, robot)
    inner = area_in_range(space, robot, 0.25)
    outer = inner if robot is SQUARE else space.buffer(1.75 / math.cos(math.pi / 256), quad_segs=64)
    assert (ranges[shapely.contains_xy(inner, points)] <= 1.75).all()
    assert (ranges[~shapely.contains_xy(outer, points)] >= 1.75).all()
    # between the two lie only the chords of arcs
    assert outer.area - inner.area <= (1e-9 if robot is SQUARE else 0.01)


def test_limit_points_lie_just_in_reach_and_close_together() -> None:
    points = limit_points([GROUND], [0], SPACE, DISC, range_margin_m=0.012, spacing_m=0.2)
    _, ranges = nearest_places(points.xy_m, SPACE, NO_WALLS, DISC)
    outermost = ranges > 1.995
    assert ranges[outermost] == pytest.approx(1.999, abs=1e-6)
    assert ranges[~outermost] == pytest.approx(1.994, abs=1e-6)
    # round a core of 1 m x 1.5 m
    assert outermost.sum() >= 5 / 0.2
    along = shapely.get_coordinates(shapely.segmentize(box(6, 6, 7, 7.5).boundary, 0.01))
    away = np.hypot(*(along[:, None] - points.xy_m[outermost][None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() <= 0.11


def test_only_ground_beyond_the_margin_is_at_the_limit() -> None:
    robots = {"narrow": box(4, 4, 7.9, 9), "wide": box(4, 4, 7.999, 9), "hedge": box(0, 0, 0.1, 0.1)}
    asked = {}
    for name, shape in robots.items():
        asked[name] = limit_is_asked_for([GROUND], MultiPolygon([GROUND.shape.geoms[0].difference(shape)]), DISC, 0.012)
    assert asked == {"narrow": False, "wide": True, "hedge": False}
    visit = DemandedRegion(name="tank", period_s=60, demand="visit", shape=MultiPolygon([CLOSED]))
    assert not limit_is_asked_for([visit], SPACE, DISC, 0.012)
    assert not len(limit_points([visit], [0], SPACE, DISC, range_margin_m=0.012, spacing_m=0.2))


@pytest.mark.parametrize("block", [box(4, 4, 7.9, 9), box(4, 4, 7.999, 9), box(4, 4, 5, 5), Point(7, 7).buffer(1.8)])
def test_squares_near_corners_tell_what_the_area_in_range_tells(
    block: Polygon, monkeypatch: pytest.MonkeyPatch
) -> None:
    ground = GROUND.shape.geoms[0].difference(shapely.segmentize(block, 0.1))
    ragged = MultiPolygon([shapely.segmentize(ground, 0.05)])
    assert len(shapely.get_coordinates(ragged)) > FEW_CORNERS
    looked_at = []

    def seen_in_range(*arguments: object) -> object:
        looked_at.append(arguments)
        return area_in_range(*arguments)

    monkeypatch.setattr(f"{limit_is_asked_for.__module__}.area_in_range", seen_in_range)
    asked = limit_is_asked_for([GROUND], ragged, DISC, 0.012)
    assert bool(looked_at) == (block.area > 2)  # all of a small block is so near that no more is looked at
    monkeypatch.setattr(f"{limit_is_asked_for.__module__}.FEW_CORNERS", 10_000)
    assert limit_is_asked_for([GROUND], ragged, DISC, 0.012) == asked


def test_reach_is_given_where_it_is_needed_only() -> None:
    points = points_of(np.zeros((5, 2)), 1.0, 0, 0, shrink_m=0.1)
    ranges = np.array([0.0, 1.0, 1.9, 1.998, math.inf])
    fitted = with_reach_for(points, ranges, 2.0, 0.01)
    # 0.95 m to spare, then half of it; never more than the full reach
    assert fitted.shrink_m == pytest.approx([0.1, 0.1, 0.04, -0.009, -0.01])
    reach = 2.0 - 0.01 - fitted.shrink_m
    assert (reach[:4] > ranges[:4]).all()
    assert (reach <= 2.0).all()


def test_arcs_are_fine_at_the_limit_of_sight() -> None:
    for body_m in (0.01, 0.2, 1.0, 5.0):
        corners = fine_arc_corners(body_m)
        assert corners >= 16
        assert body_m * (1 / math.cos(math.pi / corners) - 1) <= 0.0005 + 1e-12
        finer = fine_arc_corners(body_m, few_walls=True)
        assert body_m * (1 / math.cos(math.pi / finer) - 1) <= 0.00005 + 1e-12


def mission(sensor: Sensor, area: Polygon, closed: Polygon | None = None, *, body_radius_m: float = 0.0) -> Mission:
    obstacles = () if closed is None else (Obstacle(shape=MultiPolygon([closed]), blocks="motion"),)
    return Mission(
        name="yard",
        area=MultiPolygon([area]),
        obstacles=obstacles,
        period_s=60,
        fleet=Fleet(speed_m_s=1, sensor=sensor, body_radius_m=body_radius_m),
        planning=PatrolSettings(effort="quick"),
    )


YARD, BLOCK = box(0, 0, 5.6, 5.6), box(1.5, 1.6, 4.0, 4.1)
CORRIDOR = box(0, 0, 3, 3).union(box(3, 1, 4.2, 1.15))


def test_every_sample_of_a_problem_is_seen_from_one_of_its_places() -> None:
    problem = set_up_problem(mission(DiscSensor(radius_m=1), YARD, BLOCK))
    assert set(problem.viewpoints.seen.tolist()) == set(range(len(problem.points)))
    assert problem.at_limit
    # only the core is given up: half a metre square, of which lattice points 0.2 m apart are dropped
    core = box(2.5, 2.6, 3.0, 3.1)
    assert not shapely.contains_xy(core, problem.points.xy_m).any()
    strip = core.buffer(0.15).difference(core.buffer(0.0005))
    assert shapely.contains_xy(strip, problem.points.xy_m).sum() >= 10


@pytest.mark.parametrize(
    ("what", "core_m2"),
    [
        (mission(DiscSensor(radius_m=1), YARD, BLOCK), 0.25),
        (mission(SquareSensor(side_m=2), YARD, BLOCK), 0.25),
        (mission(DiscSensor(radius_m=1), YARD, affinity.rotate(BLOCK, 20)), 0.25),
        # a hair narrower than twice the reach: all of it can be seen, from its border only
        (mission(DiscSensor(radius_m=1), YARD, box(1.6, 1.6, 3.598, 4.1)), 0.0),
        (mission(DiscSensor(radius_m=0.3), box(0, 0, 1.7, 1.7), Point(0.85, 0.85).buffer(0.38)), math.pi * 0.08**2),
    ],
    ids=["disc", "square", "tilted", "twice the reach", "round"],
)
def test_ground_that_is_seen_only_from_the_border_of_a_no_fly_zone_is_planned_for(
    what: Mission, core_m2: float
) -> None:
    plan = rota.make_plan(what)
    report = rota.check_plan(plan)
    assert report.verdict == "met"
    # the check rounds outwards by about a centimetre, never inwards
    excluded = report.demands[0].excluded_area_m2
    assert core_m2 - 1e-3 <= excluded <= core_m2 + 0.015 * 4 * math.sqrt(core_m2) + 1e-3


@pytest.mark.parametrize("turned", [0, 33])
def test_a_corridor_too_thin_for_the_body_is_seen_as_far_as_it_can_be(turned: float) -> None:
    what = mission(DiscSensor(radius_m=1), affinity.rotate(CORRIDOR, turned), body_radius_m=0.1)
    report = rota.check_plan(rota.make_plan(what))
    assert report.verdict == "met"
    # the body stands in the opening as far as its corners let it: a circle of the reach round there, 0.15 m high
    deepest = 3 - math.sqrt(0.1**2 - 0.075**2)
    beyond = box(3, 1, 4.2, 1.15).difference(Point(deepest, 1.075).buffer(1, quad_segs=256)).area
    assert beyond - 1e-3 <= report.demands[0].excluded_area_m2 <= beyond + 0.015 * 0.16 + 1e-3


def test_space_is_the_finer_at_the_limit_of_sight() -> None:
    wide = affinity.scale(CORRIDOR, 5, 5, origin=(0, 0))
    deepest = 15 - math.sqrt(0.5**2 - 0.375**2)
    what = mission(DiscSensor(radius_m=5), wide, body_radius_m=0.5)
    assert standing_space(what, 0.5).bounds[2] < deepest - 1e-3
    problem = set_up_problem(what)
    assert deepest - 1e-3 <= problem.space.bounds[2] <= deepest


def test_a_tiny_unseeable_place_is_refused_in_words() -> None:
    notch = Polygon([(0, 0), (10, 0), (10, 4.98), (12.9, 5), (10, 5.02), (10, 10), (0, 10)])
    mission = Mission(
        name="notch", area=MultiPolygon([notch]), period_s=100, unseeable="refuse",
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), body_radius_m=0.3),
    )  # fmt: skip
    with pytest.raises(rota.NoPlanFound, match=r"less than 0\.01 m2 \(0\.0% of what is asked\)"):
        set_up_problem(mission)


def field(closed: Polygon, **limits: Any) -> Mission:
    """A field of 20 m x 16 m about a no-fly zone that one can look into, for robots with mass and a reach of 2 m."""
    return Mission(
        name="field",
        area=MultiPolygon([box(0, 0, 20, 16)]),
        obstacles=(Obstacle(shape=MultiPolygon([closed]), blocks="motion"),),
        period_s=400.0,
        fleet=Fleet(
            speed_m_s=1.0,
            sensor=DiscSensor(radius_m=2),
            motion=MotionLimits(acceleration_m_s2=1.0, corner_m=0.5, **limits),
        ),
        planning=PatrolSettings(effort="quick"),
    )


def test_corners_are_cut_less_where_what_is_asked_is_seen_only_from_beside_a_wall() -> None:
    # corners cut by 0.5 m keep polylines 0.5 m off the zone: they see 1.5 m of it from both sides
    cut_m = [set_up_problem(field(box(6, 6, 6 + w, 11))).robot.motion.corner_m for w in (2.9, 3.4, 3.8, 3.995)]
    assert cut_m == [0.5, 0.25, 0.0625, 0.0]
    # who flies by its firmware does not choose
    assert set_up_problem(field(box(6, 6, 9.8, 11), vehicle="arducopter")).robot.motion.corner_m == 0.5
    # the middle of a slit 0.2 m wide behind an obstacle is seen along it, from beside the wall
    shed = replace(field(box(0, 0, 1, 1)), obstacles=(Obstacle(shape=MultiPolygon([box(6, 12, 9, 15.8)])),))
    assert set_up_problem(shed).robot.motion.corner_m == 0.125
    plan = rota.make_plan(field(box(6, 6, 9.8, 11)))
    assert rota.check_plan(plan).verdict == "met"


@pytest.mark.slow  # a search of some seconds
def test_bodies_with_square_sensors_see_all_they_can_of_a_wide_no_fly_zone() -> None:
    # the corners of what is seen of it are arcs, as those of where bodies stand
    closed = box(1.5, 1.5, 6.5, 7.5)
    plan = rota.make_plan(mission(SquareSensor(side_m=4), box(0, 0, 8, 9), closed, body_radius_m=0.2))
    (area,) = rota.check_plan(plan).demands
    assert area.outcome == "met"
    assert area.excluded_area_m2 == pytest.approx((5 - 3.6) * (6 - 3.6) - (1 - math.pi / 4) * 4 * 0.2**2, abs=0.005)

"""The traditional methods end to end: plans that the check passes, with the shape that each method promises."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, box

import rota
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.methods.sweeping.methods import cut_in_two, divided_area, widest
from rota.planners.patrol.planner_settings import Method, PatrolSettings
from rota.routes.distinct_loops import distinct_loops

TRADITIONAL: tuple[Method, ...] = ("parallel", "sequential", "decomposition")
ONE_AT_ONCE = ("parallel", *(pytest.param(name, marks=pytest.mark.slow) for name in TRADITIONAL[1:]))  # searches
YARD = Mission(
    name="yard",
    area=MultiPolygon([box(0, 0, 60, 40)]),
    obstacles=(Obstacle(shape=MultiPolygon([box(10, 10, 20, 20)])),),
    zones=(
        Zone(name="gate", shape=MultiPolygon([box(40, 20, 55, 35)]), period_s=20),
        Zone(name="tank", shape=MultiPolygon([box(5, 25, 15, 35)]), period_s=30),
    ),
    period_s=60,
    fleet=Fleet(speed_m_s=4, sensor=DiscSensor(radius_m=5)),
    planning=PatrolSettings(effort="quick"),
)
FIELD = replace(YARD, obstacles=(), zones=(), area=MultiPolygon([box(0, 0, 100, 59)]), period_s=45)


@cache
def planned_field(method: Method) -> rota.Plan:
    """The plan of the field, made once for all tests of this file."""
    return planned(FIELD, method)


def planned(mission: Mission, method: Method) -> rota.Plan:
    plan = rota.make_plan(mission.with_method(method))
    report = rota.check_plan(plan)
    assert (report.verdict, report.violations) == ("met", ())
    assert plan.lower_bound_robots is not None
    assert plan.lower_bound_robots <= len(plan.trajectories)
    assert PatrolSettings.of(plan.mission).method == method
    return plan


@pytest.mark.parametrize("method", TRADITIONAL)
def test_a_yard_with_an_obstacle_and_two_zones_is_met(method: Method) -> None:
    plan = planned(YARD, method)
    assert len(plan.trajectories) <= 5
    for one in plan:
        assert LineString(one.positions_m).intersection(box(10, 10, 20, 20).buffer(-1e-6)).is_empty


def test_sequential_robots_follow_each_other_on_one_route() -> None:
    plan = planned_field("sequential")
    (loop,) = distinct_loops(plan)
    robots = len(plan.trajectories)
    assert robots == int(np.ceil(loop.loop_length_m / (4 * 45)))  # as many as the period asks, none to spare
    assert 590 < loop.loop_length_m < 720  # area / swath is 590 m


@pytest.mark.parametrize("method", ["parallel", "decomposition"])
def test_robots_have_loops_and_ground_of_their_own(method: Method) -> None:
    plan = planned_field(method)
    assert len(distinct_loops(plan)) == len(plan.trajectories) <= 6
    hulls = []
    for one in plan:
        assert one.loop_duration_s <= 45
        hulls.append(LineString(one.positions_m).convex_hull)
    for k, hull in enumerate(hulls):
        for other in hulls[:k]:
            assert hull.intersection(other).area <= 0.1 * min(hull.area, other.area)


def test_parallel_lanes_have_one_direction() -> None:
    plan = planned_field("parallel")
    steps = np.vstack([np.diff(one.positions_m, axis=0) for one in plan])
    long = steps[np.hypot(*steps.T) > 20]
    turn = np.arctan2(long[:, 1], long[:, 0]) % np.pi
    assert np.abs(np.sin(turn - turn[0])).max() < 1e-6


@pytest.mark.parametrize("method", ONE_AT_ONCE)
def test_parts_bodies_visits_turning_and_square_sensors(method: Method) -> None:
    mission = replace(
        YARD,
        obstacles=(*YARD.obstacles, Obstacle(shape=MultiPolygon([box(30, -1, 32, 41)]), blocks="motion")),
        zones=(YARD.zones[0], Zone(name="tap", shape=MultiPolygon([box(24, 2, 28, 6)]), period_s=50, demand="visit")),
        fleet=Fleet(speed_m_s=4, sensor=SquareSensor(side_m=9), body_radius_m=0.2, turn_rate_rad_s=2.0),
    )
    plan = planned(mission, method)
    xs = [one.positions_m[:, 0] for one in plan]
    assert all(x.max() <= 29.8 + 1e-9 or x.min() >= 32.2 - 1e-9 for x in xs)
    assert {bool(x.max() < 30) for x in xs} == {True, False}


@pytest.mark.parametrize("method", ["parallel", "decomposition"])
def test_a_lane_too_long_for_one_robot_is_cut_into_pieces(method: Method) -> None:
    # 100 m there and back take 50 s; bodies on one lane would meet face to face
    corridor = replace(
        FIELD, area=MultiPolygon([box(0, 0, 100, 6)]), period_s=30,
        fleet=Fleet(speed_m_s=4, sensor=DiscSensor(radius_m=5), body_radius_m=0.3),
    )  # fmt: skip
    plan = planned(corridor, method)
    assert len(distinct_loops(plan)) == len(plan.trajectories) == 2


@pytest.mark.parametrize("method", TRADITIONAL)
def test_the_same_seed_gives_the_same_plan(method: Method) -> None:
    assert rota.make_plan(FIELD.with_method(method)) == planned_field(method)


def test_too_few_robots_are_told_with_the_bound() -> None:
    names = tuple(FIELD.fleet.equal_robot(f"guard-{k}") for k in range(2))
    few = replace(FIELD, fleet=replace(FIELD.fleet, robots=names))
    with pytest.raises(
        rota.NoPlanFound, match=r"2 robots cannot meet the demand: .*; proved: at least 4 robots"
    ) as failure:
        rota.make_plan(few.with_method("sequential"))
    assert isinstance(failure.value.best, rota.Plan)


def test_spare_robots_join() -> None:
    names = tuple(FIELD.fleet.equal_robot(f"guard-{k}") for k in range(7))
    many = replace(FIELD, fleet=replace(FIELD.fleet, robots=names))
    assert len(planned(many, "parallel").trajectories) == 7


def test_sub_areas_are_in_proportion_to_their_weights() -> None:
    problem = set_up_problem(FIELD)
    shape = MultiPolygon([box(0, 0, 100, 59).difference(box(30, 20, 60, 40))])
    weights = np.array([1.0, 2.0, 1.5, 1.0, 0.5])
    parts = divided_area(problem, shape, weights)
    assert [part.area for part in parts] == pytest.approx(list(shape.area * weights / weights.sum()), rel=1e-4)
    assert shapely.union_all(parts).area == pytest.approx(shape.area, rel=1e-6)
    below, above = cut_in_two(MultiPolygon([box(0, 0, 10, 10)]), 0.0, 0.3)
    assert below.bounds == pytest.approx((0, 0, 10, 3), abs=1e-4)
    assert above.bounds == pytest.approx((0, 3, 10, 10), abs=1e-4)


def test_widest_finds_the_last_good_number() -> None:
    for last_good in range(1, 9):
        assert widest(lambda k, g=last_good: k <= g, 1, 8) == last_good
    assert widest(lambda k: False, 3, 8) == 3

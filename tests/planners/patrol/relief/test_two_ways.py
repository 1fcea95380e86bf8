"""Robots with bodies that relieve each other at a post pass each other beside it."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
import shapely

from rota import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, Zone, check_plan, make_plan
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.relief.ways import Ways, passing_ways
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody

BODY_M = 0.5
POST = Zone(name="post", shape=shapely.MultiPolygon([shapely.box(44, 4, 48, 8)]), period_s=4, demand="visit")
MISSION = Mission(
    name="post",
    area=shapely.MultiPolygon([shapely.box(0, 0, 60, 12)]),
    zones=(POST,),
    fleet=Fleet(
        speed_m_s=4,
        sensor=DiscSensor(radius_m=3),
        body_radius_m=BODY_M,
        battery=BatteryLimits(endurance_s=100, recharge_s=50),
    ),
    chargers=(Charger(name="pad", at=(6, 6), places=2),),
    planning=PatrolSettings(effort="quick"),
)
EVERY_POINT = dataclasses.replace(MISSION, zones=(dataclasses.replace(POST, demand="every_point"),))


@pytest.mark.parametrize("mission", [MISSION, EVERY_POINT])
def test_robots_relieve_each_other_where_a_period_is_shorter_than_the_ways_there_and_back(mission: Mission) -> None:
    """The ways take 19 s, the period 4 s: two robots do, which are on the post 80 s and charge for 50 s."""
    plan = make_plan(mission)
    assert (check_plan(plan).verdict, len(plan)) == ("met", 2)
    moments_s = np.arange(0, 2 * plan.trajectories[0].loop_duration_s, 0.01)
    both_m = [robot.at(moments_s) for robot in plan]
    apart_m = np.hypot(*(both_m[0] - both_m[1]).T)
    assert 2 * BODY_M <= apart_m.min() < 2 * BODY_M * 1.2


@pytest.mark.parametrize(
    "slow",
    [
        {"turn_rate_rad_s": 1.0},
        {"motion": MotionLimits(acceleration_m_s2=2.5)},
        {"motion": MotionLimits(acceleration_m_s2=2.5, jerk_m_s3=5, corner_m=1)},
    ],
)
def test_so_do_robots_that_take_time_to_turn_or_to_change_speed(slow: dict[str, Any]) -> None:
    mission = dataclasses.replace(EVERY_POINT, fleet=dataclasses.replace(EVERY_POINT.fleet, **slow))
    plan = make_plan(mission)
    assert check_plan(plan).verdict == "met"
    assert len(plan) <= 3
    moments_s = np.arange(0, plan.trajectories[0].loop_duration_s, 0.01)
    least_m = np.inf
    for one, other in itertools.combinations([robot.at(moments_s) for robot in plan], 2):
        away = ((one != mission.chargers[0].at) & (other != mission.chargers[0].at)).any(
            axis=1
        )  # on it bodies are none
        least_m = min(least_m, np.hypot(*(one - other)[away].T).min())
    assert 2 * BODY_M <= least_m < 2 * BODY_M * 1.4


def test_who_gets_up_speed_passes_after_a_pause_as_long_as_half_of_it_takes_for_a_radius_and_a_half() -> None:
    """At a 2.5 m/s2 both are 3/2 r from the post in the middle of the pause: it lasts the root of 12 r / a."""
    robot = dataclasses.replace(MISSION.fleet, motion=MotionLimits(acceleration_m_s2=2.5)).equal_robot("robot-1")
    found = Ways(robot, PathsByBody(MISSION)).passing(np.array([6.0, 6.0]), np.array([45.0, 6.0]), 3 * BODY_M / 4)
    assert found is not None
    assert 1 <= found.pause_s / math.sqrt(12 * BODY_M / 2.5) < 1.1


@pytest.mark.parametrize(("period_s", "robots"), [(28, 2), (32, 1)])
def test_who_takes_time_to_turn_turns_back_on_the_post_and_on_the_charger(period_s: float, robots: int) -> None:
    """9.5 s each way, and 10.5 s to turn on the charger: one robot leaves the post alone for 29.5 s."""
    fleet = dataclasses.replace(
        MISSION.fleet, turn_rate_rad_s=0.3, body_radius_m=0, battery=BatteryLimits(endurance_s=60, recharge_s=10)
    )
    zones = (dataclasses.replace(POST, period_s=period_s),)
    plan = make_plan(dataclasses.replace(MISSION, fleet=fleet, zones=zones))
    assert (check_plan(plan).verdict, len(plan)) == ("met", robots)


def paths_in(mission: Mission) -> ShortestPaths:
    return ShortestPaths(standing_space(mission, BODY_M))


@pytest.mark.parametrize("walls", [[], [shapely.box(38, 0, 45, 4)], [shapely.box(30, 5.5, 44.2, 6.5)]])
def test_ways_that_pass_are_at_right_angles_at_the_post_and_clear_of_walls(walls: list[shapely.Polygon]) -> None:
    obstacles = tuple(Obstacle(shape=shapely.MultiPolygon([wall])) for wall in walls)
    mission = dataclasses.replace(MISSION, obstacles=obstacles)
    charger_m, post_m = np.array([6.0, 6.0]), np.array([45.0, 6.0])
    found = passing_ways(paths_in(mission), charger_m, post_m, 1.5)
    assert found is not None
    there_m, back_m = found
    assert [there_m[0].tolist(), back_m[0].tolist()] == [charger_m.tolist()] * 2
    assert [there_m[-1].tolist(), back_m[-1].tolist()] == [post_m.tolist()] * 2
    comes, goes = there_m[-2] - post_m, back_m[-2] - post_m
    assert (np.hypot(*comes), np.hypot(*goes), comes @ goes) == pytest.approx((1.5, 1.5, 0), abs=1e-9)
    for (a, b), wall in itertools.product([*itertools.pairwise(there_m), *itertools.pairwise(back_m)], walls):
        assert shapely.distance(shapely.LineString([a, b]), wall) >= BODY_M - 1e-9


def test_no_ways_pass_where_walls_leave_no_room_or_the_charger_is_beside_the_post() -> None:
    corridor = tuple(
        Obstacle(shape=shapely.MultiPolygon([shapely.box(20, *sides)])) for sides in ((0, 60, 5.2), (6.8, 60, 12))
    )
    narrow = paths_in(dataclasses.replace(MISSION, obstacles=corridor))
    charger_m, post_m = np.array([6.0, 6.0]), np.array([45.0, 6.0])
    assert passing_ways(narrow, charger_m, post_m, 1.5) is None
    assert passing_ways(paths_in(MISSION), np.array([46.0, 6.0]), post_m, 1.5) is None

"""What robots that turn on the spot sweep at most: against drawn paths, a path that keeps to the limit, and plans."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import MultiPolygon, Point, box

from rota.model.mission import DiscSensor, Fleet, Mission, Robot, SquareSensor, Zone
from rota.planners.patrol.bounds.area_bound import area_rate
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.bounds.turning_bound import circle_radius_m, steady_speed_m_s, turning_robots
from rota.planners.patrol.ground.problem import set_up_problem

ROBOT = Fleet(speed_m_s=3.0, sensor=DiscSensor(radius_m=4), turn_rate_rad_s=0.7).equal_robot("r")


def mean_speed_m_s(corners_m: NDArray[np.float64], robot: Robot) -> float:
    """Of a closed way (n, 2), driven at full speed with stops to turn at its corners."""
    legs = np.roll(corners_m, -1, axis=0) - corners_m
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    turns = np.abs((np.diff(headings, append=headings[:1]) + np.pi) % (2 * np.pi) - np.pi)
    length_m = float(np.hypot(*legs.T).sum())
    assert robot.turn_rate_rad_s is not None
    return length_m / (length_m / robot.speed_m_s + float(turns.sum()) / robot.turn_rate_rad_s)


def test_no_closed_way_in_a_circle_is_driven_faster() -> None:
    rng = np.random.default_rng(1)
    fastest = 0.0
    for _ in range(500):
        robot = replace(ROBOT, speed_m_s=rng.uniform(0.2, 9), turn_rate_rad_s=rng.uniform(0.05, 4))
        radius_m = rng.uniform(1, 60)
        angle, away = rng.uniform(0, 2 * np.pi, 12), radius_m * np.sqrt(rng.uniform(0.5, 1, 12))
        angle = np.sort(angle) if rng.random() < 0.5 else angle
        corners = np.column_stack([away * np.cos(angle), away * np.sin(angle)])[: rng.integers(2, 13)]
        share = mean_speed_m_s(corners, robot) / steady_speed_m_s(robot, radius_m)
        assert share <= 1 + 1e-12
        fastest = max(fastest, share)
    assert fastest > 0.9


def test_a_way_along_the_circle_keeps_to_the_limit() -> None:
    angle = np.arange(2000) * 2 * np.pi / 2000
    circle = 17 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert mean_speed_m_s(circle, ROBOT) == pytest.approx(steady_speed_m_s(ROBOT, 17), rel=1e-5)
    assert steady_speed_m_s(replace(ROBOT, turn_rate_rad_s=None), 17) == 3.0
    assert steady_speed_m_s(ROBOT, 0.0) == 0.0


def test_one_period_asks_for_area_over_what_is_swept_with_the_steady_speed() -> None:
    ground = MultiPolygon([box(0, 0, 100, 30)])
    steady_m_s = steady_speed_m_s(ROBOT, 20.0)
    asked = turning_robots([ground], [3000.0], [60.0], ROBOT, 20.0)[0]
    assert asked == pytest.approx(3000 / (2 * 4 * steady_m_s * 60 + math.pi * 16))
    assert asked > area_rate([3000.0], [60.0], ROBOT)[0]
    square = replace(ROBOT, sensor=SquareSensor(side_m=6))
    asked = turning_robots([ground], [3000.0], [60.0], square, 20.0)[0]
    assert asked == pytest.approx(3000 / (math.sqrt(2) * 6 * steady_m_s * 60 + 36))


def test_where_turning_takes_hardly_any_time_it_asks_what_the_others_ask() -> None:
    shapes = [MultiPolygon([box(0, 0, 30, 30)]), MultiPolygon([box(30, 0, 90, 30)])]
    areas_m2, periods_s = [900.0, 1800.0], [10.0, 40.0]
    quick = replace(ROBOT, turn_rate_rad_s=1e9)
    asked = turning_robots(shapes, areas_m2, periods_s, quick, 50.0)[0]
    known = max(area_rate(areas_m2, periods_s, quick)[0], swept_robots(shapes, [0.0, 0.0], periods_s, quick)[0])
    assert asked == pytest.approx(known, rel=1e-6)
    assert turning_robots(shapes, areas_m2, periods_s, replace(ROBOT, turn_rate_rad_s=None), 50.0) == (0.0, 0.0)
    assert turning_robots([], [], [], ROBOT, 50.0) == (0.0, 0.0)
    assert turning_robots(shapes, areas_m2, periods_s, ROBOT, 0.0) == (0.0, 0.0)


def test_with_several_periods_robots_may_turn_where_they_see_most() -> None:
    # two thirds of the time go into turning: with the whole of it the bound would be higher
    shapes = [MultiPolygon([box(0, 0, 30, 30)]), MultiPolygon([box(500, 0, 590, 300)])]
    areas_m2, periods_s, slow = [900.0, 27_000.0], [4.0, 400.0], replace(ROBOT, turn_rate_rad_s=0.1)
    steady = replace(slow, speed_m_s=steady_speed_m_s(slow, 15.0))
    assert steady.speed_m_s == pytest.approx(1.0)
    whole = swept_robots(shapes, [0.0, 0.0], periods_s, steady)[0]
    earned = [1 / (1 + math.pi * 16 / (2 * 4 * t)) for t in periods_s]
    asked = turning_robots(shapes, areas_m2, periods_s, slow, 15.0)[0]
    by_windows = area_rate(areas_m2, periods_s, steady)[0]
    assert asked == pytest.approx(max(by_windows, whole / (1 + (earned[1] - earned[0]) * 2 / 3)))
    assert asked < whole


def test_the_circle_is_the_areas_less_the_smallest_body() -> None:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), body_radius_m=0.5)
    mission = Mission(name="m", area=MultiPolygon([box(0, 0, 6, 8)]), period_s=100, fleet=fleet)
    assert circle_radius_m(mission) == pytest.approx(4.5, rel=1e-5)
    small = replace(fleet.equal_robot("small"), body_radius_m=0.1)
    mixed = replace(fleet, robots=(small, fleet.equal_robot("large")))
    assert circle_radius_m(replace(mission, fleet=mixed)) == pytest.approx(4.9, rel=1e-5)


def test_the_strongest_robot_turns_as_fast_as_any_or_in_no_time() -> None:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), turn_rate_rad_s=0.5)
    assert strongest_robot(fleet).turn_rate_rad_s == 0.5
    slow, fast = fleet.equal_robot("slow"), replace(fleet.equal_robot("fast"), turn_rate_rad_s=2.0)
    assert strongest_robot(replace(fleet, robots=(slow, fast))).turn_rate_rad_s == 2.0
    at_once = replace(slow, name="at once", turn_rate_rad_s=None)
    assert strongest_robot(replace(fleet, robots=(slow, at_once))).turn_rate_rad_s is None


def test_a_round_meadow_takes_more_robots_that_stop_to_turn() -> None:
    meadow = MultiPolygon([Point(0, 0).buffer(20)])
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=3))
    mission = Mission(name="meadow", area=meadow, period_s=60, fleet=fleet)
    turning = replace(mission, fleet=replace(fleet, turn_rate_rad_s=0.2))
    bound, slower = (prove_bound(set_up_problem(m)) for m in (mission, turning))
    assert (bound.robots, slower.robots) == (2, 3)
    assert "a robot that stops to turn" in slower.reason
    zoned = replace(turning, zones=(Zone(name="z", shape=MultiPolygon([box(-3, -3, 3, 3)]), period_s=20),))
    assert prove_bound(set_up_problem(zoned)).robots >= 3

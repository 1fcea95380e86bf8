"""Robots that join and leave: sight is credited only to those that take part, and bodies are there all the time."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from shapely import MultiPolygon, box

from rota import SwarmSettings
from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Zone
from rota.model.plan import Plan, Trajectory

SENSOR = DiscSensor(radius_m=10)


def robot(name: str, **changed: Any) -> Robot:
    return Robot(name=name, speed_m_s=2, sensor=SENSOR, body_radius_m=1, **changed)


def plan_of(*pairs: tuple[Robot, list[float], list[tuple[float, float]]], period_s: float | None = 5) -> Plan:
    fleet = Fleet(speed_m_s=2, sensor=SENSOR, body_radius_m=1, robots=tuple(robot for robot, _, _ in pairs))
    zone = Zone(name="yard", shape=MultiPolygon([box(48, 48, 52, 52)]), period_s=period_s)
    mission = Mission(
        name="m", area=MultiPolygon([box(0, 0, 100, 100)]), fleet=fleet, zones=(zone,), planning=SwarmSettings()
    )
    trajectories = (
        Trajectory(robot=robot.name, times_s=np.array(times), positions_m=np.array(at), loop_start_s=times[-1])
        for robot, times, at in pairs
    )
    return Plan(mission=mission, trajectories=tuple(trajectories))


def test_what_a_robot_that_has_left_has_in_range_is_not_seen() -> None:
    there = (robot("a"), [0.0], [(50, 50)])
    gone = (robot("a", leaves_s=60), [0.0], [(50, 50)])
    assert check_plan(plan_of(there)).verdict == "met"
    report = check_plan(plan_of(gone))
    assert report.verdict == "violated"
    assert report.demands[0].outcome == "violated"
    other = (robot("b"), [0.0, 10.0], [(70, 50), (55, 50)])
    assert check_plan(plan_of(gone, other)).verdict == "met"


def test_what_a_robot_has_in_range_before_it_joins_is_not_seen() -> None:
    late = (robot("a", joins_s=30), [0.0, 30.0], [(50, 50), (50, 50)])
    report = check_plan(plan_of(late))
    assert report.verdict == "met"
    assert report.first_coverage_s == 30
    soon = (robot("a", joins_s=30), [0.0], [(50, 50)])
    report = check_plan(plan_of(soon))
    assert [(v.kind, v.value, v.limit) for v in report.violations] == [("sees before it joins", 0.0, 30.0)]


def test_robots_that_are_away_stand() -> None:
    places = [(20.0, 50.0), (20.0, 50.0), (50.0, 50.0)]
    ok = (robot("a", joins_s=30), [0.0, 30.0, 50.0], places)
    assert check_plan(plan_of(ok)).verdict == "met"
    early = (robot("a", joins_s=30), [0.0, 29.9, 50.0], places)
    assert [v.kind for v in check_plan(plan_of(early)).violations] == ["moves while away"]
    until = (robot("a", leaves_s=50), [0.0, 30.0, 50.0], places)
    assert [v.kind for v in check_plan(plan_of(until, period_s=None)).violations] == []
    later = (robot("a", leaves_s=49), [0.0, 30.0, 50.0], places)
    assert [v.kind for v in check_plan(plan_of(later, period_s=None)).violations] == ["moves while away"]
    times, round_m = [0.0, 10.0, 20.0], [(50.0, 50.0), (55.0, 50.0), (50.0, 50.0)]
    loop = plan_of((robot("a", leaves_s=99), times, round_m), period_s=None)
    loop = dataclasses.replace(loop, trajectories=(dataclasses.replace(loop.trajectories[0], loop_start_s=0.0),))
    assert [v.kind for v in check_plan(loop).violations] == ["moves while away"]


def test_the_bodies_of_robots_that_are_away_are_in_the_way() -> None:
    left = (robot("a", leaves_s=1), [0.0], [(50, 50)])
    through = (robot("b"), [0.0, 10.0, 30.0], [(30, 50), (30, 50), (70, 50)])
    kinds = [v.kind for v in check_plan(plan_of(left, through, period_s=None)).violations]
    assert kinds == ["bodies touch"]

"""Zones that name the sensors that count: what the check credits, against sampling by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import check_plan, worst_gaps_s
from rota.errors import MissionError
from rota.model.fleet import Robot
from rota.model.mission import Demand, DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan, Trajectory

HOT = Zone(name="hot", period_s=30, shape=MultiPolygon([box(40, 0, 50, 10)]), sensors=("thermal",))
YARD = Mission(
    name="yard",
    area=MultiPolygon([box(0, 0, 100, 10)]),
    zones=(HOT,),
    period_s=25,
    fleet=Fleet(
        speed_m_s=10,
        sensor=DiscSensor(radius_m=11),
        robots=[Robot(name="plain"), Robot(name="warm", sensor=DiscSensor(radius_m=11, name="thermal"))],
    ),
)


def to_and_fro(robot: str, low_m: float, high_m: float) -> Trajectory:
    once_s = (high_m - low_m) / 10
    places = np.array([[low_m, 5.0], [high_m, 5.0], [low_m, 5.0]])
    return Trajectory(robot=robot, loop_start_s=0.0, times_s=np.array([0.0, once_s, 2 * once_s]), positions_m=places)


def plan_of(warm: Trajectory, zone: Zone = HOT) -> Plan:
    return Plan(mission=replace(YARD, zones=(zone,)), trajectories=(to_and_fro("plain", 0, 100), warm))


@pytest.mark.parametrize("demand", ["every_point", "visit"])
def test_only_robots_with_a_named_sensor_count(demand: Demand) -> None:
    zone = replace(HOT, demand=demand)
    near, far = to_and_fro("warm", 38, 52), to_and_fro("warm", 80, 95)
    assert check_plan(plan_of(near, zone)).verdict == "met"
    report = check_plan(plan_of(far, zone))
    (late,) = [told for told in report.demands if told.outcome != "met"]
    assert late.name == "hot"
    assert late.worst_gap_at_least_s == np.inf
    assert check_plan(plan_of(far, replace(zone, sensors=()))).verdict == "met"  # the plain one comes by every 20 s


def test_worst_gaps_count_what_the_zone_counts() -> None:
    plan, points_m = plan_of(to_and_fro("warm", 10, 90)), np.array([[45.0, 1.0], [20.0, 1.0]])
    times_s = np.arange(0.0, 16.0, 0.001)
    away_m = np.hypot(*(plan["warm"].at(times_s) - points_m[0]).T)
    seen_s = times_s[away_m <= 11]
    anybody = plan_of(plan["warm"], replace(HOT, sensors=()))
    thermal_s, anybody_s = (float(worst_gaps_s(each, points_m)[0]) for each in (plan, anybody))
    assert thermal_s == pytest.approx(np.diff(np.append(seen_s, seen_s[0] + 16)).max(), abs=0.003)
    assert anybody_s < thermal_s


def test_ground_that_nobody_left_counts_for_is_unseen_and_not_left_out() -> None:
    usual = DiscSensor(radius_m=11, name="thermal")
    fleet = replace(YARD.fleet, sensor=usual, robots=[Robot(name="plain", sensor=DiscSensor(radius_m=11))])
    plan = Plan(mission=replace(YARD, fleet=fleet), trajectories=(to_and_fro("plain", 0, 100),))
    report = check_plan(plan)
    assert report.verdict == "violated"
    hot = next(one for one in report.demands if one.name == "hot")
    assert (hot.outcome, hot.unseen_area_m2, hot.excluded_area_m2) == ("violated", pytest.approx(100), 0)


def test_zones_that_name_sensors_which_nobody_has_or_that_overlap_are_refused() -> None:
    with pytest.raises(MissionError, match=r"zones\[0\].sensors: x-ray: no robot has such a sensor; there are thermal"):
        replace(YARD, zones=(replace(HOT, sensors=("x-ray",)),))
    other = Zone(name="all", period_s=60, shape=MultiPolygon([box(45, 0, 60, 10)]))
    with pytest.raises(MissionError, match=r"zones\[1\].sensors: zone all overlaps zone hot"):
        replace(YARD, zones=(HOT, other))

"""Robots that keep to lanes, and those that do not: each fault at its place, and random walks by samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, box
from tests.seeds import seeds

from rota.check import check_plan
from rota.check.report import Report
from rota.model.mission import DiscSensor, Fleet, Lane, Mission, Zone
from rota.model.plan import Plan, Trajectory

# a triangle of which one side is one-way and another is slow, and a lane that crosses it without a corner
AROUND = (
    Lane(line_m=((0, 0), (10, 0)), one_way=True),
    Lane(line_m=((10, 0), (10, 6), (0, 8)), length_m=40.0),
    Lane(line_m=((0, 8), (0, 0)), least_s=20.0),
    Lane(line_m=((5, -2), (5, 10))),
)


def plan_along(*points: tuple[float, float, float], lanes: tuple[Lane, ...] = AROUND, loop_start_s: float = 0) -> Plan:
    """A robot of 1 m/s at (time, x, y)."""
    told = np.array(points, dtype=float)
    zone = Zone(name="z", period_s=1e6, demand="visit", shape=MultiPolygon([box(-1, -1, 11, 11)]))
    mission = Mission(
        name="lanes", area=MultiPolygon([box(-20, -20, 20, 20)]), zones=(zone,), lanes=lanes,
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1)),
    )  # fmt: skip
    trajectory = Trajectory(robot="r", times_s=told[:, 0], positions_m=told[:, 1:], loop_start_s=loop_start_s)
    return Plan(mission=mission, trajectories=(trajectory,), seed=0)


def faults(report: Report) -> list[tuple[str, tuple[float, float] | None]]:
    return [(found.kind, found.place_m) for found in report.violations]


SLOW_S = 40.0  # of the second lane, drawn 16.198 m long
UP_S = SLOW_S * 6 / (6 + float(np.hypot(10, 2)))
ROUND = ((0, 0, 0), (10, 10, 0), (10 + UP_S, 10, 6), (10 + SLOW_S, 0, 8), (30 + SLOW_S, 0, 0))


def test_a_round_along_all_lanes_is_met() -> None:
    assert check_plan(plan_along(*ROUND)).verdict == "met"


def test_a_robot_may_stand_anywhere_on_a_lane_and_turn_round_on_one_that_runs_both_ways() -> None:
    assert check_plan(plan_along((0, 10, 2), (9, 10, 2))).violations[:1] == ()
    back = ((0, 5, 9), (4, 5, 5), (8, 5, 9))
    assert check_plan(plan_along(*back)).verdict == "met"


@pytest.mark.parametrize(
    ("points", "kind", "place"),
    [
        (((0, 1, 0), (1, 1, 1), (2, 1, 0)), "off the lanes", (1, 0)),
        (((0, 0, 0), (14, 10, 6), (28, 0, 0)), "off the lanes", (0, 0)),
        (((0, 0, 1), (20, 0, 0), (30, 10, 0), (40, 0, 0), (60, 0, 1)), "against a one-way lane", (10, 0)),
        (((0, 0, 1), (7, 0, 8), (14, 0, 1)), "faster than its lane", (0, 1)),
        (((0, 10, 0), (6, 10, 6), (40, 10, 0)), "faster than its lane", (10, 0)),
        (((0, 1, 0), (4, 5, 0), (8, 5, 4)), "leaves a lane between its ends", (5, 0)),
    ],
)
def test_a_leg_that_no_lane_allows_is_told_at_its_place(
    points: tuple[tuple[float, float, float], ...], kind: str, place: tuple[float, float]
) -> None:
    report = check_plan(plan_along(*points, loop_start_s=points[-1][0]))
    assert report.verdict == "violated"
    assert (kind, place) in faults(report)


@pytest.mark.parametrize("leg_s", [1e-5, 1e-4, 1e-2])
@pytest.mark.parametrize(("speed_m_s", "kinds"), [(0.4, set()), (0.41, {"faster than its lane"})])
def test_what_short_legs_may_be_too_fast_along_a_lane_does_not_add_up(
    leg_s: float, speed_m_s: float, kinds: set[str]
) -> None:
    """Two hundredths of a second along a lane for 0.4 m/s: 0.2 mm too far."""
    times_s = np.arange(0, 0.02 + leg_s / 2, leg_s)
    rows = [(0.0, 0.0, 4.0), *((1 + time_s, 0.0, 4.0 - speed_m_s * time_s) for time_s in times_s)]
    found = check_plan(plan_along(*rows, loop_start_s=rows[-1][0])).violations
    assert {one.kind for one in found} - {"gap"} == kinds


def test_where_the_loop_closes_a_robot_may_not_change_lanes_either() -> None:
    """It begins on the crossing lane and ends on the first one, at the point where they cross."""
    points = ((0.0, 5.0, 0.0), (5.0, 5.0, 5.0), (10.0, 5.0, 0.0))
    assert check_plan(plan_along(*points)).verdict == "met"
    run_in = ((0.0, 4.0, 0.0), (1.0, 5.0, 0.0), (6.0, 5.0, 5.0), (11.0, 5.0, 0.0))
    report = check_plan(plan_along(*run_in, loop_start_s=1.0))
    assert [kind for kind, _ in faults(report)] == ["leaves a lane between its ends"]


@pytest.mark.parametrize("seed", seeds(40, at_once=10))
def test_random_walks_are_judged_as_by_samples(seed: int) -> None:
    """A random walk over the corners of lanes, now and then straight to another corner instead."""
    random = np.random.default_rng(seed)
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 6.0), (0.0, 8.0)]
    lanes = tuple(replace(lane, length_m=None, least_s=None) for lane in AROUND[:3])
    at, points = 0, [(0.0, *corners[0])]
    for _ in range(6):
        to = int(random.choice([k for k in range(4) if k != at]))
        if random.random() < 0.8:
            to = (at + 1) % 4
        way_m = float(np.hypot(*np.subtract(corners[to], corners[at])))
        points.append((points[-1][0] + way_m * (1.0 + random.random()), *corners[to]))
        at = to
    points.append((points[-1][0] + 30.0, *corners[at]))
    plan = plan_along(*points, lanes=lanes, loop_start_s=points[-1][0])
    assert (check_plan(plan).verdict == "met") == keeps_by_samples(plan.trajectories[0], lanes)


def keeps_by_samples(trajectory: Trajectory, lanes: tuple[Lane, ...]) -> bool:
    """Whether a robot that is looked at every 10 ms is always on a lane, and never against the first."""
    times_s = np.arange(0.0, float(trajectory.times_s[-1]), 0.01)
    places = trajectory.at(times_s)
    union = shapely.union_all([LineString(lane.line_m) for lane in lanes])
    on = shapely.distance(union, shapely.points(places)) < 1e-6
    east = np.diff(places[:, 0])
    on_first = shapely.distance(LineString(lanes[0].line_m), shapely.points(places)) < 1e-6
    return bool(on.all() and not (east[on_first[:-1] & on_first[1:]] < -1e-9).any())

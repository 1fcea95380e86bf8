"""The time of turns apart from that of waits, and formats whose vehicles turn by themselves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.files.two_robots import two_robots

from rota.files.executed.plan_as_driven import plan_as_driven
from rota.files.nav2_waypoints import LOOP, nav2_texts
from rota.model.plan import Plan, Trajectory
from rota.routes.route import RouteStop
from rota.routes.turning import turning, with_turning

RATE = math.pi / 4


def stop(x: float, y: float, hold_s: float = 5.0) -> RouteStop:
    return RouteStop(place_m=(x, y, 0.0), speed_m_s=1.0, hold_s=hold_s)


def test_turns_are_those_of_the_bends() -> None:
    once = (stop(0, 0), stop(1, 0), stop(1, 1))
    every_round = (stop(0, 1), stop(1, 1))
    # right angles along the approach; half a turn at either end of the way to and fro
    first, around = with_turning(once, every_round, RATE)
    assert [each.turn_s for each in first] == pytest.approx([0, 2, 2])
    assert [each.turn_s for each in around] == pytest.approx([4, 4])
    assert [each.wait_s for each in around] == pytest.approx([1, 1])
    assert with_turning(once, every_round, None) == (once, every_round)


def test_a_robot_that_stays_or_does_not_move_turns_nowhere() -> None:
    assert with_turning((stop(0, 0),), (), RATE) == ((stop(0, 0),), ())
    first, around = with_turning((stop(0, 0), stop(1, 0), stop(1, 1)), (), RATE)
    assert [each.turn_s for each in first] == pytest.approx([0, 2, 0])
    assert around == ()
    first, _ = with_turning((stop(0, 0), stop(0, 0), stop(1, 1)), (), RATE)
    assert [each.turn_s for each in first] == [0, 0, 0]


def test_no_more_is_turned_than_held_and_what_rounding_leaves_is_no_wait() -> None:
    for hold_s in (1.0, 2.0 - 1e-9, 2.0 + 1e-9):
        (_, at, _), _ = with_turning((stop(0, 0), stop(1, 0, hold_s), stop(1, 1)), (), RATE)
        assert at.wait_s == 0.0
    (_, at, _), _ = turning((stop(0, 0), stop(1, 0, 0.5), stop(1, 1)), (), RATE)
    assert at.hold_s == pytest.approx(2.5)


def turning_plan() -> Plan:
    """A robot that turns by right angles in 2 s, and waits for 1.5 s more at one corner."""
    plan = two_robots(robots=("a", "b"))
    way = Trajectory(
        robot="a",
        times_s=[0, 10, 13.5, 23.5, 25.5, 35.5, 37.5, 47.5, 49.5],
        positions_m=[[0, 0], [50, 0], [50, 0], [50, 50], [50, 50], [0, 50], [0, 50], [0, 0], [0, 0]],
    )
    fleet = plan.mission.fleet
    robots = tuple(replace(robot, turn_rate_rad_s=RATE) for robot in fleet.robots or ())
    mission = replace(plan.mission, fleet=replace(fleet, turn_rate_rad_s=RATE, robots=robots))
    return replace(plan, mission=mission, trajectories=(way, plan.trajectories[1]))


@pytest.mark.parametrize("name", ["nav2", "vda5050"])
def test_vehicles_that_turn_by_themselves_drive_the_plan_as_it_is(name: str) -> None:
    plan = turning_plan()
    driven = plan_as_driven(plan, name)
    for way, planned in zip(driven, plan, strict=True):
        assert way.loop_duration_s == pytest.approx(planned.loop_duration_s, abs=1e-9)
        # from the second round on: nothing is known of how a robot stands at its start
        moments_s = way.loop_start_s + np.linspace(0, 2, 50) * max(planned.loop_duration_s, 1.0)
        assert way.at(moments_s) == pytest.approx(planned.at(moments_s), abs=1e-6)


def test_nav2_waits_hold_no_turns() -> None:
    plan = turning_plan()
    text = nav2_texts(plan.trajectories[0], plan.mission.fleet.robot("a"))[LOOP]
    waits = [float(line.split(": ")[1]) for line in text.splitlines() if "wait_s" in line]
    assert waits == pytest.approx([1.5, 0, 0, 0])

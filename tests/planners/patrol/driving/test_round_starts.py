"""Where rounds begin: which rows cut a leg in two, and robots with a limited jerk that charge, or join from starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests import short_searches  # noqa: F401

from rota import DiscSensor, Fleet, Mission, NoPlanFound, PatrolSettings, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.driving.round_starts import begins_amid_a_leg, start_without_cut, steady_legs, without_cuts
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine, start_at

JERKY = MotionLimits(acceleration_m_s2=0.5, corner_m=0.5, jerk_m_s3=1)


@pytest.fixture
def square() -> TimedLine:
    """A round of 10 m x 10 m, its corners cut."""
    robot = Fleet(speed_m_s=1, motion=JERKY, sensor=DiscSensor(radius_m=2)).equal_robot("robot-1")
    return driving_with_mass(robot).timed(np.array([[0.0, 0.0], [10, 0], [10, 10], [0, 10]]))


def longest_leg(line: TimedLine) -> int:
    return int(np.argmax(np.diff(line.times_s)))


def test_rounds_begun_amid_a_leg_beside_a_vertex_of_a_curve_do_and_those_begun_at_an_end_of_one_do_not(
    square: TimedLine,
) -> None:
    velocity_m_s = np.diff(square.places_m, axis=0) / np.diff(square.times_s)[:, None]
    level = square.accelerations_m_s2 == 0
    jumps = np.hypot(*(velocity_m_s - np.roll(velocity_m_s, 1, axis=0)).T) > 0.05
    halves = np.flatnonzero(level & (jumps != np.roll(jumps, -1)))  # of phases about vertices
    assert len(halves) == 24
    for leg in halves:
        assert begins_amid_a_leg(start_at(square, float(square.times_s[leg : leg + 2].mean())))
    for leg in np.flatnonzero(steady_legs(square)):
        for row in (leg, leg + 1):
            assert not begins_amid_a_leg(start_at(square, float(square.times_s[row])))


def test_a_robot_that_stays_begins_no_leg() -> None:
    assert not begins_amid_a_leg(TimedLine(np.zeros(1), np.zeros((1, 2)), np.zeros(0)))


def test_only_rows_at_the_moments_go_and_only_where_all_goes_on(square: TimedLine) -> None:
    leg = longest_leg(square)
    middle_s = float(square.times_s[leg : leg + 2].mean())
    begun = start_at(square, middle_s)
    again = start_at(begun, float(begun.times_s[5]))
    start_s = begun.duration_s - float(begun.times_s[5])
    whole = without_cuts(again, np.array([start_s]))
    assert len(whole.times_s) == len(again.times_s) - 1
    moments_s = np.linspace(0, again.duration_s, 200)
    assert whole.at(moments_s) == pytest.approx(again.at(moments_s), abs=1e-9)
    # at a vertex of a curve the velocity jumps
    jumps = np.flatnonzero(~steady_legs(again))
    assert len(without_cuts(again, again.times_s[jumps[:1]]).times_s) == len(again.times_s)
    assert len(without_cuts(again, np.zeros(0)).times_s) == len(again.times_s)


def test_steady_legs_are_the_straight_ones_between_curves(square: TimedLine) -> None:
    lasts_s = np.diff(square.times_s)
    steady = steady_legs(square)
    assert steady[longest_leg(square)]
    assert steady.sum() == 4
    assert lasts_s[steady].min() > lasts_s[~steady].max()


@pytest.mark.parametrize(
    ("area", "speed_m_s", "motion", "battery_s", "period_s", "reach_m"),
    [
        pytest.param((20, 8), 0.3, JERKY, (1600, 1600), 300, 2, id="loops begin where curves end"),
        pytest.param(
            (30, 12), 0.5, MotionLimits(acceleration_m_s2=0.5, corner_m=0.5, jerk_m_s3=0.5), (900, 900), 300, 3,
            id="curves have rows past which all goes on",
        ),
        pytest.param(
            (15, 20), 0.5, MotionLimits(acceleration_m_s2=0.3, corner_m=0.3, jerk_m_s3=0.3), (300, 150), 200, 3,
            id="robots change where they drive straight on",
        ),
    ],
)  # fmt: skip
def test_robots_with_a_limited_jerk_charge(
    area: tuple[float, float],
    speed_m_s: float,
    motion: MotionLimits,
    battery_s: tuple[float, float],
    period_s: float,
    reach_m: float,
) -> None:
    mission = Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, *area)]),
        period_s=period_s,
        fleet=Fleet(
            speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=reach_m), motion=motion,
            battery=BatteryLimits(endurance_s=battery_s[0], recharge_s=battery_s[1]),
        ),
        chargers=(Charger(name="pad", at=(area[0] / 2, 2), places=4),),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    plan = make_plan(mission)
    assert check_plan(plan).verdict == "met"
    assert len(plan) == 2


def test_robots_of_a_team_with_a_limited_jerk_join_their_loops_from_starts() -> None:
    fleet = Fleet(
        speed_m_s=0.3,
        sensor=DiscSensor(radius_m=2),
        motion=MotionLimits(acceleration_m_s2=0.3, corner_m=0.3, jerk_m_s3=0.15),
    )
    starts = ((3, 2), (14, 5), (1, 1))
    robots = tuple(replace(fleet.equal_robot(f"robot-{k + 1}"), start=start) for k, start in enumerate(starts))
    mission = Mission(
        name="yard", area=MultiPolygon([box(0, 0, 20, 8)]), period_s=300, fleet=replace(fleet, robots=robots),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    assert check_plan(make_plan(mission)).verdict == "met"


def test_a_round_begun_later_keeps_no_row_at_which_it_was_cut(square: TimedLine) -> None:
    leg = longest_leg(square)
    amid_s = float(square.times_s[leg + 3 : leg + 5].mean())  # of a curve's leg
    begun = start_at(square, amid_s)
    assert begins_amid_a_leg(begun)
    again = start_without_cut(begun, float(begun.times_s[4]))
    assert len(again.times_s) == len(square.times_s)
    assert again.duration_s == square.duration_s
    assert start_without_cut(square, 0.0) is square


def test_how_far_it_is_to_the_charger_is_told_of_places_to_which_a_way_was_found() -> None:
    mission = Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 25, 12)]),
        period_s=34,
        fleet=Fleet(
            speed_m_s=2, sensor=DiscSensor(radius_m=2),
            motion=MotionLimits(acceleration_m_s2=1.2, corner_m=0.3, jerk_m_s3=0.6),
            battery=BatteryLimits(endurance_s=51, recharge_s=76),
        ),
        chargers=(Charger(name="pad", at=(12.5, 2), places=9),),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    with pytest.raises(NoPlanFound, match=r"a robot has 51 s to use; from charger 'pad' to \S+ \S+ and back it takes"):
        make_plan(mission)

"""What is said of plans for robots that change speed at once, and of whom not."""

from __future__ import annotations

from dataclasses import replace

from tests.vehicles.small_plans import square

from rota import BounceSettings
from rota.command.without_mass import without_mass
from rota.model.mission import Zone
from rota.model.motion_limits import AT_ONCE, MotionLimits
from rota.model.plan import Plan

HEAVY = MotionLimits(acceleration_m_s2=3)


def with_motion(plan: Plan, *limits: MotionLimits) -> Plan:
    """The plan's one route for as many robots, each with its limits."""
    (way,), fleet = plan.trajectories, plan.mission.fleet
    robots = [replace(fleet.equal_robot(f"r{k}"), motion=each) for k, each in enumerate(limits)]
    ways = tuple(replace(way, robot=robot.name) for robot in robots)
    return replace(plan, mission=replace(plan.mission, fleet=replace(fleet, robots=tuple(robots))), trajectories=ways)


def test_robots_without_limits_are_told_with_what_a_copter_takes() -> None:
    told = without_mass(square(100))
    assert told is not None
    assert told.startswith("for robots that change speed at once; an ArduCopter by default parameters takes up to 1.")
    assert told.endswith(" times as long (--executed waypoints --vehicle arducopter)")
    placeless = replace(square(100), mission=replace(square(100).mission, origin=None))
    assert without_mass(placeless) == told.removesuffix(" (--executed waypoints --vehicle arducopter)")
    assert without_mass(placeless, is_flown=True) == told


def test_robots_with_limits_are_not_told_of_and_some_of_many_by_name() -> None:
    assert without_mass(with_motion(square(100), HEAVY, HEAVY)) is None
    some = without_mass(with_motion(square(100), HEAVY, AT_ONCE, AT_ONCE))
    assert some is not None
    assert some.startswith("for robots that change speed at once (r1, r2); an ArduCopter")


def test_a_vehicle_without_a_known_acceleration_is_no_copter() -> None:
    assert without_mass(with_motion(square(100), MotionLimits(vehicle="dji"))) == "for robots that change speed at once"


def test_who_stays_is_not_told_of_and_who_bounces_without_the_copter() -> None:
    plan = square(100)
    (way,) = plan.trajectories
    still = replace(way, loop_start_s=float(way.times_s[-1]))
    assert without_mass(replace(plan, trajectories=(still,))) is None
    zone = Zone(name="all", shape=plan.mission.area, period_s=500, demand="visit")
    bouncing = replace(plan.mission, period_s=None, zones=(zone,), planning=BounceSettings(cell_m=1.0))
    assert without_mass(replace(plan, mission=bouncing)) == "for robots that change speed at once"

"""From the mission asked to the one that is searched: with a reserve in periods and reach, and without starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.mission import DiscSensor, Mission, Robot, Sensor, SquareSensor
from rota.plan import Plan
from rota.planners.patrol.approach.from_starts import led_from_starts
from rota.planners.patrol.context import Judge
from rota.planners.patrol.tours import plan_patrol as plan_tours


def plan_patrol(
    mission: Mission,
    *,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
) -> Plan:
    """A plan for the mission whose loops pass the judge with the reserve that its settings ask for.

    Robots with starts reach their loops from there. The lower bound is that of the mission as it is asked. Raises
    NoPlanFound, with the best plan found for this mission, when there is none.
    """
    tight = with_reserve(mission)
    try:
        plan = plan_tours(
            without_starts(tight), asked=mission, seed=seed, judge=judge, progress=progress, should_stop=should_stop
        )
    except NoPlanFound as failure:
        raise NoPlanFound(str(failure), best=as_asked(failure.best, mission, judge)) from failure
    if not mission.has_starts:
        return replace(plan, mission=mission)
    progress(0.95, "leading the robots from their starts")
    try:
        led = led_from_starts(plan, tight, judge)
    except NoPlanFound as failure:
        raise NoPlanFound(str(failure), best=replace(plan, mission=mission)) from failure
    if judge(led).verdict != "met":
        reason = "with the ways from the starts the plan does not pass the check"
        raise NoPlanFound(reason, best=replace(led, mission=mission))
    return replace(led, mission=mission)


def as_asked(best: object | None, mission: Mission, judge: Judge) -> Plan | None:
    """The best plan found for the searched mission as one for the mission asked, led from its starts if it can be."""
    if not isinstance(best, Plan):
        return None
    try:
        led = led_from_starts(best, mission, judge) if mission.has_starts else best
    except NoPlanFound:
        led = best
    return replace(led, mission=mission)


def without_starts(mission: Mission) -> Mission:
    """The same mission, its robots anywhere to begin with."""
    robots = mission.fleet.robots
    anywhere = None if robots is None else tuple(replace(robot, start=None) for robot in robots)
    return replace(mission, fleet=replace(mission.fleet, robots=anywhere, start=None))


def with_reserve(mission: Mission) -> Mission:
    """The mission with periods shorter by ``period_margin`` and sensors by ``range_margin_m``; itself without both."""
    share, margin_m = 1 - mission.planning.period_margin, mission.planning.range_margin_m
    if share == 1 and margin_m == 0:
        return mission

    def shorter(period_s: float | None) -> float | None:
        return None if period_s is None else share * period_s

    def near_sighted(robot: Robot) -> Robot:
        return replace(robot, sensor=shorter_sensor(robot.sensor, margin_m))

    fleet = mission.fleet
    robots = None if fleet.robots is None else tuple(near_sighted(robot) for robot in fleet.robots)
    return replace(
        mission,
        period_s=shorter(mission.period_s),
        zones=tuple(replace(zone, period_s=shorter(zone.period_s)) for zone in mission.zones),
        fleet=replace(fleet, robots=robots, sensor=shorter_sensor(fleet.sensor, margin_m)),
        planning=replace(mission.planning, period_margin=0.0, range_margin_m=0.0),
    )


def shorter_sensor(sensor: Sensor, margin_m: float) -> Sensor:
    """The sensor, seeing so much less far in every direction."""
    if isinstance(sensor, DiscSensor):
        return DiscSensor(radius_m=sensor.radius_m - margin_m)
    return SquareSensor(side_m=sensor.side_m - 2 * margin_m)

"""From the mission asked to the one that is searched: with a reserve in periods and reach, and without starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.mission import DiscSensor, Mission, Robot, Sensor, SquareSensor
from rota.plan import Plan
from rota.planners.patrol.approach.from_starts import led_from_starts, require_room
from rota.planners.patrol.context import Judge
from rota.planners.patrol.fixed_fleet import worst_reached
from rota.planners.patrol.tours import plan_patrol as plan_tours
from rota.search_state import Watch


def plan_patrol(
    mission: Mission,
    *,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: Watch | None = None,
) -> Plan:
    """A plan for the mission whose loops pass the judge with the reserve that its settings ask for.

    Robots with starts reach their loops from there. The lower bound is that of the mission as it is asked. Raises
    NoPlanFound, with the best plan found for this mission, when there is none; also when bodies touch on the way from
    the starts, and when the reserve of range hides ground that only the full reach sees.
    """
    tight = with_reserve(mission)
    require_room(mission)
    try:
        plan = plan_tours(
            without_starts(tight), asked=mission, seed=seed, judge=judge, progress=progress,
            should_stop=should_stop, watch=watch,
        )  # fmt: skip
    except NoPlanFound as failure:
        raise NoPlanFound(str(failure), best=led_as_asked(failure.best, mission)) from failure
    if mission.has_starts:
        progress(0.95, "leading the robots from their starts")
        try:
            plan = led_from_starts(plan, tight, judge)
        except NoPlanFound as failure:
            raise NoPlanFound(str(failure), best=as_asked(failure.best, mission)) from failure
    final = plan if plan.mission is mission else replace(plan, mission=mission)  # the judge knows the plan judged last
    if mission.patrol.range_margin_m > 0 and (verdict := judge(final)).verdict != "met":
        raise NoPlanFound(
            f"patrol.range_margin_m: {mission.patrol.range_margin_m:.6g} hides ground that only sensors of full reach"
            f" see, and the plan misses it: {worst_reached(verdict)}; give less",
            best=final,
        )
    return final


def as_asked(best: object | None, mission: Mission) -> Plan | None:
    """The best plan found for the searched mission as one for the mission asked."""
    return replace(best, mission=mission) if isinstance(best, Plan) else None


def led_as_asked(best: object | None, mission: Mission) -> Plan | None:
    """The best plan found for the searched mission, led from the asked mission's starts as far as that can be."""
    if not isinstance(best, Plan) or not mission.has_starts:
        return as_asked(best, mission)
    try:
        return led_from_starts(best, mission, judge=None)
    except NoPlanFound as failure:
        return as_asked(failure.best, mission)


def without_starts(mission: Mission) -> Mission:
    """The same mission, its robots anywhere to begin with; itself when they are."""
    if not mission.has_starts:
        return mission
    robots = mission.fleet.robots
    anywhere = None if robots is None else tuple(replace(robot, start=None) for robot in robots)
    return replace(mission, fleet=replace(mission.fleet, robots=anywhere, start=None))


def with_reserve(mission: Mission) -> Mission:
    """The mission with periods shorter by ``period_margin`` and sensors by ``range_margin_m``; itself without both."""
    share, margin_m = 1 - mission.patrol.period_margin, mission.patrol.range_margin_m
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
        planning=replace(mission.patrol, period_margin=0.0, range_margin_m=0.0),
    )


def shorter_sensor(sensor: Sensor, margin_m: float) -> Sensor:
    """The sensor, seeing so much less far in every direction."""
    if isinstance(sensor, DiscSensor):
        return DiscSensor(radius_m=sensor.radius_m - margin_m)
    return SquareSensor(side_m=sensor.side_m - 2 * margin_m)

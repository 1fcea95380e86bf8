"""The mission that is searched: with a reserve in periods and reach, and without starts."""

from __future__ import annotations

from dataclasses import replace

from rota.model.mission import DiscSensor, Mission, Robot, Sensor
from rota.planners.patrol.planner_settings import PatrolSettings


def with_reserve(mission: Mission) -> Mission:
    """The mission with periods shorter by ``period_margin`` and sensors by ``range_margin_m``; itself without both."""
    share, margin_m = 1 - PatrolSettings.of(mission).period_margin, PatrolSettings.of(mission).range_margin_m
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
        planning=replace(PatrolSettings.of(mission), period_margin=0.0, range_margin_m=0.0),
    )


def shorter_sensor(sensor: Sensor, margin_m: float) -> Sensor:
    """The sensor, with ``margin_m`` less reach in every direction."""
    if isinstance(sensor, DiscSensor):
        return replace(sensor, radius_m=sensor.radius_m - margin_m)
    return replace(sensor, side_m=sensor.side_m - 2 * margin_m)

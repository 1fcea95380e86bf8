"""The robot that every bound is proved for: at least as good as each of the fleet in all that counts."""

from __future__ import annotations

import math

from rota.model.mission import DiscSensor, Fleet, Robot


def strongest_robot(fleet: Fleet) -> Robot:
    """A robot at least as fast and far-sighted as every one of the fleet: a bound for it holds for all."""
    robots = fleet.unlike_robots
    speed_m_s = max(robot.ground_speed_m_s for robot in robots)
    # a square fits in the disc round it, so a mixed fleet is bounded by discs
    if len({type(robot.sensor) for robot in robots}) == 1:
        sensor = max((robot.sensor for robot in robots), key=lambda sensor: sensor.reach_m)
    else:
        sensor = DiscSensor(radius_m=max(robot.sensor.reach_m for robot in robots))
    rates = [robot.turn_rate_rad_s for robot in robots if robot.turn_rate_rad_s is not None]
    turns = len(rates) == len(robots)  # one that turns in no time makes the strongest do so
    alike = Fleet(speed_m_s=speed_m_s, sensor=sensor, turn_rate_rad_s=max(rates) if turns else None)
    return alike.equal_robot("strongest")


def sweep_m2_s(robot: Robot) -> float:
    """New area per second that comes into range of a moving robot at most (2 r V; a square of side a: sqrt(2) a V)."""
    if isinstance(robot.sensor, DiscSensor):
        return 2 * robot.sensor.radius_m * robot.ground_speed_m_s
    return math.sqrt(2) * robot.sensor.side_m * robot.ground_speed_m_s


def footprint_m2(robot: Robot) -> float:
    """Area in m2 that is in range of a robot at rest."""
    if isinstance(robot.sensor, DiscSensor):
        return math.pi * robot.sensor.radius_m**2
    return robot.sensor.side_m**2

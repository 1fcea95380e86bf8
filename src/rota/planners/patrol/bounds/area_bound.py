"""How few robots there could be: a number below which no plan exists, proved."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rota.mission import DiscSensor, Fleet, Robot


def sweep_m2_s(robot: Robot) -> float:
    """New area per second that comes into range of a moving robot at most (2 r V; a square of side a: sqrt(2) a V)."""
    if isinstance(robot.sensor, DiscSensor):
        return 2 * robot.sensor.radius_m * robot.speed_m_s
    return math.sqrt(2) * robot.sensor.side_m * robot.speed_m_s


def footprint_m2(robot: Robot) -> float:
    """Area in range of a robot at rest."""
    if isinstance(robot.sensor, DiscSensor):
        return math.pi * robot.sensor.radius_m**2
    return robot.sensor.side_m**2


def area_rate_bound(areas_m2: Sequence[float], periods_s: Sequence[float], robot: Robot) -> int:
    """Robots at least, since each area must come into range within any window of its period.

    areas_m2, periods_s: (k,) disjoint areas that can be seen, and their periods. Within a window of length 1 / mu a
    robot brings ``sweep / mu`` of new area into range and holds its footprint, hence

        robots >= max over mu in {1 / T_z} of sum_z A_z min(1 / T_z, mu) / (sweep + footprint mu).

    Degenerate: nothing asked gives 0, any area at least 1. Source: the areas' rate argument of Sun et al. 2019 made
    rigorous by the footprint term; "range" rather than "view", for beside a corner a shadow's edge outruns the disc.
    """
    # rounding of the areas must never raise the bound past the truth
    rounded = math.ceil(area_rate(areas_m2, periods_s, robot)[0] - 1e-9)
    return max(rounded, 1 if any(area > 0 for area in areas_m2) else 0)


def area_rate(areas_m2: Sequence[float], periods_s: Sequence[float], robot: Robot) -> tuple[float, float]:
    """The bound of ``area_rate_bound`` before rounding, and the area per second asked (m2/s) that gives it."""
    best = (0.0, 0.0)
    for period_s in periods_s:
        mu = 1 / period_s
        rate = sum(area * min(1 / period, mu) for area, period in zip(areas_m2, periods_s, strict=True))
        best = max(best, (rate / (sweep_m2_s(robot) + footprint_m2(robot) * mu), rate))
    return best


def strongest_robot(fleet: Fleet) -> Robot:
    """A robot at least as good as every one of the fleet: the bound for it holds for all."""
    robots = fleet.robots or (fleet.equal_robot("robot-1"),)
    speed_m_s = max(robot.speed_m_s for robot in robots)
    # a square fits in the disc round it, so a mixed fleet is bounded by discs
    if len({type(robot.sensor) for robot in robots}) == 1:
        sensor = max((robot.sensor for robot in robots), key=lambda sensor: sensor.reach_m)
    else:
        sensor = DiscSensor(radius_m=max(robot.sensor.reach_m for robot in robots))
    return Robot(name="strongest", speed_m_s=speed_m_s, sensor=sensor)

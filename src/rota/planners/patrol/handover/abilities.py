"""What a round asks of robots: as much as those could do that drove it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import shapely

from rota.model.mission import Robot, Zone, inner_reach_m
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.tolerances import TIE


@dataclass(frozen=True, kw_only=True)
class Driver:
    """A robot that drove a round, and the names of sensors that count for each zone on its way where its own did."""

    robot: Robot
    counting: tuple[tuple[str, ...], ...]

    def shortfalls(self, other: Robot) -> int:
        """In how many respects another robot is no match: speed, reach, and whether it counts for all these zones."""
        slower = other.ground_speed_m_s < (1 - TIE) * self.robot.ground_speed_m_s
        nearer = inner_reach_m(other.sensor) < (1 - TIE) * inner_reach_m(self.robot.sensor)
        return slower + nearer + any(other.sensor.name not in names for names in self.counting)


def drivers_of(zones: Sequence[Zone], line: TimedLine, robots: Sequence[Robot]) -> list[Driver]:
    """The robots that drove a round as its drivers, one of each kind."""
    way = shapely.linestrings(line.places_m) if len(line.places_m) > 1 else shapely.points(line.places_m[0])
    found: dict[tuple[object, ...], Driver] = {}
    for robot in robots:
        near = [zone for zone in zones if zone.shape.distance(way) <= robot.sensor.reach_m]
        counting = tuple(zone.sensors for zone in near if robot.sensor.name in zone.sensors)
        found[robot.ground_speed_m_s, robot.sensor] = Driver(robot=robot, counting=counting)
    return list(found.values())

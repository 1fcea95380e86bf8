"""Who looks, from where and past what: what every question about sight needs to know."""

from __future__ import annotations

from typing import NamedTuple

from shapely import MultiPolygon

from rota.model.arrays import Floats
from rota.model.mission import Robot, SquareSensor, inner_reach_m


class Sight(NamedTuple):
    """A robot in the space where its centre may be, and the walls (k, 4), in metres, that block its sight.

    range_margin_m: by how much less than its reach the robot's sensor is taken to see.
    """

    space: MultiPolygon
    walls: Floats
    robot: Robot
    range_margin_m: float


def sensor_arguments(robot: Robot, range_margin_m: float) -> tuple[float, int]:
    """The sensor as kernels take it: its inner reach less the margin, in metres, and 1 for a square, 0 for a disc."""
    return inner_reach_m(robot.sensor) - range_margin_m, int(isinstance(robot.sensor, SquareSensor))

"""How far the robots of a mission sense, and between which altitudes they fly."""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Flags, Floats
from rota.model.mission import DiscSensor, Mission, SquareSensor, inner_reach_m
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.space_kernels import Bands


def bands_of(mission: Mission) -> Bands:
    """The band of each robot of a mission with altitudes: they are dealt out in turn, the lowest band first."""
    ends = np.array(SwarmSettings.of(mission).altitudes_m, np.float64).reshape(-1, 2)
    low, high = ends[np.arange(len(mission.fleet.robots or ())) % len(ends)].T
    return Bands(np.ascontiguousarray(low), np.ascontiguousarray(high))


def sensors_of(mission: Mission) -> Floats:
    """(n,): radius of each robot's footprint, at the ceiling where it grows with height; a square's half side."""
    sensors = [robot.sensor for robot in mission.fleet.robots or ()]
    in_space = SwarmSettings.of(mission).altitudes_m is not None
    ceilings_m = bands_of(mission).high_m if in_space else np.zeros(len(sensors))
    return np.array(
        [
            sensor.radius_at_m(ceiling_m) if isinstance(sensor, DiscSensor) else inner_reach_m(sensor)
            for sensor, ceiling_m in zip(sensors, ceilings_m.tolist(), strict=True)
        ]
    )


def squares_of(mission: Mission) -> Flags:
    """(n,): which robots have square footprints."""
    return np.array([isinstance(robot.sensor, SquareSensor) for robot in mission.fleet.robots or ()], np.bool_)

"""A plan by hand of robots with mass, on the ground of ``two_robots``: one cuts corners and waits, one stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.driven_with_mass import rounded
from tests.files.two_robots import two_robots

from rota.model.mission import Robot
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Plan

CORNERS = np.array([[0.0, 0.0], [100.0, 20.0], [90.0, 80.0], [0.0, 50.0]])
ONCE = np.array([[-60.0, -60.0], [-60.0, 0.0], [0.0, 0.0]])
MOTION = MotionLimits(acceleration_m_s2=2.5, corner_m=2, wind_m_s=1)


def with_mass() -> Plan:
    """Speeds up and brakes, cuts two corners, stops at the others and waits at one; comes from elsewhere first."""
    flat = two_robots(robots=("a", "b"))
    holds_s = np.array([4.0, 0, 0, 3.0])
    moving = rounded(CORNERS, np.array([0.0, 4.0, 3.0, 0.0]), holds_s, top=8, a=2.5, once=ONCE)
    sensor = flat.mission.fleet.sensor
    robots = tuple(Robot(name=name, speed_m_s=8, sensor=sensor, motion=MOTION) for name in "ab")
    mission = replace(flat.mission, fleet=replace(flat.mission.fleet, robots=robots, motion=MOTION))
    return Plan(mission=mission, trajectories=(moving, flat.trajectories[1]))

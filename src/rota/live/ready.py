"""All compiled loops of a watch made ready: an alarm cannot wait for a minute until the first of them is compiled."""

from __future__ import annotations

import numpy as np
from shapely import box

from rota.live.events import Heard, Tick
from rota.live.settings import WatchSettings
from rota.live.watch import Watch
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory


def make_ready() -> None:
    """Watch a robot for some seconds that drives past an obstacle, falls silent and lets its zones lapse."""
    sensor = DiscSensor(radius_m=3.0)
    mission = Mission(
        name="ready",
        area=box(0, 0, 10, 4),
        obstacles=(Obstacle(shape=box(4, 1, 6, 2)),),
        zones=(Zone(name="gate", shape=box(8, 2, 10, 4), period_s=4.0, demand="visit"),),
        period_s=4.0,
        fleet=Fleet(
            speed_m_s=5.0, sensor=sensor, robots=tuple(Robot(name=k, speed_m_s=5.0, sensor=sensor) for k in "ab")
        ),
    )
    ways = tuple(
        Trajectory(robot=name, times_s=np.array([0.0, 1.6, 3.2]), positions_m=np.array([[1, y], [9, y], [1, y]]))
        for name, y in (("a", 3.0), ("b", 0.5))
    )
    watch = Watch(Plan(mission=mission, trajectories=ways), WatchSettings(silent_s=0.5, forecast_s=0.1))
    watch.take(Tick(0.0))
    for k in range(1, 13):
        for robot, y in ((0, 3.0), (1, 0.5))[: 2 if k < 5 else 1]:
            watch.take(Heard(0.2 * k, robot, 0.2 * k, 1.0 + (k if k < 8 else 0), y, 0.0, 1.0, "running"))
        watch.take(Tick(0.2 * k))

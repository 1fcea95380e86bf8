"""Robots on a ring, so that what a change comes to is known."""

from __future__ import annotations

import numpy as np
import shapely

from rota import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, Plan, Robot, Trajectory

ROUND_S = 40.0  # a ring of 10 m x 10 m at 1 m/s
CORNERS_M = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], float)


def ring_mission(period_s: float, names: tuple[str, ...], **of_fleet: object) -> Mission:
    """A corridor 0.6 m wide round a block."""
    told: dict[str, object] = {"speed_m_s": 1, "sensor": DiscSensor(radius_m=1.2), **of_fleet}
    fleet = Fleet(robots=[Robot(name=name) for name in names], **told)  # type: ignore[arg-type]
    block = Obstacle(shape=shapely.MultiPolygon([shapely.box(0.3, 0.3, 9.7, 9.7)]))
    area = shapely.MultiPolygon([shapely.box(-0.3, -0.3, 10.3, 10.3)])
    settings = PatrolSettings(effort="quick")
    return Mission(name="ring", area=area, obstacles=(block,), period_s=period_s, fleet=fleet, planning=settings)


def on_the_ring(name: str, ahead_m: float) -> Trajectory:
    """A robot that is so far round the ring when the plan begins."""
    stops = np.unique(np.append((np.arange(0, 50, 10.0) - ahead_m) % 40, [0.0, 40.0]))
    places = np.column_stack([np.interp((stops + ahead_m) % 40, np.arange(0, 50, 10.0), axis) for axis in CORNERS_M.T])
    places[-1] = places[0]
    return Trajectory(robot=name, times_s=stops, positions_m=places)


def ring_plan(period_s: float, ahead_m: dict[str, float], **of_fleet: object) -> Plan:
    """Robots that go round the ring in one direction, each so far ahead."""
    robots = tuple(on_the_ring(name, metres) for name, metres in ahead_m.items())
    return Plan(mission=ring_mission(period_s, tuple(ahead_m), **of_fleet), trajectories=robots)

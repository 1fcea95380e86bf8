"""Plans small enough to be right by hand."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import Point, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory


def loop(name: str, corners: list[tuple[float, float]], speed_m_s: float, phase: float = 0.0) -> Trajectory:
    """A closed loop through ``corners``, begun at ``phase`` of its length."""
    ring = np.array([*corners, corners[0]], float)
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T))]
    start, length = phase * along[-1], along[-1]
    marks = np.unique(np.r_[start, along[along > start], along[along < start] + length, start + length])
    places = np.column_stack([np.interp(np.mod(marks, length), along, ring[:, k]) for k in (0, 1)])
    places[-1] = places[0]
    return Trajectory(robot=name, times_s=(marks - start) / speed_m_s, positions_m=places)


@pytest.fixture
def strip() -> Plan:
    """One robot to and fro along a strip, from x = 10 to x = 90 at 1 m/s, seeing 5 m ahead and behind."""
    fleet = Fleet(speed_m_s=1, sensor=SquareSensor(side_m=10))
    mission = Mission(name="strip", area=box(0, 0, 100, 5), period_s=100, fleet=fleet)
    there = loop("robot-1", [(10, 2.5), (90, 2.5)], 1)
    return Plan(mission=mission, trajectories=(there,), lower_bound_robots=1)


@pytest.fixture
def yard() -> Plan:
    """Three robots on one loop, one on another after a way to it, one that stays; every kind of obstacle and zone."""
    sensor = DiscSensor(radius_m=6)
    zones = (
        Zone(name="gate", shape=box(70, 60, 100, 100), period_s=8),
        Zone(name="pond", shape=Point(25, 25).buffer(12), period_s=None),
        Zone(name="shed $1", shape=box(90, 0, 110, 10), period_s=90, demand="visit"),
    )
    obstacles = (
        Obstacle(shape=box(40, 40, 60, 55)),
        Obstacle(shape=box(10, 70, 20, 80), blocks="motion"),
        Obstacle(shape=box(30, 80, 34, 84), blocks="sight"),
    )
    mission = Mission(
        name="yard", area=box(0, 0, 100, 100), zones=zones, obstacles=obstacles, period_s=60,
        fleet=Fleet(speed_m_s=10, sensor=sensor),
    )  # fmt: skip
    shared = [loop(f"robot-{k + 1}", [(5, 5), (95, 5), (95, 30), (5, 30)], 10, k / 3) for k in range(3)]
    places = [(50, 60), (70, 60), (95, 70), (75, 95), (70, 60)]
    way = Trajectory(robot="robot-4", times_s=[0, 2, 5, 8, 13], positions_m=places, loop_start_s=2)
    stays = Trajectory(robot="robot-5", times_s=[0], positions_m=[(30, 60)])
    return Plan(mission=mission, trajectories=(*shared, way, stays), lower_bound_robots=2)

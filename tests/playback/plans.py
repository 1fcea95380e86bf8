"""Plans for players, small enough to be right by hand."""

from __future__ import annotations

from shapely import Point, box
from tests.draw.conftest import loop

from rota import SwarmSettings
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory


def yard() -> Plan:
    """Three robots on one loop, one on another after a way to it, one that stays; every kind of obstacle and zone."""
    zones = (
        Zone(name="gate", shape=box(70, 60, 100, 100), period_s=8),
        Zone(name="</script><b>&pond", shape=Point(25, 25).buffer(12), period_s=30),
        Zone(name="shed", shape=box(90, 0, 110, 10), period_s=90, demand="visit"),
    )
    obstacles = (
        Obstacle(shape=box(40, 40, 60, 55)),
        Obstacle(shape=box(10, 70, 20, 80), blocks="motion"),
        Obstacle(shape=box(30, 80, 34, 84), blocks="sight"),
        Obstacle(shape=box(48, 4, 52, 24), blocks="sight"),
    )
    fleet = Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=15))
    area = box(0, 0, 100, 100)
    mission = Mission(name="yard", area=area, zones=zones, obstacles=obstacles, period_s=60, fleet=fleet)
    shared = [loop(f"robot-{k + 1}", [(5, 5), (95, 5), (95, 30), (5, 30)], 10, k / 3) for k in range(3)]
    places = [(50, 60), (70, 60), (95, 70), (75, 95), (70, 60)]
    way = Trajectory(robot="robot-4", times_s=[0, 2, 5, 8, 13], positions_m=places, loop_start_s=2)
    stays = Trajectory(robot="robot-5", times_s=[0, 3], positions_m=[(30, 60), (20, 50)], loop_start_s=3)
    return Plan(mission=mission, trajectories=(*shared, way, stays), lower_bound_robots=2)


def spreading() -> Plan:
    """Three robots with squares and discs that spread over a floor with a period; one joins late and one leaves."""
    disc, square = DiscSensor(radius_m=4), SquareSensor(side_m=6)
    robots = (
        Robot(name="a", speed_m_s=1, sensor=disc, joins_s=3, start=(2, 5)),
        Robot(name="b", speed_m_s=1, sensor=square, leaves_s=12, start=(5, 5)),
        Robot(name="c", speed_m_s=1, sensor=disc, start=(8, 5)),
    )
    mission = Mission(
        name="floor", area=box(0, 0, 20, 10), period_s=20, planning=SwarmSettings(),
        fleet=Fleet(speed_m_s=1, sensor=disc, robots=robots),
    )  # fmt: skip
    ways = (
        Trajectory(robot="a", times_s=[0, 3, 6], positions_m=[(2, 5), (2, 5), (2, 8)], loop_start_s=6),
        Trajectory(robot="b", times_s=[0, 8], positions_m=[(5, 5), (12, 5)], loop_start_s=8),
        Trajectory(robot="c", times_s=[0, 10], positions_m=[(8, 5), (17, 5)], loop_start_s=10),
    )
    return Plan(mission=mission, trajectories=ways)

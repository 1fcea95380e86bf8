"""A plan by hand for the exports: one robot that loops with pauses, one that stays, on holed ground."""

from __future__ import annotations

from dataclasses import replace

from shapely import MultiPolygon, Polygon, box

from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings

ORIGIN = GeoPoint(lat=-33.8567844, lon=151.2152967)
ROBOTS = ('<Zoë> & "Söhne", 1', "b")


def two_robots(origin: GeoPoint | None = ORIGIN, robots: tuple[str, str] = ROBOTS) -> Plan:
    """Times and places in thirds, which no short decimal gives."""
    looping = Trajectory(
        robot=robots[0],
        times_s=[0, 4, 24, 76 / 3, 35.5, 55.5, 65.5004],
        positions_m=[[-20, 0], [0, 0], [100, 1 / 3], [100, 1 / 3], [100, 50], [0, 50], [0, 0]],
        loop_start_s=4,
    )
    staying = Trajectory(robot=robots[1], times_s=[0, 30], positions_m=[[200, 200], [200, 90]], loop_start_s=30)
    border = [(-300, -300), (300, -300), (300, 300), (-300, 300)]
    hole = [(-100, -100), (-90, -100), (-90, -90), (-100, -90)]
    sensor = DiscSensor(radius_m=40)
    mission = Mission(
        name="quay <1>",
        area=MultiPolygon([Polygon(border, [hole]), box(400, 0, 410, 10)]),
        obstacles=(Obstacle(shape=box(150, 150, 160, 160), blocks="motion"),),
        zones=(Zone(name="gate & moat", shape=box(0, 0, 50, 50), period_s=60),),
        origin=origin,
        fleet=Fleet(
            speed_m_s=8,
            sensor=sensor,
            robots=tuple(Robot(name=name, speed_m_s=8, sensor=sensor) for name in robots),
            altitude_m=25,
        ),
    )
    return Plan(mission=mission, trajectories=(looping, staying))


def with_heights() -> Plan:
    """Robot b flat, robot a with heights of its own."""
    flat = two_robots(robots=("a", "b"))
    climbing = Trajectory(robot="a", times_s=[0, 10, 20], positions_m=[[0, 0, 30], [50, 0, 40.125], [0, 0, 30]])
    mission = replace(flat.mission, zones=(), planning=SwarmSettings(controller="reciprocal", altitudes_m=(20, 50)))
    return Plan(mission=mission, trajectories=(climbing, flat.trajectories[1]))

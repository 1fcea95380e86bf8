"""Plans that are rehearsed in tests, made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import MultiPolygon, Polygon, box

from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, Zone
from rota.model.plan import Charge, Plan, Trajectory

RING = np.array([[2.0, 2.0], [18.0, 2.0], [18.0, 18.0], [2.0, 18.0], [2.0, 2.0]])


def post(period_s: float = 60.0, robots: int = 1) -> Plan:
    """Robots that all stand in the middle of a room of 4 m by 4 m and see all of it."""
    sensor = DiscSensor(radius_m=5.0)
    mission = Mission(
        name="post", area=box(0, 0, 4, 4), period_s=period_s, fleet=Fleet(speed_m_s=1, sensor=sensor, robots=robots)
    )
    ways = [Trajectory(robot=f"robot-{k + 1}", times_s=[0], positions_m=[[2, 2]]) for k in range(robots)]
    return Plan(mission=mission, trajectories=tuple(ways))


def round_a_block(periods_s: tuple[float, ...] = (64.0, 64.0), *, square: bool = False, body_m: float = 0.0) -> Plan:
    """Robots on one ring round a block, each with a round of its own time, half of it apart; and a zone to visit."""
    sensor = SquareSensor(side_m=8.0) if square else DiscSensor(radius_m=5.0)
    robots = [Robot(name=f"r{k}", speed_m_s=1.0, sensor=sensor) for k in range(len(periods_s))]
    mission = Mission(
        name="block",
        area=MultiPolygon([box(0, 0, 20, 20)]),
        obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])), Obstacle(shape=box(4, 17, 5, 20))),
        zones=(
            Zone(name="door", shape=box(17, 7, 19, 9), period_s=40.0, demand="visit"),
            Zone(name="corner", shape=Polygon([(14, 14), (20, 14), (20, 20)]), period_s=33.0),
        ),
        period_s=50.0,
        fleet=Fleet(speed_m_s=1.0, sensor=sensor, body_radius_m=body_m, robots=robots),
    )
    ways = []
    for k, round_s in enumerate(periods_s):
        ring = np.vstack([np.roll(RING[:-1], -2 * k, axis=0), RING[2 * k % 4]])
        ways.append(Trajectory(robot=f"r{k}", times_s=np.linspace(0, round_s, 5), positions_m=ring))
    return Plan(mission=mission, trajectories=tuple(ways))


def counting_one(plan: Plan) -> Plan:
    """The plan whose last robot alone counts for the zones."""
    fleet = plan.mission.fleet
    *others, last = fleet.robots or ()
    last = replace(last, sensor=DiscSensor(radius_m=5.0, name="thermal"))
    zones = tuple(replace(zone, sensors=("thermal",)) for zone in plan.mission.zones)
    mission = replace(plan.mission, fleet=replace(fleet, robots=(*others, last)), zones=zones)
    return replace(plan, mission=mission)


def with_mass() -> Plan:
    """A robot that joins a way to and fro by way of a corner, and speeds up and brakes along it, from rest to rest."""
    fleet = Fleet(speed_m_s=4.0, sensor=DiscSensor(radius_m=3.0), robots=1)
    mission = Mission(
        name="mass", area=box(0, 0, 16, 8), obstacles=(Obstacle(shape=box(6, 3, 7, 4)),), period_s=30.0, fleet=fleet
    )
    way = Trajectory(
        robot="robot-1",
        loop_start_s=5.0,
        times_s=[0, 5, 9, 13, 17, 21],
        positions_m=[[2, 7], [2, 2], [8, 2], [14, 2], [8, 2], [2, 2]],
        accelerations_m_s2=[0, 0.75, -0.75, 0.75, -0.75],
    )
    return Plan(mission=mission, trajectories=(way,))


def taking_turns(body_m: float = 0.5) -> Plan:
    """Two robots that take turns on a road of 30 m, and charge at its end for 60 s of 120."""
    battery = BatteryLimits(endurance_s=100.0, recharge_s=80.0)
    sensor = DiscSensor(radius_m=8.0)
    fleet = Fleet(speed_m_s=1.0, sensor=sensor, body_radius_m=body_m, battery=battery)
    pad = Charger(name="pad", at=(2, 2), places=2)
    mission = Mission(name="road", area=box(0, 0, 36, 4), period_s=70.0, fleet=fleet, chargers=(pad,))
    home, far = [2.0, 2.0], [32.0, 2.0]
    first = Trajectory(
        robot="a", times_s=[0, 30, 60, 120], positions_m=[home, far, home, home],
        charges=(Charge(charger="pad", from_s=60, until_s=120),),
    )  # fmt: skip
    second = Trajectory(
        robot="b", times_s=[0, 60, 90, 120], positions_m=[home, home, far, home],
        charges=(Charge(charger="pad", from_s=0, until_s=60),),
    )  # fmt: skip
    return Plan(mission=mission, trajectories=(first, second))


def crossing(body_m: float = 0.5, late_s: float = 5.0) -> Plan:
    """Two robots on two roads that cross at (10, 10), the second of them late_s after the first; each takes 40 s."""
    sensor = DiscSensor(radius_m=30.0)
    robots = [Robot(name=name, speed_m_s=1.0, sensor=sensor) for name in "ab"]
    fleet = Fleet(speed_m_s=1.0, sensor=sensor, body_radius_m=body_m, robots=robots)
    mission = Mission(name="crossing", area=box(0, 0, 20, 20), period_s=60.0, fleet=fleet)
    a = Trajectory(robot="a", times_s=[0, 20, 40], positions_m=[[0, 10], [20, 10], [0, 10]])
    begin = [10, late_s]
    b = Trajectory(robot="b", times_s=[0, late_s, late_s + 20, 40], positions_m=[begin, [10, 0], [10, 20], begin])
    return Plan(mission=mission, trajectories=(a, b))

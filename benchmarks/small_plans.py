"""Small plans of all planners, written by hand: what mutated plan files are made from."""

from __future__ import annotations

from shapely import box

from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, MovingObstacle, Obstacle, Robot, SquareSensor, Zone
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Charge, Driven, Plan, Seam, Trajectory
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.planner_settings import SwarmSettings


def patrolling() -> Plan:
    """Two robots on loops in the ratio 2 to 3, one after a way there, round a block and past a hedge."""
    disc, square = DiscSensor(radius_m=6), SquareSensor(side_m=9)
    robots = (
        Robot(name="a", speed_m_s=4, sensor=disc, body_radius_m=0.3, start=(2, 2)),
        Robot(name="b", speed_m_s=4, sensor=square, body_radius_m=0.2),
    )
    mission = Mission(
        name="yard",
        area=box(0, 0, 30, 12),
        obstacles=(Obstacle(shape=box(6, 5, 8, 7)), Obstacle(shape=box(21, 5, 24, 5.5), blocks="sight")),
        zones=(
            Zone(name="gate", shape=box(2, 1, 7, 4), period_s=12),
            Zone(name="desk", shape=box(25, 2, 27, 4), period_s=30, demand="visit"),
        ),
        period_s=50,
        fleet=Fleet(speed_m_s=4, sensor=disc, robots=robots),
    )
    a = Trajectory(
        robot="a",
        times_s=[0, 1, 5, 7, 11, 13],
        positions_m=[[2, 2], [2, 3], [12, 3], [12, 9.5], [2, 9.5], [2, 3]],
        loop_start_s=1,
    )
    b = Trajectory(robot="b", times_s=[0, 4, 9, 13, 18], positions_m=[[16, 3], [28, 3], [28, 9], [16, 9], [16, 3]])
    return Plan(mission=mission, trajectories=(a, b), seed=3, lower_bound_robots=1, lower_bound_reason="one is needed")


def equal_patrolling() -> Plan:
    """As few equal robots as possible: three in a row, on loops that share no period, without bodies."""
    mission = Mission(
        name="field",
        area=box(0, 0, 24, 8).difference(box(11, 3, 13, 8)),
        period_s=20,
        fleet=Fleet(speed_m_s=3, sensor=DiscSensor(radius_m=5), turn_rate_rad_s=None),
        planning=PatrolSettings(effort="quick"),
    )
    ways = []
    for k, period in enumerate((6.0, 6.0 * 2**0.5, 0.0)):
        times, there = ([0, period / 2, period], [[3 + 8 * k, 2], [7 + 8 * k, 2]]) if period else ([0.0], [[19, 4]])
        ways.append(Trajectory(robot=f"r{k}", times_s=times, positions_m=[*there, there[0]] if period else there))
    return Plan(mission=mission, trajectories=tuple(ways), lower_bound_robots=2)


def accelerating() -> Plan:
    """A robot with mass to and fro, from rest to rest, and another one round a square whose corners are small ones."""
    sensor, limits = DiscSensor(radius_m=7), MotionLimits(acceleration_m_s2=2, jerk_m_s3=9, corner_m=0.5)
    robots = tuple(Robot(name=name, speed_m_s=4, sensor=sensor, body_radius_m=0.2, motion=limits) for name in "ab")
    mission = Mission(
        name="hall",
        area=box(0, 0, 12, 5).union(box(0, 5, 6, 11)),
        obstacles=(Obstacle(shape=box(8, 3, 9, 4), blocks="motion"),),
        zones=(Zone(name="door", shape=box(10, 2, 11, 3), period_s=9, demand="visit"),),
        period_s=11,
        fleet=Fleet(speed_m_s=4, sensor=sensor, robots=robots, body_radius_m=0.2, motion=limits),
    )
    a = Trajectory(
        robot="a",
        times_s=[0, 1, 3, 5, 7, 9],
        positions_m=[[2, 2], [2, 2], [6, 2], [10, 2], [6, 2], [2, 2]],
        accelerations_m_s2=[0, 2, -2, 2, -2],
        loop_start_s=1,
    )
    ring = [[1, 6.5], [1, 6.4], [1.1, 6.4], [1.2, 6.4], [1.2, 6.5], [1.2, 6.6], [1.1, 6.6], [1, 6.6], [1, 6.5]]
    b = Trajectory(robot="b", times_s=range(9), positions_m=ring, accelerations_m_s2=[0] * 8)
    return Plan(mission=mission, trajectories=(a, b))


def spreading() -> Plan:
    """A swarm past a moving obstacle: one robot joins, one leaves."""
    sensor = DiscSensor(radius_m=4)
    robots = tuple(
        Robot(name=f"r{k}", speed_m_s=2, sensor=sensor, body_radius_m=0.4, start=(2 + 2 * k, 2), **more)
        for k, more in enumerate(({}, {"joins_s": 1.0}, {"leaves_s": 9.0}))
    )
    mission = Mission(
        name="pond",
        area=box(0, 0, 15, 15),
        obstacles=(Obstacle(shape=box(6, 6, 8, 8)),),
        zones=(Zone(name="shore", shape=box(1, 1, 5, 5), period_s=60),),
        fleet=Fleet(speed_m_s=2, sensor=sensor, robots=robots, body_radius_m=0.4),
        moving_obstacles=(MovingObstacle(radius_m=1, times_s=(0, 8, 20), positions_m=((13, 1), (13, 9), (9, 13))),),
        planning=SwarmSettings(),
    )
    ends = ((2, 5), (5, 3.5), (9, 2.5))
    ways = tuple(
        Trajectory(robot=f"r{k}", times_s=[0, 1, 4], positions_m=[(2 + 2 * k, 2), (2 + 2 * k, 2), end], loop_start_s=4)
        for k, end in enumerate(ends)
    )
    return Plan(mission=mission, trajectories=ways)


def flying() -> Plan:
    """A swarm at altitudes, one robot above the other."""
    sensor = DiscSensor(radius_m=8, half_angle_deg=30)
    robots = tuple(Robot(name=name, speed_m_s=3, sensor=sensor, body_radius_m=0.5) for name in "ab")
    mission = Mission(
        name="sky",
        area=box(0, 0, 20, 20),
        fleet=Fleet(speed_m_s=3, sensor=sensor, robots=robots, body_radius_m=0.5),
        planning=SwarmSettings(controller="reciprocal", altitudes_m=(5, 12)),
    )
    a = Trajectory(robot="a", times_s=[0, 5], positions_m=[[4, 10, 6], [14, 10, 6]], loop_start_s=5)
    b = Trajectory(robot="b", times_s=[0, 5], positions_m=[[14, 10, 8], [4, 10, 8]], loop_start_s=5)
    return Plan(mission=mission, trajectories=(a, b))


def monitoring() -> Plan:
    """Two bouncing robots, each to and fro in a lane of its own: they turn by 180 degrees at its ends."""
    robots = tuple(
        Robot(name=name, speed_m_s=0.5, sensor=DiscSensor(radius_m=0.5), body_radius_m=0.2, turn_rate_rad_s=2)
        for name in "ab"
    )
    mission = Mission(
        name="lanes",
        area=box(0, 0, 4, 2),
        zones=tuple(
            Zone(name=f"end {name}", shape=box(3, y, 4, y + 1), period_s=40, demand="visit")
            for y, name in enumerate("ab")
        ),
        fleet=Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=0.5), robots=robots, body_radius_m=0.2),
        planning=BounceSettings(cell_m=1.0, headings=4, bouncing_angles_deg=(180,)),
    )
    turn = 3.141592653589793
    ways = tuple(
        Trajectory(
            robot=name,
            times_s=[0, 6, 8, 14, 16],
            positions_m=[[0.5, y + 0.5], [3.5, y + 0.5], [3.5, y + 0.5], [0.5, y + 0.5], [0.5, y + 0.5]],
            headings_rad=[0, 0, turn, turn, 2 * turn],
        )
        for y, name in enumerate("ab")
    )
    return Plan(mission=mission, trajectories=ways)


def covering() -> Plan:
    """One bouncing robot that goes round a floor of 3 x 2 cells by turns of 90 degrees at the walls."""
    robot = Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=0.5), body_radius_m=0.2).equal_robot("a")
    mission = Mission(
        name="floor",
        area=box(0, 0, 3, 2),
        fleet=Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=0.5), robots=(robot,), body_radius_m=0.2),
        planning=BounceSettings(cell_m=1.0, task="cover", headings=4, bouncing_angles_deg=(90,)),
    )
    quarter = 3.141592653589793 / 2
    way = Trajectory(
        robot="a",
        times_s=[0, 4, 6, 8, 10, 14],
        positions_m=[[0.5, 0.5], [2.5, 0.5], [2.5, 0.5], [2.5, 1.5], [2.5, 1.5], [0.5, 1.5]],
        headings_rad=[0, 0, quarter, quarter, 2 * quarter, 2 * quarter],
        loop_start_s=14,
    )
    return Plan(mission=mission, trajectories=(way,))


def charging() -> Plan:
    """A robot with mass, which leaves a charger and comes back, after a change in a plan in which it did so, too."""
    sensor, limits = DiscSensor(radius_m=12), MotionLimits(acceleration_m_s2=2, jerk_m_s3=9)
    battery = BatteryLimits(endurance_s=40, recharge_s=4, reserve_s=5, takeoff_s=1)
    fleet = Fleet(speed_m_s=4, sensor=sensor, motion=limits, battery=battery, turn_rate_rad_s=4, body_radius_m=0.2)
    mission = Mission(
        name="jetty", area=box(0, 0, 12, 4), period_s=12, fleet=fleet, chargers=(Charger(name="pad", at=(2, 2)),)
    )
    driven = Driven(
        robot="robot-1",
        sensor=sensor,
        times_s=[-6, -4, -2, 0],
        positions_m=[[10, 2], [6, 2], [2, 2], [2, 2]],
        accelerations_m_s2=[2, -2, 0],
        charges=(Charge(charger="pad", from_s=-2, until_s=0),),
        battery=0.5,
    )
    way = Trajectory(
        robot="robot-1",
        times_s=[0, 1, 3, 5, 6, 8, 10],
        positions_m=[[2, 2], [2, 2], [6, 2], [10, 2], [10, 2], [6, 2], [2, 2]],
        accelerations_m_s2=[0, 2, -2, 0, 2, -2],
        charges=(Charge(charger="pad", from_s=0, until_s=1),),
        battery=0.8,
    )
    return Plan(mission=mission, trajectories=(way,), seam=Seam(at_s=20, driven=(driven,)))


def small_plans() -> tuple[Plan, ...]:
    """All of them."""
    return patrolling(), equal_patrolling(), accelerating(), spreading(), flying(), monitoring(), covering(), charging()

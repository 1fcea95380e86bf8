"""Two robots half a round apart on one lane, and the events of a watch that hears them: places and times are simple."""

from __future__ import annotations

from collections.abc import Iterator

from shapely import box

from rota.live.events import Event, Heard, Tick
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory

LENGTH_M, SPEED_M_S = 100.0, 5.0
ROUND_S = 2 * LENGTH_M / SPEED_M_S  # 40 s; with two robots an end of the lane is passed every 20 s
PERIOD_S, ENDS_PERIOD_S = 60.0, 25.0


def two_robots(*, zones: bool = True, thermal: bool = False) -> Plan:
    """A lane of 100 m by 4 m, driven to and fro at 5 m/s in 40 s; the zone ``left`` is its first metre.

    thermal: b alone has a thermal sensor, which counts alone for the zones.
    """
    fleet = Fleet(
        speed_m_s=SPEED_M_S,
        sensor=DiscSensor(radius_m=3.0),
        robots=tuple(
            Robot(name=name, speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=3.0, name=sees_heat))
            for name, sees_heat in (("a", None), ("b", "thermal" if thermal else None))
        ),
    )
    counting = ("thermal",) if thermal else ()
    asked = (
        Zone(name="left", shape=box(0, 1, 1, 3), period_s=ENDS_PERIOD_S, sensors=counting),
        Zone(name="gate", shape=box(48, 0, 52, 4), period_s=ROUND_S, demand="visit", sensors=counting),
    )
    mission = Mission(
        name="lane",
        area=box(0, 0, LENGTH_M, 4),
        obstacles=(Obstacle(shape=box(30, 3.5, 31, 4)),),
        zones=asked if zones else (),
        period_s=PERIOD_S,
        fleet=fleet,
    )
    half_s = ROUND_S / 2
    ways = (
        Trajectory(robot="a", times_s=[0, half_s, ROUND_S], positions_m=[[0, 2], [LENGTH_M, 2], [0, 2]]),
        Trajectory(robot="b", times_s=[0, half_s, ROUND_S], positions_m=[[LENGTH_M, 2], [0, 2], [LENGTH_M, 2]]),
    )
    return Plan(mission=mission, trajectories=ways)


def driven(
    plan: Plan, until_s: float, *, step_s: float = 0.25, ends_s: dict[str, float] | None = None
) -> Iterator[Event]:
    """What is heard where all drive exactly by plan and report at every step; ends_s: when a robot falls silent."""
    steps = round(until_s / step_s)
    for k in range(steps + 1):
        time_s = k * step_s
        for number, way in enumerate(plan):
            if time_s <= (ends_s or {}).get(way.robot, until_s):
                x, y = way.at([time_s])[0].tolist()
                yield Heard(time_s, number, time_s, x, y, 30.0, 1.0 - time_s / 1000, "running")
        yield Tick(time_s)

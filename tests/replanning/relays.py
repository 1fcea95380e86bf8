"""Three robots that take turns at a ring with one pad, which closed forms of replanning begin with."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from tests.replanning.rings import CORNERS_M, ROUND_S, ring_mission

from rota import Plan, Trajectory
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, Mission
from rota.model.plan import Charge

PERIOD_S = 41.0
# a round of 40 s takes 80 s of charging: three robots take turns at the ring
BATTERY = BatteryLimits(endurance_s=60, recharge_s=120, reserve_s=10)
REST_S = 1.0  # told of a robot that stays


def relay_mission(names: tuple[str, ...], **of_fleet: object) -> Mission:
    """The ring with a pad on it."""
    mission = ring_mission(PERIOD_S, names)
    fleet = replace(mission.fleet, battery=BATTERY, **of_fleet)  # type: ignore[arg-type]
    robots = tuple(replace(robot, battery=BATTERY) for robot in fleet.robots or ())
    return replace(mission, fleet=replace(fleet, robots=robots), chargers=(Charger(name="pad", at=(0, 0), places=4),))


@cache
def relay(spare: bool) -> Plan:
    """Three robots that take turns, 40 s apart: at 0 the first begins its round; and one more on the pad, or not."""
    lines = []
    for k, name in enumerate("abc"):
        begins_s = ROUND_S * k
        out_s = begins_s + np.arange(0, 50, 10.0)
        times_s, places_m = np.append(out_s, 120.0), np.vstack([CORNERS_M, CORNERS_M[:1]])
        if begins_s > 0:
            times_s, places_m = np.append(0.0, times_s), np.vstack([CORNERS_M[:1], places_m])
        keep = np.append(True, np.diff(times_s) > 0)
        stays = [(0.0, begins_s), (begins_s + ROUND_S, 120.0)]
        charges = tuple(Charge(charger="pad", from_s=a, until_s=b) for a, b in stays if a < b)
        lines.append(Trajectory(robot=name, times_s=times_s[keep], positions_m=places_m[keep], charges=charges))
    if spare:
        charge = Charge(charger="pad", from_s=0, until_s=REST_S)
        lines.append(
            Trajectory(
                robot="d", times_s=[0, REST_S], positions_m=[(0, 0), (0, 0)], charges=(charge,), loop_start_s=REST_S
            )
        )
    return Plan(mission=relay_mission(tuple(line.robot for line in lines)), trajectories=tuple(lines))

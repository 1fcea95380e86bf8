"""A plan by hand of robots that take turns at a loop, for tests of what is made of such plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import box

from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, GeoPoint, Mission
from rota.model.plan import Charge, Plan, Trajectory

SQUARE_M = [(10.0, 0.0), (30.0, 0.0), (30.0, 20.0), (10.0, 20.0), (10.0, 0.0)]
WAY_S, ROUND_S = 10.0, 80.0
FLIGHT_S = 2 * WAY_S + 2 * ROUND_S
TURN_S = 2 * ROUND_S


def relieved(count: int, rounds: int = 2) -> Plan:
    """Robots at 1 m/s: from the pad at (0, 0) to a square of 80 m, twice round it and back; the next one takes over.

    The battery lasts for 400 s and is filled in 200; 40 s are the reserve. Of fewer rounds they leave the square alone
    for a while: nobody takes over.
    """
    mission = Mission(
        name="pier",
        area=box(-5, -5, 40, 30),
        period_s=200,
        origin=GeoPoint(lat=53.5, lon=9.9),
        fleet=Fleet(
            speed_m_s=1,
            sensor=DiscSensor(radius_m=30),
            battery=BatteryLimits(endurance_s=400, recharge_s=200, reserve_s=40),
        ),
        chargers=(Charger(name="pad", at=(0, 0), places=99),),
    )
    robots = tuple(_robot(f"robot-{k + 1}", k * TURN_S, count * TURN_S, rounds) for k in range(count))
    return Plan(mission=mission, trajectories=robots)


def with_battery(plan: Plan, **changed: float) -> Plan:
    """The plan of robots all of whose batteries differ by this."""
    fleet = plan.mission.fleet
    robots = fleet.robots and tuple(replace(one, battery=replace(one.battery, **changed)) for one in fleet.robots)
    fleet = replace(fleet, battery=replace(fleet.battery, **changed), robots=robots)
    return replace(plan, mission=replace(plan.mission, fleet=fleet))


def _robot(name: str, starts_s: float, round_s: float, rounds: int) -> Trajectory:
    """A robot that takes off then, again and again; under way at the end of a round, it is so at its start, too."""
    line_m = np.array([(0.0, 0.0), SQUARE_M[0], *(SQUARE_M[1:] * rounds), (0.0, 0.0)])
    flown_s = starts_s + np.append(0.0, np.cumsum(np.hypot(*np.diff(line_m, axis=0).T)))
    over = flown_s > round_s
    corners_s = np.where(over, flown_s - round_s, flown_s)
    order = np.argsort(corners_s)
    times_s, places_m = corners_s[order], line_m[order]
    seam_m = [np.interp(round_s, flown_s, line_m[:, axis]) for axis in (0, 1)] if over.any() else [0.0, 0.0]
    lands_s = float(corners_s[-1])
    stays = [(lands_s, starts_s)] if over.any() else [(0.0, starts_s), (lands_s, round_s)]
    if times_s[0] > 0:
        times_s, places_m = np.append(0.0, times_s), np.vstack([seam_m, places_m])
    if times_s[-1] < round_s:
        times_s, places_m = np.append(times_s, round_s), np.vstack([places_m, seam_m])
    charges = tuple(Charge(charger="pad", from_s=a, until_s=b) for a, b in stays if b > a)
    return Trajectory(robot=name, times_s=times_s, positions_m=places_m, charges=charges)

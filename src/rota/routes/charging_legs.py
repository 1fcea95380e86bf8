"""What a trajectory asks of its robot's battery, leg by leg: what is used, what is charged, and what lies ahead."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.fleet import Robot
from rota.model.mission import Charger
from rota.model.plan import Trajectory

STILL_M = 1e-9  # a robot that moves by no more than this stands


class ChargingLegs(NamedTuple):
    """The legs of one robot, (m,) each; one without end comes last where it stays for ever.

    begins_s, ends_s: by plan. uses: seconds of driving that a second of the leg takes from the battery. docks: the
    charger at which it is spent, by its number, -1: at none. fills: what a second there adds to the battery; swaps_s:
    after how long there it is full, inf: never by that. leaves_s: when the robot leaves its charger by plan; the leg's
    end where it is at none. needs_s: what is used from the leg's end, or from leaving the charger on, until the
    robot is at a charger again; inf: never.
    """

    begins_s: Floats
    ends_s: Floats
    uses: Floats
    docks: Ints
    fills: Floats
    swaps_s: Floats
    leaves_s: Floats
    needs_s: Floats


def charging_legs(way: Trajectory, robot: Robot, chargers: tuple[Charger, ...]) -> ChargingLegs:
    """The legs of a robot's trajectory with what they ask of its battery."""
    numbers = {charger.name: k for k, charger in enumerate(chargers)}
    endurance_s, stands = robot.battery.endurance_s or math.inf, robot.battery.standing_uses
    ways_m = np.hypot(*np.diff(way.positions_m[:, :2], axis=0).T)
    uses = np.where(ways_m > STILL_M, 1.0, stands)
    docks, fills, swaps_s = np.full(len(uses), -1, np.int64), np.zeros(len(uses)), np.full(len(uses), np.inf)
    for charge in way.charges:
        number = numbers[charge.charger]
        begin, end = np.searchsorted(way.times_s, (charge.from_s, charge.until_s))
        docks[begin:end], uses[begin:end] = number, 0.0
        if (swap_s := chargers[number].swap_s) is not None:
            swaps_s[begin:end] = swap_s
        elif math.isfinite(endurance_s):
            fills[begin:end] = endurance_s / (robot.battery.recharge_s or math.inf)
    begins_s, ends_s = way.times_s[:-1], way.times_s[1:]
    if not way.loop_duration_s:
        at = bool(way.charges) and way.charges[-1].until_s == way.times_s[-1]
        docks = np.append(docks, docks[-1] if at else -1)
        uses, fills = np.append(uses, 0.0 if at else stands), np.append(fills, fills[-1] if at else 0.0)
        swaps_s = np.append(swaps_s, swaps_s[-1] if at else np.inf)
        begins_s, ends_s = way.times_s, np.append(ends_s, np.inf)
    stays_s, needs_s = _ahead(way, ends_s - begins_s, uses, docks, robot.battery.departure_s)
    return ChargingLegs(begins_s, ends_s, uses, docks, fills, swaps_s, ends_s + stays_s, needs_s)


def _ahead(way: Trajectory, lasts_s: Floats, uses: Floats, docks: Ints, takeoff_s: float) -> tuple[Floats, Floats]:
    """For each leg how long the robot stays on its charger after it, and what it then uses until it charges again."""
    count, first, loops = len(lasts_s), way.loop_index, way.loop_duration_s > 0
    stays_s, needs_s = [0.0] * count, [0.0] * count
    docked, own_uses, legs_s = (docks >= 0).tolist(), uses.tolist(), lasts_s.tolist()
    charges = bool((docks[first:] >= 0).any())
    stay_s = math.inf if loops and (docks[first:] >= 0).all() else 0.0
    need_s = math.inf if loops and not charges else 0.0
    after = first if loops else count - 1
    # of a loop twice: what comes after its end is known after once
    for leg in [*(range(count - 1, first - 1, -1) if loops else ()), *range(count - 1, -1, -1)]:
        if docked[leg]:
            need_s += 0.0 if docked[after] else takeoff_s
            stays_s[leg], needs_s[leg] = stay_s, need_s
            stay_s += legs_s[leg]
        else:
            needs_s[leg] = 0.0 if docked[after] else need_s
            need_s, stay_s = needs_s[leg] + own_uses[leg] * legs_s[leg], 0.0
        after = leg
    return np.array(stays_s), np.array(needs_s)

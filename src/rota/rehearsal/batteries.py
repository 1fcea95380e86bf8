"""What a plan asks of batteries, leg by leg, as arrays for the compiled loops of runs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.check.tolerances import STILL_M
from rota.model.fleet import Robot
from rota.model.mission import Charger
from rota.model.plan import Plan, Trajectory
from rota.rehearsal.drive_kernels import Batteries

Floats = NDArray[np.float64]


def batteries_of(plan: Plan) -> Batteries:
    """What the plan asks of the battery of each robot."""
    chargers = {charger.name: (k, charger) for k, charger in enumerate(plan.mission.chargers)}
    robots = [plan.mission.fleet.robot(way.robot) for way in plan]
    parts = [_legs_of(way, robot, chargers) for way, robot in zip(plan, robots, strict=True)]
    counts = [len(part["begins_s"]) for part in parts]
    firsts = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Batteries(
        firsts=firsts,
        again=firsts[:-1] + np.array([way.loop_index for way in plan], np.int64),
        loops_s=np.array([way.loop_duration_s for way in plan], np.float64),
        endurance_s=np.array([robot.battery.endurance_s or math.inf for robot in robots], np.float64),
        reserve_s=np.array([robot.battery.reserve_s for robot in robots], np.float64),
        **joined,
    )


def _legs_of(way: Trajectory, robot: Robot, chargers: dict[str, tuple[int, Charger]]) -> dict[str, NDArray[np.generic]]:
    """The columns of one robot's legs; one without end comes last where it stays for ever."""
    endurance_s = robot.battery.endurance_s or math.inf
    stands = endurance_s / (robot.battery.standing_endurance_s or endurance_s) if math.isfinite(endurance_s) else 1.0
    ways_m = np.hypot(*np.diff(way.positions_m[:, :2], axis=0).T)
    uses = np.where(ways_m > STILL_M, 1.0, stands)
    docks, fills, swaps_s = np.full(len(uses), -1, np.int64), np.zeros(len(uses)), np.full(len(uses), np.inf)
    for charge in way.charges:
        k, charger = chargers[charge.charger]
        begin, end = np.searchsorted(way.times_s, (charge.from_s, charge.until_s))
        docks[begin:end], uses[begin:end] = k, 0.0
        if charger.swap_s is not None:
            swaps_s[begin:end] = charger.swap_s
        elif math.isfinite(endurance_s):
            fills[begin:end] = endurance_s / (robot.battery.recharge_s or math.inf)
    begins_s, ends_s = way.times_s[:-1], way.times_s[1:]
    if not way.loop_duration_s:
        at = bool(way.charges) and way.charges[-1].until_s == way.times_s[-1]
        docks = np.append(docks, docks[-1] if at else -1)
        uses, fills = np.append(uses, 0.0 if at else stands), np.append(fills, fills[-1] if at else 0.0)
        swaps_s = np.append(swaps_s, swaps_s[-1] if at else np.inf)
        begins_s, ends_s = way.times_s, np.append(ends_s, np.inf)
    leaves_s, needs_s = _ahead(way, ends_s - begins_s, uses, docks)
    return {
        "begins_s": begins_s, "ends_s": ends_s, "uses": uses, "docks": docks, "fills": fills, "swaps_s": swaps_s,
        "leaves_s": ends_s + leaves_s, "needs_s": needs_s,
    }  # fmt: skip


def _ahead(way: Trajectory, lasts_s: Floats, uses: Floats, docks: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """For each leg how long the robot stays on its charger after it, and what it then uses until it charges again."""
    count, first, loops = len(lasts_s), way.loop_index, way.loop_duration_s > 0
    stays_s, needs_s = np.zeros(count), np.zeros(count)
    charges = bool((docks[first:] >= 0).any())
    stay_s = math.inf if loops and (docks[first:] >= 0).all() else 0.0
    need_s = math.inf if loops and not charges else 0.0
    after = first if loops else count - 1
    # of a loop twice: what comes after its end is known after once
    for leg in [*(range(count - 1, first - 1, -1) if loops else ()), *range(count - 1, -1, -1)]:
        if docks[leg] >= 0:
            stays_s[leg], needs_s[leg] = stay_s, need_s
            stay_s += lasts_s[leg]
        else:
            needs_s[leg] = 0.0 if docks[after] >= 0 else need_s
            need_s, stay_s = needs_s[leg] + uses[leg] * lasts_s[leg], 0.0
        after = leg
    return stays_s, needs_s

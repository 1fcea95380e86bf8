"""Batteries over a plan's rounds: how full each is, who charges where, and how many robots a charger has at once.

All robots begin with full batteries. A round makes min(c, b + d) of the level b that it begins with: what it charges
less what it takes, d, and never more than some level c, since batteries do not overflow. So levels at the beginning of
rounds either fall by -d each time, or are the same from the second round on: two rounds tell them for ever.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.check.report import Violation, violation
from rota.check.routes import Routes, commensurable_classes
from rota.check.tolerances import BATTERY_S, SAME_TIME, STILL_M, TOUCH_M
from rota.model.mission import Charger, Robot
from rota.model.plan import Plan, Trajectory
from rota.model.violation_kinds import ViolationKind

Floats = NDArray[np.float64]
MOST_STAYS = 2_000_000  # at one charger, counted one by one; of more, robots are taken to come all at once


@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """How full a battery is: levels_s (n,) seconds of driving left at times_s (n,), straight between them.

    times_s goes over all before the loop and two rounds. falls_s: by how much less there is after each further round.
    """

    times_s: Floats
    levels_s: Floats
    falls_s: float


def docked_legs(plan: Plan, routes: Routes) -> NDArray[np.bool_]:
    """Which legs (m,) of ``routes_of(plan)`` robots spend at a charger; where one stays for ever, too."""
    docked = np.zeros(len(routes.robots), np.bool_)
    for k, trajectory in enumerate(plan):
        if not trajectory.charges:
            continue
        own = np.flatnonzero(routes.robots == k)
        last = trajectory.charges[-1]
        stays = trajectory.loop_duration_s == 0 and last.until_s == trajectory.times_s[-1]
        for charge in trajectory.charges:
            until_s = math.inf if stays and charge is last else charge.until_s
            docked[own] |= (routes.times_s[own, 0] >= charge.from_s) & (routes.times_s[own, 1] <= until_s)
    return docked


def undocked_routes(routes: Routes, plan: Plan) -> Routes:
    """The legs that robots do not spend at a charger: there they see nothing, and are in nobody's way."""
    if not any(trajectory.charges for trajectory in plan):
        return routes
    kept = ~docked_legs(plan, routes)
    return replace(
        routes,
        legs_m=np.ascontiguousarray(routes.legs_m[kept]),
        heights_m=routes.heights_m[kept],
        times_s=np.ascontiguousarray(routes.times_s[kept]),
        bends=np.ascontiguousarray(routes.bends[kept]),
        robots=routes.robots[kept],
        kinds=routes.kinds[kept],
    )


def battery_levels(trajectory: Trajectory, robot: Robot, chargers: dict[str, Charger]) -> Levels:
    """How full the battery of a robot is that has an endurance; see ``Levels``."""
    battery, times_s = robot.battery, trajectory.times_s
    endurance_s = battery.endurance_s or math.inf
    ways_m = np.hypot(*np.diff(trajectory.positions_m[:, :2], axis=0).T)
    standing = endurance_s / (battery.standing_endurance_s or endurance_s)
    used_s = np.where(ways_m > STILL_M, 1.0, standing) * np.diff(times_s)
    told_s, levels_s, rounds_s = [np.zeros(1)], [np.full(1, endurance_s)], []
    stood: tuple[str, float] = ("", 0.0)  # at which charger, and how long
    first, last = trajectory.loop_index, len(times_s) - 1
    for turn, (low, high) in enumerate(((0, first), (first, last), (first, last))):
        late_s = trajectory.loop_duration_s if turn == 2 else 0.0
        for begin, end, charge in _stretches(trajectory, low, high):
            level_s, begin_s, end_s = levels_s[-1][-1], times_s[begin] + late_s, times_s[end] + late_s
            if charge is None:
                stood = ("", 0.0)
                told_s.append(times_s[begin + 1 : end + 1] + late_s)
                levels_s.append(level_s - np.cumsum(used_s[begin:end]))
                continue
            before_s = stood[1] if stood[0] == charge else 0.0
            stood = (charge, before_s + end_s - begin_s)
            full_s = begin_s + _full_after_s(level_s, robot, chargers[charge], before_s)
            charged_s = (end_s - begin_s) * endurance_s / (battery.recharge_s or math.inf)
            if chargers[charge].swap_s is not None:
                charged_s = 0.0
            if full_s < end_s:  # a swap fills it all at once
                before_it_s = level_s if chargers[charge].swap_s is not None else endurance_s
                told_s.append(np.full(2, full_s))
                levels_s.append(np.array([before_it_s, endurance_s]))
                level_s, charged_s = endurance_s, 0.0
            told_s.append(np.full(1, end_s))
            levels_s.append(np.full(1, level_s + charged_s))
        rounds_s.append(float(levels_s[-1][-1]))
    falls_s = rounds_s[1] - rounds_s[2]
    return Levels(times_s=np.concatenate(told_s), levels_s=np.concatenate(levels_s), falls_s=falls_s)


def _stretches(trajectory: Trajectory, low: int, high: int) -> Iterator[tuple[int, int, str | None]]:
    """The legs from one index to another, cut where charges begin and end: from, to, and at which charger."""
    for charge in trajectory.charges:
        begin, end = (int(k) for k in np.searchsorted(trajectory.times_s, (charge.from_s, charge.until_s)))
        begin, end = max(begin, low), min(end, high)
        if begin < end:
            if low < begin:
                yield low, begin, None
            yield begin, end, charge.charger
            low = end
    if low < high:
        yield low, high, None


def _full_after_s(level_s: float, robot: Robot, charger: Charger, stood_s: float) -> float:
    """After how long a battery is full of a robot that has stood at the charger for so long already."""
    if charger.swap_s is not None:
        return max(charger.swap_s * (1 - SAME_TIME) - stood_s, 0.0)
    endurance_s = robot.battery.endurance_s or math.inf
    return (endurance_s - level_s) / endurance_s * (robot.battery.recharge_s or math.inf)


def charging_violations(plan: Plan) -> list[Violation]:
    """Batteries below their reserve, charges away from chargers, and chargers with more robots than places."""
    if not any(plan.mission.fleet.robot(one.robot).battery.endurance_s or one.charges for one in plan):
        return []
    chargers = {charger.name: charger for charger in plan.mission.chargers}
    violations = [found for one in plan for found in _away_from_charger(one, chargers)]
    for one in plan:
        robot = plan.mission.fleet.robot(one.robot)
        if robot.battery.endurance_s is not None:
            violations += _below_reserve(one, robot, battery_levels(one, robot, chargers))
    return violations + _too_many_at_once(plan, chargers)


def _away_from_charger(trajectory: Trajectory, chargers: dict[str, Charger]) -> list[Violation]:
    """The first moment of each charge at which the robot is not at its charger."""
    found = []
    for charge in trajectory.charges:
        during = (trajectory.times_s >= charge.from_s) & (trajectory.times_s <= charge.until_s)
        places, times_s = trajectory.positions_m[during, :2], trajectory.times_s[during]
        away_m = np.hypot(*(places - chargers[charge.charger].at).T)
        if len(k := np.flatnonzero(away_m > TOUCH_M)):
            found.append(
                violation("charges away from its charger", f"{trajectory.robot}, {charge.charger}", places[k[0]],
                          times_s[k[0]], away_m[k[0]], TOUCH_M, "m")
            )  # fmt: skip
    return found


def _below_reserve(trajectory: Trajectory, robot: Robot, levels: Levels) -> list[Violation]:
    """Where a battery first falls below its reserve, with the least that is left before it charges again."""
    kind: ViolationKind = "battery below its reserve"
    reserve_s = robot.battery.reserve_s
    low = np.flatnonzero(levels.levels_s < reserve_s - BATTERY_S)
    stays = trajectory.loop_duration_s == 0
    if stays and not (trajectory.charges and trajectory.charges[-1].until_s == trajectory.times_s[-1]):
        end_m, end_s = trajectory.positions_m[-1], float(trajectory.times_s[-1])
        endurance_s = robot.battery.endurance_s or math.inf
        standing = (robot.battery.standing_endurance_s or endurance_s) / endurance_s
        left_s = float(levels.levels_s[-1]) - reserve_s
        return [violation(kind, trajectory.robot, end_m, end_s + max(left_s, 0.0) * standing, 0.0, reserve_s, "s")]
    if len(low):
        k = int(low[0])
        share = (levels.levels_s[k - 1] - reserve_s) / (levels.levels_s[k - 1] - levels.levels_s[k])
        time_s = float(levels.times_s[k - 1] + max(share, 0.0) * (levels.times_s[k] - levels.times_s[k - 1]))
        rises = np.flatnonzero(np.diff(levels.levels_s[k:]) > 0)
        least_s = levels.levels_s[k : k + int(rises[0]) + 1 if len(rises) else None].min()
        return [violation(kind, trajectory.robot, trajectory.at(time_s), time_s, least_s, reserve_s, "s")]
    if levels.falls_s > BATTERY_S:
        rounds = math.ceil((float(levels.levels_s.min()) - reserve_s) / levels.falls_s)
        time_s = float(levels.times_s[-1]) + max(rounds - 1, 0) * trajectory.loop_duration_s
        end_m = trajectory.positions_m[-1]
        return [
            violation("takes more than it charges", trajectory.robot, end_m, time_s, levels.falls_s, 0.0, "s a round")
        ]
    return []


def _too_many_at_once(plan: Plan, chargers: dict[str, Charger]) -> list[Violation]:
    """Chargers that have more robots at some time than places."""
    users: dict[str, list[Trajectory]] = defaultdict(list)
    for trajectory in plan:
        for name in dict.fromkeys(charge.charger for charge in trajectory.charges):
            users[name].append(trajectory)
    found = []
    for name, robots in users.items():
        classes, parts, units_s = commensurable_classes([one.loop_duration_s for one in robots])
        from_s = max(one.loop_start_s for one in robots)
        count, time_s = 0, None
        for number in np.unique(classes):
            own = [one for one, its in zip(robots, classes, strict=True) if its == number]
            common_s = math.lcm(*(int(part) for part in parts[classes == number])) * float(units_s[number])
            most, when_s = _most_at_once(own, name, from_s + common_s)
            count, time_s = count + most, when_s if len(np.unique(classes)) == 1 else None
        if count > chargers[name].places:
            who = f"{name}: {', '.join(one.robot for one in robots)}"
            found.append(
                violation("charger too full", who, chargers[name].at, time_s, count, chargers[name].places, "robots")
            )
    return found


def _most_at_once(robots: list[Trajectory], charger: str, until_s: float) -> tuple[int, float | None]:
    """How many of these robots are at a charger at once until a time, at most, and when."""
    begins, ends = [], []
    stays = 0.0
    for one in robots:
        turns = 1 if one.loop_duration_s == 0 else math.ceil((until_s - one.loop_start_s) / one.loop_duration_s)
        stays += turns * len(one.charges)
        if stays > MOST_STAYS:
            return len(robots), None
        for charge in (each for each in one.charges if each.charger == charger):
            again = np.arange(turns if charge.from_s >= one.loop_start_s else 1) * one.loop_duration_s
            for_ever = one.loop_duration_s == 0 and charge.until_s == one.times_s[-1]
            begins.append(charge.from_s + again)
            ends.append(np.full(1, until_s) if for_ever else charge.until_s + again)
    begin_s, end_s = np.concatenate(begins), np.concatenate(ends)
    end_s -= SAME_TIME * np.maximum(1.0, end_s)  # one leaves at the moment at which another one comes
    times_s = np.concatenate([begin_s, end_s])
    steps = np.concatenate([np.ones(len(begin_s)), -np.ones(len(end_s))])
    order = np.lexsort((steps, times_s))
    present = np.cumsum(steps[order])
    k = int(np.argmax(present))
    return int(present[k]), float(times_s[order[k]])

"""Batteries over a plan's rounds: how full each is, who charges where, and how many robots a charger has at once.

Robots begin with batteries as the plan tells. A round makes min(c, b + d) of the level b that it begins with: what it
charges less what it takes, d, and never more than some level c, since batteries do not overflow. So levels at the
beginning of rounds fall by -d each time, are the same from the second round on, or rise until they are: two rounds tell
the least.

Who leaves a charger, or is in the air at first with nothing driven before, has taken off: that is taken at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rota.check.arrays import Flags, Floats
from rota.check.report import Violation, violation
from rota.check.routes import Routes
from rota.check.stays import crowded_violations, hasty_violations, stays_on_s
from rota.check.tolerances import BATTERY_S, SAME_TIME, SLOW_SHARE, STILL_M, TOUCH_M
from rota.model.mission import Charger, Robot
from rota.model.plan import Charge, Driven, Plan, Trajectory
from rota.model.violation_kinds import ViolationKind


@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """How full a battery is: levels_s (n,) seconds of driving left at times_s (n,), straight between them.

    times_s goes over all before the loop and two rounds; at a swap and at a take-off a time has two levels, the later
    one last. falls_s: by how much less there is after each further round.
    """

    times_s: Floats
    levels_s: Floats
    falls_s: float

    def at(self, time_s: float, trajectory: Trajectory) -> float:
        """The level at a moment of the trajectory, in any round; where levels rise from round to round, no more."""
        lasts_s, rounds = trajectory.loop_duration_s, 0.0
        if lasts_s > 0:
            rounds = max(0.0, math.floor((time_s - trajectory.loop_start_s) / lasts_s) - 1.0)
        level_s = float(np.interp(time_s - rounds * lasts_s, self.times_s, self.levels_s))
        return level_s - max(0.0, self.falls_s) * rounds


def docked_rows(times_s: Floats, charges: Sequence[Charge]) -> Flags:
    """Which legs (n - 1,) between times (n,) are spent at a charger."""
    docked = np.zeros(len(times_s) - 1, np.bool_)
    for charge in charges:
        docked |= (times_s[:-1] >= charge.from_s) & (times_s[1:] <= charge.until_s)
    return docked


def docked_legs(plan: Plan, routes: Routes) -> Flags:
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
    return routes.legs(~docked_legs(plan, routes))


def battery_levels(plan: Plan, trajectory: Trajectory) -> Levels:
    """How full the battery is of a robot of the plan that has an endurance, on a trajectory; see ``Levels``."""
    follows = _Follower(plan, trajectory.robot)
    if (driven := _way_before(plan, trajectory.robot)) is not None:  # a swap may be under way
        follows.follow(driven)
    follows.begin(trajectory)
    rounds_s, first, last = [], trajectory.loop_index, len(trajectory.times_s) - 1
    for turn, (low, high) in enumerate(((0, first), (first, last), (first, last))):
        follows.drive(trajectory, low, high, trajectory.loop_duration_s if turn == 2 else 0.0)
        rounds_s.append(follows.level_s)
    falls_s = rounds_s[1] - rounds_s[2]
    return Levels(times_s=np.concatenate(follows.times_s), levels_s=np.concatenate(follows.levels_s), falls_s=falls_s)


def _way_before(plan: Plan, robot: str) -> Driven | None:
    """What a robot drove before the plan took over; None: nothing."""
    return next((one for one in (() if plan.seam is None else plan.seam.driven) if one.robot == robot), None)


def level_after_s(plan: Plan, driven: Driven, until_s: float = 0.0) -> float:
    """The level that a battery has at a moment of what was driven before a plan took over, in seconds of driving."""
    follows = _Follower(plan, driven.robot)
    follows.follow(driven)
    return float(np.interp(until_s, np.concatenate(follows.times_s), np.concatenate(follows.levels_s)))


class _Follower:
    """A robot's battery as it is driven: times_s and levels_s in pieces, and at which charger it charges how long."""

    def __init__(self, plan: Plan, robot: str) -> None:
        self._robot = plan.mission.fleet.robot(robot)
        self._chargers = {charger.name: charger for charger in plan.mission.chargers}
        self._full_s = self._robot.battery.endurance_s or math.inf
        self._stood: tuple[str, float] = ("", 0.0)  # since it has landed; below 0: it lands
        self._begun, self._in_air, self._left_s = False, False, math.inf  # left_s: by what was driven before
        self.times_s, self.levels_s = [np.zeros(1)], [np.full(1, self._full_s)]

    @property
    def level_s(self) -> float:
        """What is left."""
        return float(self.levels_s[-1][-1])

    def begin(self, way: Trajectory | Driven) -> None:
        """Take the level that the way begins with."""
        self.times_s, self.levels_s = [way.times_s[:1]], [np.full(1, self._full_s * way.battery)]
        if not self._begun and way.charges and way.charges[0].from_s == way.times_s[0]:
            self._stood = (way.charges[0].charger, 0.0)
        self._begun = len(way.times_s) > 1
        if len(way.times_s) == 1:
            self._take_off(0.0)

    def follow(self, driven: Driven) -> None:
        """Follow what was driven before a plan took over, which is told from after its first take-off on."""
        self._in_air = True
        self.begin(driven)
        self.drive(driven, 0, len(driven.times_s) - 1, 0.0)
        self._left_s = self.level_s
        if len(driven.times_s) == 1:  # on a charger or not: who is off it has no more than a take-off leaves
            self._in_air, self._left_s = False, self._full_s

    def _take_off(self, time_s: float) -> None:
        """Take what it costs to leave the ground; who does as a plan takes over has no more than that leaves."""
        cost_s = self._robot.battery.departure_s
        if cost_s > 0 and not self._in_air:
            level_s = self.level_s if math.isfinite(self._left_s) else self.level_s - cost_s
            self.times_s.append(np.full(1, time_s))
            self.levels_s.append(np.full(1, min(level_s, self._left_s - cost_s)))
        self._in_air = True

    def drive(self, way: Trajectory | Driven, low: int, high: int, late_s: float) -> None:
        """Follow the legs of a way from one index to another, driven so much later."""
        times_s, lasts_s = way.times_s, np.diff(way.times_s)
        ways_m, uses = np.sqrt((np.diff(way.positions_m, axis=0) ** 2).sum(axis=1)), self._robot.battery.standing_uses
        slow = ways_m <= SLOW_SHARE * self._robot.speed_m_s * lasts_s  # it takes what standing does, and driving
        used_s = np.where(slow, np.where(ways_m > STILL_M, max(uses, 1.0), uses), 1.0) * lasts_s
        for begin, end, charge in _stretches(way, low, high):
            if charge is None:
                self._stood = ("", 0.0)
                self._take_off(float(times_s[begin] + late_s))
                level_s = self.level_s
                self.times_s.append(times_s[begin + 1 : end + 1] + late_s)
                self.levels_s.append(level_s - np.cumsum(used_s[begin:end]))
            else:
                self._in_air = False
                ends_s = float(times_s[end])
                stays_s = charge.until_s - ends_s + stays_on_s(way, charge, self._robot.battery.climbing_s)
                ends_s += late_s
                self._charge(charge.charger, float(times_s[begin] + late_s), ends_s, ends_s + stays_s)
            self._left_s = math.inf

    def _charge(self, charge: str, begin_s: float, end_s: float, leaves_s: float) -> None:
        """Follow a stay at a charger, or a part of it: it lands, charges and climbs, until it leaves in the end."""
        level_s, charger, battery = self.level_s, self._chargers[charge], self._robot.battery
        before_s = self._stood[1] if self._stood[0] == charge else -battery.landing_s
        self._stood = (charge, before_s + end_s - begin_s)
        if before_s < 0:
            begin_s, before_s = min(begin_s - before_s, end_s), 0.0
            self.times_s.append(np.full(1, begin_s))
            self.levels_s.append(np.full(1, level_s))
        last_s, end_s = end_s, min(end_s, max(leaves_s - battery.climbing_s, begin_s))
        full_s = begin_s + _full_after_s(level_s, self._robot, charger, before_s)
        charged_s = (end_s - begin_s) * self._full_s / (self._robot.battery.recharge_s or math.inf)
        if charger.swap_s is not None:
            charged_s = 0.0
        if full_s < end_s:  # a swap fills it all at once
            before_it_s = level_s if charger.swap_s is not None else self._full_s
            self.times_s.append(np.full(2, full_s))
            self.levels_s.append(np.array([before_it_s, self._full_s]))
            level_s, charged_s = self._full_s, 0.0
        self.times_s.append(np.full(1, end_s))
        self.levels_s.append(np.full(1, level_s + charged_s))
        if end_s < last_s:
            self.times_s.append(np.full(1, last_s))
            self.levels_s.append(np.full(1, level_s + charged_s))


def _stretches(way: Trajectory | Driven, low: int, high: int) -> Iterator[tuple[int, int, Charge | None]]:
    """The legs from one index to another, cut where charges begin and end: from, to, and the charge, if any."""
    for charge in way.charges:
        begin, end = (int(k) for k in np.searchsorted(way.times_s, (charge.from_s, charge.until_s)))
        begin, end = max(begin, low), min(end, high)
        if begin < end:
            if low < begin:
                yield low, begin, None
            yield begin, end, charge
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
    """Batteries below their reserve, charges away from chargers, and chargers with more robots than places.

    A plan that took over is judged with what was driven before: batteries are no fuller than that leaves them.
    """
    if not any(plan.mission.fleet.robot(one.robot).battery.endurance_s or one.charges for one in plan):
        return []
    chargers = {charger.name: charger for charger in plan.mission.chargers}
    driven = () if plan.seam is None else plan.seam.driven
    violations = [found for one in (*plan, *driven) for found in _away_from_charger(one, chargers)]
    for one in plan:
        robot, before = plan.mission.fleet.robot(one.robot), _way_before(plan, one.robot)
        if robot.battery.endurance_s is None:
            continue
        violations += _below_reserve(one, robot, battery_levels(plan, one))
        if before is not None:
            violations += _fuller_than_driven(one, robot, level_after_s(plan, before))
    return [*violations, *crowded_violations(plan), *hasty_violations(plan)]


def _fuller_than_driven(trajectory: Trajectory, robot: Robot, left_s: float) -> list[Violation]:
    """A battery that is told to be fuller where the plan takes over than what was driven before leaves it."""
    told_s = trajectory.battery * (robot.battery.endurance_s or math.inf)
    if told_s <= left_s + BATTERY_S:
        return []
    kind: ViolationKind = "battery fuller than what was driven leaves"
    return [violation(kind, trajectory.robot, trajectory.positions_m[0, :2], 0.0, told_s, left_s, "s")]


def _away_from_charger(trajectory: Trajectory | Driven, chargers: dict[str, Charger]) -> list[Violation]:
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
        time_s = float(levels.times_s[k])
        if k:
            share = (levels.levels_s[k - 1] - reserve_s) / (levels.levels_s[k - 1] - levels.levels_s[k])
            time_s = float(levels.times_s[k - 1] + max(share, 0.0) * (time_s - levels.times_s[k - 1]))
        rises = np.flatnonzero(np.diff(levels.levels_s[k:]) > 0)
        least_s = levels.levels_s[k : k + int(rises[0]) + 1 if len(rises) else None].min()
        return [violation(kind, trajectory.robot, trajectory.at(time_s), time_s, least_s, reserve_s, "s")]
    if levels.falls_s > BATTERY_S * min(1.0, trajectory.loop_duration_s):  # of rounds of a moment a share of that
        rounds = math.ceil((float(levels.levels_s.min()) - reserve_s) / levels.falls_s)
        time_s = float(levels.times_s[-1]) + max(rounds - 1, 0) * trajectory.loop_duration_s
        end_m = trajectory.positions_m[-1]
        return [
            violation("takes more than it charges", trajectory.robot, end_m, time_s, levels.falls_s, 0.0, "s a round")
        ]
    return []

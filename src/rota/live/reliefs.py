"""Reliefs while robots fly: who stays on its charger, who leaves it, and who holds its post until it is relieved.

A robot leaves its charger when the clock of all says so, if its battery holds what its next flight takes by plan and
the reserve. Until it does it is a late relief: the clock of its team stands still, and its robots in the air hold their
posts. Who has no more left than its way to its charger takes, with a little to spare, goes on by plan.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rota.links.link import Dock
from rota.live.notices import Notice, NoticeKind, RobotState
from rota.model.fleet import Robot
from rota.model.limits import KEPT_SHARE
from rota.model.plan import Plan, Trajectory
from rota.routes.charging_legs import ChargingLegs, charging_legs

AT_CHARGER_M = 2.0  # from it, within which a robot comes to it, and from where it stood, beyond which it has left
SOON_S = 5.0  # by which a robot may be there before the plan has it
TOLD_SHARE = 0.01  # of a battery, to which many robots tell their charge
AHEAD_S = 1.0  # of the clock of all, from which on it is told that a robot does not wait
FLYING_MODES = (None, "ready", "running")


@dataclass(frozen=True, kw_only=True)
class Conduct:
    """What robots are to do. docks: of those on chargers; lags_s: how far each of them is behind its plan.

    hurried: those in the air whose batteries do not let them wait. late: reliefs for which all others wait.
    """

    docks: dict[str, Dock] = field(default_factory=dict)
    lags_s: dict[str, float] = field(default_factory=dict)
    hurried: frozenset[str] = frozenset()
    late: tuple[str, ...] = ()


@dataclass
class _Stay:
    """A robot on its charger until the plan has it leave, with what it needs then.

    left_m: where it was when it was told to leave; None: it was not. climbs_until_s: when it is to be ready to go then.
    """

    charger: int
    leaves_s: float
    needs_s: float
    left_m: tuple[float, float] | None = None
    climbs_until_s: float = math.inf
    told_late_s: float | None = None


class _Flyer:
    """One robot that charges: its legs, and on which charger it is."""

    def __init__(self, way: Trajectory, robot: Robot, legs: ChargingLegs) -> None:
        self.robot, self.legs, self._way = robot, legs, way
        self.told_hurried = False
        leg, turned_s = self.leg_at(0.0)
        self.stay = self.stay_of(leg, turned_s) if legs.docks[leg] >= 0 else None

    def leg_at(self, planned_s: float) -> tuple[int, float]:
        """The leg at a moment of the plan, and by how much later than in the first round."""
        way, turned_s = self._way, 0.0
        if way.loop_duration_s > 0:
            turned_s = max(0.0, math.floor((planned_s - way.loop_start_s) / way.loop_duration_s)) * way.loop_duration_s
        leg = int(np.searchsorted(self.legs.ends_s, planned_s - turned_s, side="right"))
        return min(leg, len(self.legs.ends_s) - 1), turned_s

    def stay_of(self, leg: int, turned_s: float) -> _Stay:
        """The stay on a charger that a leg is a part of."""
        legs = self.legs
        return _Stay(int(legs.docks[leg]), float(legs.leaves_s[leg]) + turned_s, float(legs.needs_s[leg]))

    def to_charger_s(self, planned_s: float) -> float:
        """What the battery has to give from a moment in the air until the robot is on a charger, by plan."""
        leg, turned_s = self.leg_at(planned_s)
        rest_s = self.legs.ends_s[leg] + turned_s - planned_s
        return float(self.legs.uses[leg] * rest_s + self.legs.needs_s[leg])


class Reliefs:
    """The reliefs of a plan. waited_for: the names of robots for which others hold their posts."""

    def __init__(self, plan: Plan, waited_for: frozenset[str]) -> None:
        self._chargers, self._waited_for = plan.mission.chargers, waited_for
        self._lead_s = 0.0
        self._flyers: dict[str, _Flyer] = {}
        for way in plan:
            robot = plan.mission.fleet.robot(way.robot)
            if way.charges:
                self._flyers[way.robot] = _Flyer(way, robot, charging_legs(way, robot, self._chargers))
        self._told: list[Notice] = []

    def look(
        self, now_s: float, robots: tuple[RobotState, ...], behind_of_s: Callable[[str], float], lead_s: float = 0.0
    ) -> tuple[Conduct, list[Notice]]:
        """What robots that charge are to do at ``now_s``; behind_of_s: how far a robot's clock is behind the plan's.

        lead_s: how long before it leaves a robot has to be told at least, since it has to climb first; the plan may
        have it climb for longer.
        """
        self._lead_s = lead_s
        made, hurried, late = Conduct(), set[str](), list[str]()
        for robot in robots:
            flyer = self._flyers.get(robot.name)
            if flyer is None or robot.standing == "lost" or robot.place_m is None or robot.mode not in FLYING_MODES:
                continue
            behind_s = behind_of_s(robot.name)
            self._come_and_go(now_s, flyer, robot)
            if flyer.stay is None:
                if self._hurries(now_s, flyer, robot, behind_s):
                    hurried.add(robot.name)
                continue
            made.docks[robot.name], is_late = self._on_charger(now_s, flyer, flyer.stay, robot, behind_s)
            if flyer.stay.left_m is None:
                made.lags_s[robot.name] = now_s - min(now_s - behind_s, flyer.stay.leaves_s)
            if is_late:
                late.append(robot.name)
        told, self._told = self._told, []
        return Conduct(docks=made.docks, lags_s=made.lags_s, hurried=frozenset(hurried), late=tuple(late)), told

    def _come_and_go(self, now_s: float, flyer: _Flyer, robot: RobotState) -> None:
        """Note that a robot has come to a charger, or has left it."""
        if flyer.stay is not None:
            stood_m, now_m = flyer.stay.left_m, robot.place_m
            if stood_m is not None and now_m is not None and math.dist(stood_m, now_m) > AT_CHARGER_M:
                self._tell(now_s, "takes off", robot, f"leaves {self._chargers[flyer.stay.charger].name}")
                flyer.stay = None
            return
        leg, turned_s = flyer.leg_at(now_s - robot.lag_s + SOON_S)
        number = int(flyer.legs.docks[leg])
        if number >= 0 and self._off_m(robot, number) <= AT_CHARGER_M:
            flyer.stay, flyer.told_hurried = flyer.stay_of(leg, turned_s), False
            self._tell(now_s, "lands", robot, f"is at {self._chargers[number].name}")

    def _on_charger(
        self, now_s: float, flyer: _Flyer, stay: _Stay, robot: RobotState, behind_s: float
    ) -> tuple[Dock, bool]:
        """Whether a robot on its charger is to leave it, and whether it is late."""
        full_s, clock_s = flyer.robot.battery.endurance_s, now_s - behind_s
        left_s = math.inf if robot.battery is None or full_s is None else robot.battery * full_s
        enough_s = min(stay.needs_s + flyer.robot.battery.reserve_s, full_s or 0.0)
        ready = left_s >= enough_s - TOLD_SHARE * (full_s or 0.0)
        lead_s = max(self._lead_s, flyer.robot.battery.climbing_s)
        if stay.left_m is None and ready and clock_s >= stay.leaves_s - lead_s:
            stay.left_m = robot.place_m
            stay.climbs_until_s = now_s + lead_s
            if stay.told_late_s is not None:
                late_s = now_s - stay.told_late_s
                self._told.append(
                    _notice(now_s, "relief comes", robot.name, f"{robot.name} comes, {late_s:.0f} s late")
                )
        # one that is late is waited for while it climbs, but not for ever if it does not leave
        climbs = stay.told_late_s is not None and now_s < stay.climbs_until_s
        late = (stay.left_m is None or climbs) and clock_s >= stay.leaves_s
        if late and stay.told_late_s is None:
            stay.told_late_s = now_s
            held = "robots hold their posts as long as their batteries let them"
            then = held if robot.name in self._waited_for else "nobody holds a post for it, and the others go on"
            text = (
                f"{robot.name} is late: its next flight takes a battery of {enough_s:.0f} s, {left_s:.0f} s are there"
            )
            self._told.append(_notice(now_s, "relief late", robot.name, f"{text}; {then}"))
        return Dock(leaves=stay.left_m is not None, plan_s=stay.leaves_s), late

    def _hurries(self, now_s: float, flyer: _Flyer, robot: RobotState, behind_s: float) -> bool:
        """Whether a robot in the air has nothing left to wait with; one that tells no battery does not wait."""
        full_s = flyer.robot.battery.endurance_s
        if full_s is None:
            return False
        left_s, reserve_s = (robot.battery or 0.0) * full_s, flyer.robot.battery.reserve_s
        needs_s = flyer.to_charger_s(now_s - robot.lag_s)
        hurries = left_s - reserve_s <= (1 + KEPT_SHARE) * needs_s
        if hurries and not flyer.told_hurried and robot.lag_s < behind_s - AHEAD_S:
            flyer.told_hurried = True
            told = f"{left_s:.0f} s are left; its way to its charger and its reserve take {needs_s + reserve_s:.0f} s"
            if robot.battery is None:
                told = "its battery is not known"
            text = f"{robot.name} does not wait any longer: {told}"
            self._told.append(_notice(now_s, "does not wait", robot.name, text))
        return hurries

    def _off_m(self, robot: RobotState, charger: int) -> float:
        return math.inf if robot.place_m is None else math.dist(robot.place_m, self._chargers[charger].at)

    def _tell(self, now_s: float, kind: NoticeKind, robot: RobotState, what: str) -> None:
        charge = "" if robot.battery is None else f", its battery at {robot.battery:.0%}"
        self._told.append(_notice(now_s, kind, robot.name, f"{robot.name} {what}{charge}"))


def _notice(now_s: float, kind: NoticeKind, about: str, text: str) -> Notice:
    return Notice(time_s=now_s, kind=kind, about=about, text=text)

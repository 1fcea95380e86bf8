"""Robots as they are when a plan takes over, and how they come into a round of flights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Charger, Robot
from rota.model.plan import Trajectory
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.tolerances import SAME_ROUND
from rota.routes.charging_legs import charging_legs


@dataclass(frozen=True, kw_only=True, eq=False)
class Transfer:
    """How a robot that lands on one charger goes on to another, by ``way``, from ``leaves_s`` on or later.

    level_s: with how much left it comes there then. fills_s: how long charging for the way takes there.
    """

    charger: Charger
    way: TimedLine
    leaves_s: float
    level_s: float
    fills_s: float

    def by(self, ready_s: float) -> float:
        """When it leaves to be charged again at a time, as late as can be: its place there may not be free sooner."""
        return max(self.leaves_s, ready_s - self.fills_s - self.way.duration_s)


@dataclass(frozen=True, kw_only=True, eq=False)
class Flyer:
    """A robot when the plan takes over: where, (2,) metres, with how much left, and on which charger; None: on none.

    lands: the rest of its flight, as it drives it whatever follows, of a robot that cannot turn or change its speed at
    once; the place, the level and the charger are those at its end. None: it can go anywhere at once. transfers: what
    it can drive on from there to other chargers. lands_s, climbs_s: how long it has still to land on the charger on
    which it is, and to climb before it can leave that.
    """

    robot: Robot
    place_m: Floats
    level_s: float
    charger: Charger | None
    lands: TimedLine | None = None
    transfers: tuple[Transfer, ...] = ()
    lands_s: float = 0.0
    climbs_s: float = 0.0

    def level_after_s(self, level_s: Floats | float, stays_s: Floats, charger: Charger) -> Floats:
        """The level after so many seconds of charging at a charger; nan for less than none."""
        full_s = self.robot.battery.endurance_s or math.inf
        if charger.swap_s is not None:
            after_s = np.where(stays_s > charger.swap_s, full_s, level_s)
        else:
            fill = full_s / (self.robot.battery.recharge_s or math.inf)
            after_s = np.minimum(level_s + fill * stays_s, full_s)
        return np.where(stays_s >= 0, after_s, np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class Arrival:
    """How a robot comes into a round: so far round at ``joins_s``, from ``leaves_s`` on, by way of a charger, if any.

    unserved_s: how long nobody flies in its place until then; inf: it never can, as by default. enters: the way from
    its charger on which a robot comes into the round as that moves, perhaps to the end of the flight; None: on a
    charger, or as it can at once.
    """

    joins_s: float = math.inf
    phase_s: float = 0.0
    leaves_s: float = 0.0
    via: Charger | None = None
    unserved_s: float = math.inf
    enters: TimedLine | None = None


def fills_s(robot: Robot, charger: Charger, level_s: float) -> float:
    """How long a robot charges at a charger to have so much more left."""
    if level_s == 0:
        return 0.0
    if charger.swap_s is not None:
        return charger.swap_s * (1 + SAME_ROUND)
    return level_s * (robot.battery.recharge_s or math.inf) / (robot.battery.endurance_s or math.inf)


def flight_left(way: Trajectory, robot: Robot, chargers: Sequence[Charger]) -> tuple[TimedLine, float, Charger]:
    """What is flown of a trajectory until it is at a charger, for how long that takes of the battery, and the charger.

    The trajectory charges, and begins at none.
    """
    rows = int(np.searchsorted(way.times_s, way.charges[0].from_s)) + 1
    changes = np.zeros(rows - 1) if way.accelerations_m_s2 is None else way.accelerations_m_s2[: rows - 1]
    left = TimedLine(way.times_s[:rows], way.positions_m[:rows, :2], changes)
    used_s = charging_legs(way, robot, tuple(chargers)).uses[: rows - 1] * np.diff(left.times_s)
    charger = next(one for one in chargers if one.name == way.charges[0].charger)
    return left, float(used_s.sum()), charger

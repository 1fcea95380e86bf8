"""Robots that cannot stand, as wings: away from chargers they move all the time."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from rota.check.arrays import Flags
from rota.check.charging import docked_rows
from rota.check.report import Violation, violation
from rota.check.tolerances import SAME_TIME, SLOW_SHARE, SLOW_TIME, STILL_M
from rota.model.mission import Robot
from rota.model.plan import Plan, Trajectory


def standing_violations(plan: Plan) -> list[Violation]:
    """Where robots whose ``standing_endurance_s`` is 0 first stand away from chargers, and for how long.

    One that would stand for ever does for as long as a full battery lasts. Legs slower than a thousandth of a robot's
    speed are stays, too, once they take a hundredth of the time away from chargers: before, they are how it gets up
    speed. How slowly above that it can fly is not judged.
    """
    robots = [(one, plan.mission.fleet.robot(one.robot)) for one in plan]
    return [found for one, robot in robots if not robot.battery.can_stand for found in _first_stand(one, robot)]


def _first_stand(trajectory: Trajectory, robot: Robot) -> Iterator[Violation]:
    """The first stay away from a charger of a trajectory, if there is one; one that ends elsewhere stays for ever."""
    times_s, places_m = trajectory.times_s, trajectory.positions_m[:, :2]
    moves = ~_stays(trajectory, robot.speed_m_s)
    begins = np.flatnonzero(~moves)
    begin = int(begins[0]) if len(begins) else len(moves)
    ends = np.flatnonzero(moves[begin:])
    until_s = float(times_s[begin + int(ends[0])]) if len(ends) else float(times_s[-1])
    if trajectory.loop_duration_s == 0 and not len(ends):
        if trajectory.charges and trajectory.charges[-1].until_s == times_s[-1]:
            return
        until_s = float(times_s[begin]) + (robot.battery.endurance_s or math.inf)
    if until_s > times_s[begin]:
        stands_s = until_s - float(times_s[begin])
        yield violation(
            "stands though it cannot", trajectory.robot, places_m[begin], times_s[begin], stands_s, 0.0, "s"
        )


def _stays(trajectory: Trajectory, speed_m_s: float) -> Flags:
    """Which legs (n - 1,) away from chargers are stays, of the way there and of the loop each by itself."""
    lasts_s = np.diff(trajectory.times_s)
    ways_m = np.hypot(*np.diff(trajectory.positions_m[:, :2], axis=0).T)
    away = ~docked_rows(trajectory.times_s, trajectory.charges)
    slow = away & (ways_m <= SLOW_SHARE * speed_m_s * lasts_s)
    found = np.zeros(len(lasts_s), np.bool_)
    for part in (slice(0, trajectory.loop_index), slice(trajectory.loop_index, None)):
        away_s = lasts_s[part][away[part]].sum()
        # legs of no length that rounding leaves are of next to no time
        for which, share in ((slow & (ways_m <= STILL_M), SAME_TIME), (slow, SLOW_TIME)):
            if lasts_s[part][which[part]].sum() > share * away_s:
                found[part] |= which[part]
    return found

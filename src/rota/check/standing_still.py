"""Robots that cannot stand, as wings: away from chargers they move all the time."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from rota.check.charging import docked_rows
from rota.check.report import Violation, violation
from rota.check.tolerances import STILL_M
from rota.model.plan import Plan, Trajectory


def standing_violations(plan: Plan) -> list[Violation]:
    """Where robots whose ``standing_endurance_s`` is 0 first stand away from chargers, and for how long.

    One that would stand for ever does for as long as a full battery lasts.
    """
    robots = [(one, plan.mission.fleet.robot(one.robot).battery) for one in plan]
    return [
        found
        for one, battery in robots
        if not battery.can_stand
        for found in _first_stand(one, battery.endurance_s or math.inf)
    ]


def _first_stand(trajectory: Trajectory, for_ever_s: float) -> Iterator[Violation]:
    """The first stay away from a charger of a trajectory, if there is one; one that ends elsewhere stays for ever."""
    times_s, places_m = trajectory.times_s, trajectory.positions_m[:, :2]
    moves = (np.hypot(*np.diff(places_m, axis=0).T) > STILL_M) | docked_rows(times_s, trajectory.charges)
    begins = np.flatnonzero(~moves)
    begin = int(begins[0]) if len(begins) else len(moves)
    ends = np.flatnonzero(moves[begin:])
    until_s = float(times_s[begin + int(ends[0])]) if len(ends) else float(times_s[-1])
    if trajectory.loop_duration_s == 0 and not len(ends):
        if trajectory.charges and trajectory.charges[-1].until_s == times_s[-1]:
            return
        until_s = float(times_s[begin]) + for_ever_s
    if until_s > times_s[begin]:
        stands_s = until_s - float(times_s[begin])
        yield violation(
            "stands though it cannot", trajectory.robot, places_m[begin], times_s[begin], stands_s, 0.0, "s"
        )

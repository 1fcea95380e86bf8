"""Robots that take no part all the time: while they are away they stand, and what they have in range is not seen."""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Floats
from rota.check.report import Violation, violation
from rota.check.routes import TRANSIENT, Routes
from rota.check.tolerances import SAME_TIME, TOUCH_M
from rota.model.plan import Plan


def away_times_s(plan: Plan) -> tuple[Floats, Floats]:
    """When the robot of each trajectory joins and when it leaves (inf: never), (k,) each."""
    robots = [plan.mission.fleet.robot(trajectory.robot) for trajectory in plan]
    leaves = [math.inf if robot.leaves_s is None else robot.leaves_s for robot in robots]
    return np.array([robot.joins_s for robot in robots]), np.array(leaves)


def seeing_routes(routes: Routes, plan: Plan) -> Routes:
    """The legs on which robots see.

    A robot that leaves sees nothing, since plans are for ever. No leg counts that begins before its robot joins. Loops
    are kept: ``presence_violations`` finds those that begin too early.
    """
    joins, leaves = away_times_s(plan)
    if (joins == 0).all() and np.isinf(leaves).all():
        return routes
    early = (joins - _slack_s(joins))[routes.robots]
    seeing = np.isinf(leaves)[routes.robots] & ((routes.kinds != TRANSIENT) | (routes.times_s[:, 0] >= early))
    return routes.legs(seeing)


def presence_violations(plan: Plan) -> list[Violation]:
    """Robots that move while they are away, and those whose loop begins before they join."""
    violations = []
    joins, leaves = away_times_s(plan)
    for trajectory, join_s, leave_s in zip(plan, joins, leaves, strict=True):
        if join_s == 0 and math.isinf(leave_s):
            continue
        times, places = trajectory.times_s, trajectory.positions_m[:, :2]
        ways = np.hypot(*np.diff(places, axis=0).T)
        early_s = float(join_s - _slack_s(join_s))
        away = (times[:-1] < early_s) | (times[1:] > leave_s + _slack_s(leave_s))
        if math.isfinite(leave_s):
            away |= times[:-1] >= trajectory.loop_start_s  # for ever
        moves = np.flatnonzero(away & (ways > TOUCH_M))
        if len(moves):
            k = int(moves[0])
            violations.append(violation("moves while away", trajectory.robot, places[k], times[k], ways[k], 0.0, "m"))
        start_s = trajectory.loop_start_s
        if start_s < early_s:
            violations.append(
                violation("sees before it joins", trajectory.robot, places[-1], start_s, start_s, join_s, "s")
            )
    return violations


def _slack_s(times_s: Floats | float) -> Floats:
    """What float64 needs for times that are multiples of a step."""
    return np.asarray(SAME_TIME * np.maximum(1.0, np.where(np.isfinite(times_s), times_s, 0.0)))

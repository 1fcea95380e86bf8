"""Whether robots go on from where, and as, they were driving when a plan took over from another one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.check.accelerations import acceleration_violations
from rota.check.report import Violation, violation
from rota.check.tolerances import SAME_TIME, TOUCH_M
from rota.check.turning import turn_radius_violations, turn_violations
from rota.model.mission import Robot
from rota.model.plan import Charge, Driven, Plan, Trajectory

ROWS = 12  # on either side of the change: enough for what a corner or a jump of speed takes of the legs beside it


def seam_violations(plan: Plan) -> list[Violation]:
    """What is wrong where the plan takes over.

    Robots that drove before are lost, or in the plan, and begin where they were. What they do then they can do from how
    they were driving: they turn, and change speed, as anywhere else.
    """
    if plan.seam is None:
        return []
    violations, here = [], {trajectory.robot: trajectory for trajectory in plan}
    for driven in plan.seam.driven:
        if driven.robot in plan.seam.lost:
            continue
        was = driven.positions_m[-1]
        if driven.robot not in here:
            violations.append(violation("no trajectory", driven.robot, was, 0.0, 0.0, 1.0, "trajectories"))
            continue
        trajectory, robot = here[driven.robot], plan.mission.fleet.robot(driven.robot)
        away_m = math.dist(was, trajectory.positions_m[0, :2])
        if away_m > TOUCH_M:
            violations.append(violation("start", driven.robot, was, 0.0, away_m, TOUCH_M, "m"))
        elif not robot.turns_at_once:
            violations += _violations_across(driven, trajectory, robot)
    return violations


def judged_until_s(trajectory: Trajectory) -> float:
    """Until when curves and changes of speed of a robot that drove before are judged with what it drove.

    Alone, the leg that the change cuts would leave less room beside a corner than there is.
    """
    return float(trajectory.times_s[min(ROWS, len(trajectory.times_s) - 1)])


def _violations_across(driven: Driven, trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Turns and changes of speed about the moment of the change that the robot cannot drive."""
    before_s = driven.times_s[-ROWS:]
    lasts_s = -float(before_s[0])
    if (np.diff(trajectory.times_s + lasts_s) <= 0).any():  # a leg so short that it is no leg a little later
        return [violation("turn", robot.name, trajectory.positions_m[0, :2], 0.0, 0.0, SAME_TIME, "s")]
    given = [driven.accelerations_m_s2, trajectory.accelerations_m_s2]
    legs = [len(before_s) - 1, len(trajectory.times_s) - 1]
    changes = [
        np.zeros(count) if own is None else own[len(own) - count :] for own, count in zip(given, legs, strict=True)
    ]
    joined = replace(
        trajectory,
        times_s=np.concatenate([before_s[:-1] + lasts_s, trajectory.times_s + lasts_s]),
        positions_m=np.vstack([driven.positions_m[-ROWS:-1], trajectory.positions_m[:, :2]]),
        accelerations_m_s2=None if all(own is None for own in given) else np.concatenate(changes),
        headings_rad=None,
        waypoints=None,
        loop_start_s=trajectory.loop_start_s + lasts_s,
        charges=_charges_across(driven, trajectory, -lasts_s),
    )
    ends_s = lasts_s + judged_until_s(trajectory)
    turns, found = turn_violations(joined, robot), turn_radius_violations(joined, robot)
    found += acceleration_violations(joined, robot)
    # a turn that was under way is told of where it began
    moved = np.flatnonzero((np.diff(joined.positions_m[: len(before_s)], axis=0) != 0).any(axis=1))
    since_s = float(joined.times_s[moved[-1] + 1]) if len(moved) else lasts_s
    slack_s = SAME_TIME * max(1.0, lasts_s)
    return [
        replace(one, time_s=max(0.0, one.time_s - lasts_s))
        for own, until_s in ((turns, lasts_s), (found, ends_s))
        for one in own
        if one.time_s is not None and since_s - slack_s <= one.time_s <= until_s + slack_s
    ]


def _charges_across(driven: Driven, trajectory: Trajectory, from_s: float) -> tuple[Charge, ...]:
    """The charges of what was driven from a moment on, and of the trajectory, with times from that moment on."""
    before = [replace(one, from_s=max(one.from_s, from_s)) for one in driven.charges if one.until_s > from_s]
    return tuple(
        replace(one, from_s=one.from_s - from_s, until_s=one.until_s - from_s) for one in (*before, *trajectory.charges)
    )

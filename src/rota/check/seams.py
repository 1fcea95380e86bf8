"""Whether robots go on from where, and as, they were driving when a plan took over from another one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.check.accelerations import acceleration_violations
from rota.check.report import Violation, few_of_each_kind, violation
from rota.check.tolerances import SAME_TIME, TOUCH_M
from rota.check.turning import turn_radius_violations, turn_violations
from rota.errors import PlanError
from rota.model.mission import Robot
from rota.model.plan import Charge, Driven, Plan, Trajectory


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


def _violations_across(driven: Driven, trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Turns about the moment of the change, and curves and changes of speed ever after, that the robot cannot drive.

    What was driven before is believed: a fault in it is told if it would be none had the robot gone straight on.
    """
    before = _Before(driven, trajectory)
    try:
        joined = before.goes_on(trajectory)
    except PlanError:  # so long ago, or legs so short, that they are none a little later
        return [violation("turn", robot.name, trajectory.positions_m[0, :2], 0.0, 0.0, SAME_TIME, "s")]
    from_rest, slack_s = before.lasts_s == 0, SAME_TIME * max(1.0, before.lasts_s)
    own: set[tuple[str, float | None]] = set()
    if not from_rest:
        straight = before.goes_on(before.straight_on())
        own = {(one.kind, one.time_s) for one in turn_violations(straight, robot) + before.curves(straight, robot)}
    # turns later on are told of the trajectory alone
    turns = [one for one in turn_violations(joined, robot) if (one.time_s or 0.0) <= before.lasts_s + slack_s]
    return few_of_each_kind(
        replace(one, time_s=max(0.0, one.time_s - before.lasts_s))
        for one in turns + before.curves(joined, robot)
        if one.time_s is not None and (one.time_s >= before.lasts_s - slack_s or (one.kind, one.time_s) not in own)
    )


class _Before:
    """What a robot drove before a plan took over, for ``lasts_s``, up to where its trajectory begins."""

    def __init__(self, driven: Driven, trajectory: Trajectory) -> None:
        self._driven, self._times_s = driven, driven.times_s
        self.lasts_s = -float(self._times_s[0])
        self._places_m = np.vstack([driven.positions_m[:-1], trajectory.positions_m[:1, :2]])
        own = driven.accelerations_m_s2
        self._changes_m_s2 = np.zeros(len(self._times_s) - 1) if own is None else own

    def straight_on(self) -> Trajectory:
        """From where it was on, as fast as it was: for so long that nothing before depends on how that ends."""
        lasts_s, way_m = float(np.diff(self._times_s[-2:])[0]), np.diff(self._places_m[-2:], axis=0)[0]
        velocity_m_s = way_m / lasts_s * (1 + self._driven.bends[-1])
        places_m = self._places_m[-1] + np.array([[0.0], [100.0]]) * velocity_m_s
        return Trajectory(
            robot=self._driven.robot, times_s=np.array([0.0, 100.0]), positions_m=places_m, loop_start_s=100.0
        )

    def curves(self, joined: Trajectory, robot: Robot) -> list[Violation]:
        """Curves and changes of speed that the robot cannot drive, of what was driven and what follows."""
        from_rest, seam = self.lasts_s == 0, len(self._times_s) - 1
        found = turn_radius_violations(joined, robot, begins_whole=from_rest)
        return found + acceleration_violations(joined, robot, from_rest=from_rest, seam=seam)

    def goes_on(self, trajectory: Trajectory) -> Trajectory:
        """What was driven and then the trajectory; PlanError where times cannot be told from one another."""
        times_s = np.concatenate([self._times_s[:-1], trajectory.times_s]) + self.lasts_s
        places_m = np.vstack([self._places_m[:-1], trajectory.positions_m[:, :2]])
        changes_m_s2 = None
        if self._driven.accelerations_m_s2 is not None or trajectory.accelerations_m_s2 is not None:
            given = trajectory.accelerations_m_s2
            given = np.zeros(len(trajectory.times_s) - 1) if given is None else given
            # a leg from or to rest is so with the times as they are now, and from where it is said to begin
            with np.errstate(divide="ignore", invalid="ignore"):
                most_m_s2 = 2 * np.hypot(*np.diff(places_m, axis=0).T) / np.diff(times_s) ** 2
            changes_m_s2 = np.clip(np.concatenate([self._changes_m_s2, given]), -most_m_s2, most_m_s2)
        return replace(
            trajectory,
            times_s=times_s,
            positions_m=places_m,
            accelerations_m_s2=changes_m_s2,
            headings_rad=None,
            waypoints=None,
            loop_start_s=trajectory.loop_start_s + self.lasts_s,
            charges=_charges_across(self._driven, trajectory, -self.lasts_s),
        )


def _charges_across(driven: Driven, trajectory: Trajectory, from_s: float) -> tuple[Charge, ...]:
    """The charges of what was driven from a moment on, and of the trajectory, with times from that moment on."""
    before = [replace(one, from_s=max(one.from_s, from_s)) for one in driven.charges if one.until_s > from_s]
    return tuple(
        replace(one, from_s=one.from_s - from_s, until_s=one.until_s - from_s) for one in (*before, *trajectory.charges)
    )

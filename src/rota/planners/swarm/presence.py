"""What changes at which step of a mission: robots that join later or leave, and obstacles that come to a stand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.model.arrays import Flags
from rota.model.mission import Mission
from rota.model.plan import Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.rollout import Swarm

TOLERANCE = 1e-9  # of a step; times that are meant to be those of steps are


class Presence:
    """When the mission's robots join and leave, in steps; ``last_change`` is the step before which all have."""

    def __init__(self, mission: Mission) -> None:
        step_s = SwarmSettings.of(mission).time_step_s
        robots = mission.fleet.robots or ()
        # a robot moves in whole steps only, none of which begins before it joins or ends after it leaves
        self._joins = np.array([math.ceil(robot.joins_s / step_s - TOLERANCE) for robot in robots])
        ends = [math.inf if robot.leaves_s is None else robot.leaves_s / step_s for robot in robots]
        self._leaves = np.array([math.floor(end + TOLERANCE) if math.isfinite(end) else end for end in ends])
        changes = np.concatenate([self._joins, self._leaves[np.isfinite(self._leaves)], [0]])
        self.last_change = int(changes.max())

    def at(self, step: int) -> Flags:
        """Which robots take part in a step, (n,)."""
        return (self._joins <= step) & (step < self._leaves)

    def begin(self, swarm: Swarm) -> None:
        """Let those leave a new swarm that took no part in the step before; of step 0, in that one."""
        away = np.flatnonzero(~self.at(max(swarm.steps - 1, 0)))
        if len(away):
            swarm.leave(away)

    def update(self, swarm: Swarm) -> bool:
        """Let robots join and leave before the next step; whether any does."""
        if swarm.steps == 0 or swarm.steps > self.last_change:
            return False
        before, now = self.at(swarm.steps - 1), self.at(swarm.steps)
        joining, leaving = np.flatnonzero(now & ~before), np.flatnonzero(before & ~now)
        if len(leaving):
            swarm.leave(leaving)
        if len(joining):
            swarm.join(joining)
        return bool(len(joining) or len(leaving))


def last_motion(mission: Mission) -> int:
    """The step in which the last moving obstacle comes to a stand; 0 where none moves."""
    ends_s = [obstacle.times_s[-1] for obstacle in mission.moving_obstacles if len(obstacle.times_s) > 1]
    return math.ceil(max([0.0, *ends_s]) / SwarmSettings.of(mission).time_step_s - TOLERANCE)


def holding_from_joining(trajectories: tuple[Trajectory, ...], mission: Mission) -> tuple[Trajectory, ...]:
    """The same, but robots that join after their last point hold from then on, since before they see nothing."""
    return tuple(
        trajectory if robot.joins_s <= trajectory.loop_start_s else _holding_from(trajectory, robot.joins_s)
        for trajectory, robot in zip(trajectories, mission.fleet.robots or (), strict=True)
    )


def _holding_from(trajectory: Trajectory, time_s: float) -> Trajectory:
    """The trajectory with one point more at which the robot holds, from that time on."""
    return replace(
        trajectory,
        times_s=np.append(trajectory.times_s, time_s),
        positions_m=np.vstack([trajectory.positions_m, trajectory.positions_m[-1:]]),
        loop_start_s=time_s,
    )

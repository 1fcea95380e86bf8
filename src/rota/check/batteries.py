"""How full the batteries of a plan's robots are at any time, as its rounds repeat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota.check.arrays import Floats
from rota.check.charging import battery_levels
from rota.model.mission import Robot
from rota.model.plan import Plan, Trajectory


class Battery:
    """The battery of one robot with an endurance.

    From ``again_s`` on its levels repeat every ``round_s``; 0: they do not.

    A loop that begins at time 0 with a full battery has the levels of its second round from the beginning on: they
    repeat, and are no higher than those of the first, which begins so even in the midst of a flight.
    """

    def __init__(self, plan: Plan, trajectory: Trajectory, robot: Robot) -> None:
        levels = battery_levels(plan, trajectory)
        self.full_s = robot.battery.endurance_s or np.inf
        self.reserve_s = robot.battery.reserve_s
        self._times_s, self._levels_s = levels.times_s, levels.levels_s
        self.round_s, self._late_s = trajectory.loop_duration_s, 0.0
        if trajectory.loop_start_s == 0 and trajectory.battery == 1:
            self._late_s = self.round_s
        self.again_s = trajectory.loop_start_s + self.round_s - self._late_s

    def share_at(self, time_s: float) -> float:
        """The share of the battery that is left at a time."""
        _, shares = self.line(time_s)
        return float(shares[-1])

    def line(self, until_s: float) -> tuple[Floats, Floats]:
        """Times (n,) from 0 to ``until_s``, and the share that is left at each; it changes evenly between them.

        A battery that is swapped has two shares at one time.
        """
        known_s, levels_s = self._times_s - self._late_s, self._levels_s
        if self.round_s > 0:
            again = known_s >= self.again_s
            rounds = np.arange(np.ceil(max(until_s - self.again_s, 0.0) / self.round_s) + 1)[:, None] * self.round_s
            known_s = np.concatenate([known_s[~again], (known_s[again] + rounds).ravel()])
            levels_s = np.concatenate([levels_s[~again], np.tile(levels_s[again], len(rounds))])
        ends_s = np.interp([0.0, until_s], known_s, levels_s)
        inside = (known_s > 0) & (known_s < until_s)
        times_s = np.concatenate([[0.0], known_s[inside], [until_s]])
        return times_s, np.concatenate([ends_s[:1], levels_s[inside], ends_s[1:]]) / self.full_s


def batteries_of(plan: Plan) -> Sequence[Battery | None]:
    """The battery of each robot, in the plan's order; None for one without an endurance."""
    robots = [(trajectory, plan.mission.fleet.robot(trajectory.robot)) for trajectory in plan]
    return [None if robot.battery.endurance_s is None else Battery(plan, one, robot) for one, robot in robots]

"""From states on cells to trajectories: drives straight ahead, turns on the spot, and loops."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rota.model.mission import Mission
from rota.model.plan import Trajectory
from rota.planners.bounce.arrays import Floats, Ints
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.planner_settings import BounceSettings

MOST_JOINT_STEPS = 2_000  # of a common period, up to which its steps have durations of their own
SAME_PACE = 1e-9  # share by which two steps of one drive may differ


@dataclass(frozen=True, kw_only=True, eq=False)
class Pace:
    """How long steps last: ``longest_s``, a step in which a robot turns; ``move_s`` (m, k), a robot's moves alone."""

    longest_s: float
    move_s: Floats

    def own_s(self, states: Ints, headings: int) -> Floats:
        """(t, m) seconds that each robot needs for each step of joint states (t + 1, m)."""
        cell, heading = np.divmod(states, headings)
        moved = np.diff(cell, axis=0) != 0
        return np.where(moved, self.move_s[np.arange(states.shape[1]), heading[:-1]], self.longest_s)

    def times_s(self, states: Ints, headings: int) -> Floats:
        """(t + 1,) times of joint states (t + 1, m): each step lasts as long as the slowest robot needs.

        So all robots keep in step. They go straight from cell to cell in the same time, each at a constant speed.
        Contact was judged by two moves as one goes on, and so the judgement holds however long a step lasts.
        """
        lasts_s = self.own_s(states, headings).max(axis=1)
        times_s = np.zeros(len(states))
        for value in np.unique(lasts_s):  # counted, so that equal steps do not add up rounding
            times_s[1:] += value * np.cumsum(lasts_s == value)
        return times_s


def pace_of(mission: Mission, cells: Cells, count: int) -> Pace:
    """The pace of the mission's robots, or of ``count`` equal ones: moves at full speed, turns as the longest step.

    A robot that turns has bumped: it has been up to the obstacle and back, so that a turn takes the time of the longest
    move. Where clocks drift and are to keep a margin, moves take that time, too: the margin is judged in steps of equal
    length.
    """
    robots = mission.fleet.unlike_robots * count
    moves_m = np.hypot(*cells.moves.T) * cells.cell_m
    move_s = np.array([moves_m / robot.ground_speed_m_s for robot in robots])
    longest_s = step_duration_s(mission, cells)
    if BounceSettings.of(mission).clock_margin_s > 0:
        move_s = np.full_like(move_s, longest_s)
    return Pace(longest_s=longest_s, move_s=move_s)


def step_duration_s(mission: Mission, cells: Cells) -> float:
    """Seconds of the longest step: the longest move at the slowest robot's speed, and no less than any turn takes.

    Moves with more than 8 headings are a little off their headings, and so is the angle by which a robot turns.
    """
    robots = mission.fleet.unlike_robots
    steps = {1, *(round(angle * cells.headings / 360) for angle in BounceSettings.of(mission).bouncing_angles_deg)}
    true_rad = cells.headings_rad
    turns_rad = [float(((np.roll(true_rad, -count) - true_rad) % math.tau).max()) for count in steps]
    turning_s = [max(turns_rad) / robot.turn_rate_rad_s for robot in robots if robot.turn_rate_rad_s is not None]
    return max(cells.longest_move_m / min(robot.ground_speed_m_s for robot in robots), *turning_s, 0.0)


def trajectory(robot: str, cells: Cells, states: Ints, *, times_s: Floats, loop_from: int) -> Trajectory:
    """A robot's states (t + 1,) at ``times_s`` (t + 1,) as timed points; see the docstring of ``BounceSettings``.

    loop_from: the step from which the last states repeat; if it is the last step, the robot stays there. Headings are
    those of the cells' moves, in 0..2 pi: however long a loop is, none is a sum of turns.
    """
    cell, heading = np.divmod(states, cells.headings)
    places = cells.centres_m[cell]
    moves = np.diff(cell) != 0
    lasts_s = np.diff(times_s)
    # a drive goes on through points where nothing changes; so does waiting
    goes_on = (moves[:-1] == moves[1:]) & (heading[:-2] == heading[1:-1]) & (heading[1:-1] == heading[2:])
    goes_on &= ~moves[1:] | (np.abs(np.diff(lasts_s)) <= SAME_PACE * lasts_s[1:])
    kept = np.concatenate([[True], ~goes_on, [True]]) if len(states) > 1 else np.ones(1, np.bool_)
    kept[loop_from] = True
    return Trajectory(
        robot=robot,
        times_s=times_s[kept],
        positions_m=places[kept],
        headings_rad=cells.headings_rad[heading[kept]],
        loop_start_s=float(times_s[loop_from]),
    )

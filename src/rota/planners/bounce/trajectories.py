"""From states on cells to trajectories: drives straight ahead, turns on the spot, and loops."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.mission import Mission
from rota.plan import Trajectory
from rota.planners.bounce.cells import Cells

Ints = NDArray[np.int32]
Flags = NDArray[np.bool_]

LARGEST_RATIO = 64  # of two loops' numbers of steps, up to which a plan takes them as commensurable
LONGEST_LOOP = 100_000  # steps


def step_duration_s(mission: Mission, cells: Cells) -> float:
    """How long a step lasts: the longest move at the slowest robot's speed, and no less than any turn takes.

    Moves with more than 8 headings are a little off these, and so is what a robot turns by.
    """
    robots = mission.fleet.robots or (mission.fleet.equal_robot("robot-1"),)
    steps = {1, *(round(angle * cells.headings / 360) for angle in mission.bounce.bouncing_angles_deg)}
    true_rad = cells.headings_rad
    turns_rad = [float(((np.roll(true_rad, -count) - true_rad) % math.tau).max()) for count in steps]
    turning_s = [max(turns_rad) / robot.turn_rate_rad_s for robot in robots if robot.turn_rate_rad_s is not None]
    return max(cells.longest_move_m / min(robot.speed_m_s for robot in robots), *turning_s, 0.0)


def loops_in_step(lengths: Sequence[int]) -> list[int]:
    """How many steps each robot's loop is to have, for cycles of so many: a multiple of the cycle's length.

    Loops whose numbers of steps have a ratio of large numbers would count as independent of each other; all loops are
    as long as the common period then, unless that is longer than LONGEST_LOOP.
    """
    together = math.lcm(*lengths)
    fine = all(max(a, b) // math.gcd(a, b) <= LARGEST_RATIO for a in lengths for b in lengths)
    return list(lengths) if fine or together > LONGEST_LOOP else [together] * len(lengths)


def trajectory(
    robot: str, cells: Cells, states: Ints, *, step_s: float, loop_from: int, jumps: Flags | None = None
) -> Trajectory:
    """A robot's states (t + 1,), one for each step, as timed points; see the docstring of ``BounceSettings``.

    loop_from: the step from which on the last states repeat; the last one: the robot stays there. jumps: (t,) steps in
    which it turns by the clock, either way; other turns are counterclockwise. Headings are not wrapped, so a robot that
    has turned by 135 degrees three times faces 405 degrees more than before.
    """
    cell, heading = np.divmod(states, cells.headings)
    places = cells.centres_m[cell]
    turns = np.diff(cells.headings_rad[heading]) % math.tau
    if jumps is not None:
        turns = np.where(jumps & (turns > math.pi), turns - math.tau, turns)
    faced = np.concatenate([[0.0], np.cumsum(turns)]) + cells.headings_rad[heading[0]]
    moves = np.diff(cell) != 0
    # a drive goes on through points where nothing changes; so does waiting
    goes_on = (moves[:-1] == moves[1:]) & (heading[:-2] == heading[1:-1]) & (heading[1:-1] == heading[2:])
    kept = np.concatenate([[True], ~goes_on, [True]]) if len(states) > 1 else np.ones(1, np.bool_)
    kept[loop_from] = True
    return Trajectory(
        robot=robot,
        times_s=np.asarray(np.flatnonzero(kept) * step_s, np.float64),
        positions_m=places[kept],
        headings_rad=faced[kept],
        loop_start_s=loop_from * step_s,
    )

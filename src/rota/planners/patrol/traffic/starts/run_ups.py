"""Where robots with mass join their loops: they get up speed on a straight way to there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rota.geometry.kernels import EdgeGrid, free_segments
from rota.model.mission import Robot
from rota.planners.patrol.driving.round_starts import start_without_cut, steady_legs
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody


class Joining(NamedTuple):
    """A round from where its robot joins it, so much later than the round was to begin, and the start from rest."""

    line: TimedLine
    later_s: float
    run_up: TimedLine


def joining(line: TimedLine, robot: Robot, grid: EdgeGrid, *, steadily: bool = False) -> Joining:
    """Where and when a robot joins a round: at once without mass, else at the first row that it can run up to.

    A run-up is straight, in the direction of the leg after the row, and free of walls. Where none is, the robot joins
    at its slowest row all the same, and the check tells what is wrong. steadily: it leads to a leg at a constant
    velocity, if there is one: of a curve cut amid a leg the check tells a higher jerk.
    """
    at_once = Joining(line, 0.0, steady(np.zeros(1), line.places_m[:1]))
    if line.stays or not robot.motion.has_mass:
        return at_once
    driving = driving_with_mass(robot)
    steps, lasts_s = np.diff(line.places_m, axis=0), np.diff(line.times_s)
    lengths = np.hypot(*steps.T)
    speeds = np.where(lengths > 0, lengths / lasts_s - line.accelerations_m_s2 * lasts_s / 2, 0.0)
    units = steps / np.maximum(lengths, 1e-12)[:, None]
    run_ups = [driving.run_up(line.places_m[k], units[k], float(speeds[k])) for k in range(len(steps))]
    begins = np.array([way.places_m[0] for way in run_ups])
    free = free_segments(begins, line.places_m[:-1], grid) & (lengths > 0)
    if steadily and (level := free & steady_legs(line) & (lasts_s >= driving.step_s / 2)).any():
        free = level
    k = int(np.flatnonzero(free)[0]) if free.any() else int(np.argmin(np.where(lengths > 0, speeds, np.inf)))
    at_s = float(line.times_s[k])
    return Joining((start_without_cut if steadily else start_at)(line, at_s), at_s, run_ups[k])


def join_in_motion(
    begun: Sequence[TimedLine], robot: Robot, paths_by_body: PathsByBody, *, steadily: bool = False
) -> tuple[list[TimedLine], list[float], list[TimedLine]]:
    """The rounds from where robots join them, how much later that is, and how they get up speed; see ``joining``."""
    grid = paths_by_body.paths(robot.body_radius_m).grid
    joinings = [joining(line, robot, grid, steadily=steadily) for line in begun]
    return [one.line for one in joinings], [one.later_s for one in joinings], [one.run_up for one in joinings]

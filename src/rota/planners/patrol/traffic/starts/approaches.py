"""A robot's approach from its start to its loop, timed at full speed, and the trajectory that joins the two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.mission import Robot
from rota.plan import Trajectory
from rota.planners.patrol.tours.timetable import (
    SHORTEST_LEG_M,
    SHORTEST_WAIT_S,
    SLOW_LEG_M,
    SLOWER,
    far_enough,
    timed_line,
)

Floats = NDArray[np.float64]

SHORTEST_LEG_S = 1e-3  # for approaches too short to be timed by their length


@dataclass(frozen=True, kw_only=True, eq=False)
class Approach:
    """The timed points of an approach: times_s (k,) from 0, places_m (k, 2); one row: the robot is there already."""

    times_s: Floats
    places_m: Floats

    @property
    def duration_s(self) -> float:
        """Seconds from the start to the loop, turning into the loop included."""
        return float(self.times_s[-1])

    @property
    def start_m(self) -> Floats:
        """Where it begins, (2,)."""
        return np.asarray(self.places_m[0])

    @property
    def entry_m(self) -> Floats:
        """Where it enters the loop, (2,)."""
        return np.asarray(self.places_m[-1])


def timed_approach(line_m: Floats, robot: Robot, onward_m: Floats | None = None) -> Approach:
    """The approach along a polyline (n, 2) at the robot's full speed, with the time to turn at its corners.

    onward_m: (2,), where the loop goes on to from the last point; the last pause is for the turn into it. None: the
    robot stays there. A polyline without length gives one row.
    """
    line_m = without_short_legs(line_m)
    if len(line_m) == 1:
        return Approach(times_s=np.zeros(1), places_m=line_m)
    ahead = np.diff(line_m if onward_m is None else np.vstack([line_m, onward_m]), axis=0)
    before, after = ahead[:-1], ahead[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.zeros(len(line_m) - 1)
    turns[: len(after)] = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    too_short = len(line_m) == 2 and np.hypot(*ahead[0]) / SLOWER < SHORTEST_LEG_M
    times_s, places_m = timed_line(
        line_m, turns, robot, least_s=SHORTEST_LEG_S if too_short else SLOW_LEG_M / robot.speed_m_s
    )
    return Approach(times_s=times_s, places_m=places_m)


def without_short_legs(line_m: Floats) -> Floats:
    """The polyline without points that end legs too short to be timed; the first and the last point stay."""
    keep = far_enough(line_m)
    last = len(line_m) - 1
    if keep[-1] != last and (line_m[keep[-1]] != line_m[last]).any():
        keep = [*keep[:-1], last] if len(keep) > 1 else [0, last]
    return np.asarray(line_m[keep])


def first_step_m(places_m: Floats) -> Floats | None:
    """The first place (2,) of a round that differs from where it begins; None for a robot that stays."""
    moved = np.flatnonzero((places_m != places_m[0]).any(axis=1))
    return None if not len(moved) else np.asarray(places_m[moved[0]])


def joined_trajectory(
    name: str, approach: Approach, leaves_s: float, loops_s: float, round_s_m: tuple[Floats, Floats]
) -> Trajectory:
    """A robot that waits at its start, leaves it at ``leaves_s``, and loops from ``loops_s`` on.

    round_s_m: times (k,) from 0 and places (k, 2) of one round, begun where the approach ends; one row: the robot
    stays. Between arriving and ``loops_s`` it waits at the loop.
    """
    moves = len(approach.times_s) > 1
    times, places = [np.zeros(1)], [approach.places_m[:1]]
    if moves and leaves_s > 0:
        times.append(np.array([leaves_s]))
        places.append(approach.places_m[:1])
    times.append(leaves_s + approach.times_s[1:])
    places.append(approach.places_m[1:])
    if loops_s - (leaves_s + approach.duration_s if moves else 0.0) > SHORTEST_WAIT_S:
        times.append(np.array([loops_s]))
        places.append(approach.places_m[-1:])
    elif moves:
        times[-1] = np.append(times[-1][:-1], loops_s)  # just in time: only the last bits of the sum differ
    round_times_s, round_places_m = round_s_m
    times.append(loops_s + round_times_s[1:])
    places.append(round_places_m[1:])
    return Trajectory(robot=name, times_s=np.concatenate(times), positions_m=np.vstack(places), loop_start_s=loops_s)

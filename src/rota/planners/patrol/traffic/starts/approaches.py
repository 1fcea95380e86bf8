"""A robot's approach from its start to its loop, timed at full speed, and the trajectory that joins the two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.model.plan import Trajectory
from rota.planners.patrol.driving.at_once import SLOW_LEG_M, timed_line
from rota.planners.patrol.driving.polylines import far_enough
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.tolerances import HAIR_M, SAME_PLACE_M, SHORTEST_S, SLOWER


@dataclass(frozen=True, kw_only=True, eq=False)
class Approach:
    """An approach as it is driven, turning into the loop included; one row: the robot is there already.

    run_up: of a robot with mass, from where the line ends to where it joins the loop in motion; None: it is there.
    """

    line: TimedLine
    run_up: TimedLine | None = None

    @property
    def times_s(self) -> Floats:
        """The times (k,) of its line."""
        return self.line.times_s

    @property
    def places_m(self) -> Floats:
        """The places (k, 2) of its line."""
        return self.line.places_m

    @property
    def duration_s(self) -> float:
        """Seconds from the start to the end of the line, turning into the loop included."""
        return self.line.duration_s

    @property
    def runs_up_s(self) -> float:
        """Seconds from the end of the line to the loop."""
        return 0.0 if self.run_up is None else self.run_up.duration_s

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
        return Approach(line=steady(np.zeros(1), line_m))
    if robot.motion.has_mass:
        return Approach(line=driving_with_mass(robot).way(line_m))
    ahead = np.diff(line_m if onward_m is None else np.vstack([line_m, onward_m]), axis=0)
    before, after = ahead[:-1], ahead[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.zeros(len(line_m) - 1)
    turns[: len(after)] = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    too_short = len(line_m) == 2 and np.hypot(*ahead[0]) / SLOWER < HAIR_M
    least_s = 1e-3 if too_short else SLOW_LEG_M / robot.ground_speed_m_s
    return Approach(line=timed_line(line_m, turns, robot, least_s=least_s))


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
    name: str, approach: Approach, leaves_s: float, loops_s: float, one_round: TimedLine
) -> Trajectory:
    """A robot that waits at its start, leaves it at ``leaves_s``, and loops from ``loops_s`` on.

    one_round: begun where the approach, or its run-up, ends; one row: the robot stays. Between arriving and ``loops_s``
    it waits at the loop, or where its run-up begins.
    """
    moves, goes_s = not approach.line.stays, loops_s - approach.runs_up_s
    times, places, accelerations = [np.zeros(1)], [approach.places_m[:1]], [np.zeros(0)]
    if moves and leaves_s > 0:
        times.append(np.array([leaves_s]))
        places.append(approach.places_m[:1])
        accelerations.append(np.zeros(1))
    times.append(leaves_s + approach.times_s[1:])
    places.append(approach.places_m[1:])
    accelerations.append(approach.line.accelerations_m_s2)
    if goes_s - (leaves_s + approach.duration_s if moves else 0.0) > SHORTEST_S:
        times.append(np.array([goes_s]))
        places.append(approach.places_m[-1:])
        accelerations.append(np.zeros(1))
    elif moves:
        times[-1] = np.append(times[-1][:-1], goes_s)  # just in time: only the last bits of the sum differ
    for begins_s, line in ((goes_s, approach.run_up), (loops_s, one_round)):
        if line is not None and not line.stays:
            ends_s = begins_s + line.times_s[1:]
            times.append(np.append(ends_s[:-1], loops_s) if line is approach.run_up else ends_s)
            begins_m, onward_m = (approach.run_up or approach.line).places_m[-1], line.places_m[1:]
            if line is one_round and np.hypot(*(onward_m[-1] - begins_m)) <= SAME_PLACE_M:
                onward_m = np.vstack([onward_m[:-1], begins_m])  # rounding must not open the loop
            places.append(onward_m)
            accelerations.append(line.accelerations_m_s2)
    changes = np.concatenate(accelerations)
    return Trajectory(
        robot=name,
        times_s=np.concatenate(times),
        positions_m=np.vstack(places),
        accelerations_m_s2=changes if changes.any() else None,
        loop_start_s=loops_s,
    )

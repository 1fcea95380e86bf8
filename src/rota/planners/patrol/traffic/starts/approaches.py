"""A robot's way from its start to its loop, timed at full speed, and the trajectory that joins the two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.mission import Robot
from rota.plan import Trajectory
from rota.planners.patrol.tours.timetable import SHORTEST_LEG_M, SLOWER

Floats = NDArray[np.float64]

SHORTEST_WAIT_S = 1e-6
SHORTEST_LEG_S = 1e-3  # for ways too short to be timed by their length


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """The timed points of a way: times_s (k,) from 0, places_m (k, 2); one row for a robot that is there already."""

    times_s: Floats
    places_m: Floats

    @property
    def duration_s(self) -> float:
        """Time on the way, turning into the loop included."""
        return float(self.times_s[-1])

    @property
    def start_m(self) -> Floats:
        """Where it begins, (2,)."""
        return np.asarray(self.places_m[0])

    @property
    def entry_m(self) -> Floats:
        """Where it enters the loop, (2,)."""
        return np.asarray(self.places_m[-1])


def timed_way(line_m: Floats, robot: Robot, onward_m: Floats | None = None) -> Way:
    """The way along a polyline (n, 2) at the robot's full speed, with the time to turn at its corners.

    onward_m: (2,), where the loop goes on to from the last point; the turn into it is the way's last pause. None: the
    robot stays there. A polyline without length gives one row.
    """
    line_m = without_short_legs(line_m)
    if len(line_m) == 1:
        return Way(times_s=np.zeros(1), places_m=line_m)
    steps = np.diff(line_m if onward_m is None else np.vstack([line_m, onward_m]), axis=0)
    travel_s = np.hypot(*steps[: len(line_m) - 1].T) / (robot.speed_m_s * SLOWER)
    if len(line_m) == 2:
        travel_s = np.maximum(travel_s, SHORTEST_LEG_S if travel_s[0] * robot.speed_m_s < SHORTEST_LEG_M else 0.0)
    turn_s = np.zeros(len(travel_s))
    if robot.turn_rate_rad_s is not None:
        before, after = steps[:-1], steps[1:]
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        angles = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
        turn_s[: len(angles)] = angles / (robot.turn_rate_rad_s * SLOWER)
    # one row on arrival at each point, one more when turning there takes time
    durations = np.column_stack([travel_s, turn_s]).ravel()
    places = np.repeat(line_m[1:], 2, axis=0)
    keep = durations > 0
    return Way(
        times_s=np.concatenate([[0.0], np.cumsum(durations[keep])]), places_m=np.vstack([line_m[:1], places[keep]])
    )


def without_short_legs(line_m: Floats) -> Floats:
    """The polyline without points that end legs too short to be timed; the first and the last point stay."""
    keep = [0]
    for i in range(1, len(line_m)):
        if np.hypot(*(line_m[i] - line_m[keep[-1]])) >= SHORTEST_LEG_M:
            keep.append(i)
    last = len(line_m) - 1
    if keep[-1] != last and (line_m[keep[-1]] != line_m[last]).any():
        keep = [*keep[:-1], last] if len(keep) > 1 else [0, last]
    return np.asarray(line_m[keep])


def first_step_m(places_m: Floats) -> Floats | None:
    """The first place (2,) of a round that differs from where it begins; None for a robot that stays."""
    moved = np.flatnonzero((places_m != places_m[0]).any(axis=1))
    return None if not len(moved) else np.asarray(places_m[moved[0]])


def joined_trajectory(
    name: str, way: Way, leaves_s: float, loops_s: float, round_s_m: tuple[Floats, Floats]
) -> Trajectory:
    """A robot that waits at its start, leaves it at ``leaves_s``, and loops from ``loops_s`` on.

    round_s_m: times (k,) from 0 and places (k, 2) of one round, begun where the way ends; one row: the robot stays.
    Between arriving and ``loops_s`` it waits at the loop.
    """
    moves = len(way.times_s) > 1
    times, places = [np.zeros(1)], [way.places_m[:1]]
    if moves and leaves_s > 0:
        times.append(np.array([leaves_s]))
        places.append(way.places_m[:1])
    times.append(leaves_s + way.times_s[1:])
    places.append(way.places_m[1:])
    if loops_s - (leaves_s + way.duration_s if moves else 0.0) > SHORTEST_WAIT_S:
        times.append(np.array([loops_s]))
        places.append(way.places_m[-1:])
    elif moves:
        times[-1] = np.append(times[-1][:-1], loops_s)  # just in time: only the last bits of the sum differ
    round_times_s, round_places_m = round_s_m
    times.append(loops_s + round_times_s[1:])
    places.append(round_places_m[1:])
    return Trajectory(robot=name, times_s=np.concatenate(times), positions_m=np.vstack(places), loop_start_s=loops_s)

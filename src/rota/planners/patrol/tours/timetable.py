"""Timed polylines: rounds of closed tours, robots equally spaced on them, turning time at the corners.

Times (k,) are in seconds and ascend from 0, places (k, 2) in metres; between two rows a robot goes straight at one
speed. One row is a robot that stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.mission import Robot
from rota.plan import Trajectory
from rota.planners.patrol.tours.tour import Pace, turns_rad, without_repeats

Floats = NDArray[np.float64]

SLOWER = 1 - 1e-6  # of full speed, so that rounding of times never shows as speeding
SHORTEST_WAIT_S = 1e-6
SHORTEST_LEG_M = 1e-6  # shorter legs are left out: they would be timed to fewer digits than the check asks
SLOW_LEG_M = 1e-5  # shorter legs take the time of this one, for the same reason


def loop_timetable(vertices_m: Floats, robot: Robot) -> tuple[Floats, Floats]:
    """Times and places of one round of a closed polyline (n, 2) at full speed, turning at each corner included.

    It starts and ends on the first vertex. One vertex, or a polyline without length, gives one row.
    """
    vertices_m = thinned(vertices_m)
    if len(vertices_m) == 1:
        return np.zeros(1), vertices_m
    line_m, turns = np.vstack([vertices_m, vertices_m[:1]]), np.roll(turns_rad(vertices_m), -1)
    return timed_line(line_m, turns, robot, least_s=SLOW_LEG_M / robot.speed_m_s)


def timed_line(line_m: Floats, turns: Floats, robot: Robot, *, least_s: float = 0.0) -> tuple[Floats, Floats]:
    """Times and places along an open polyline (n, 2) without legs of no length, at full speed.

    turns (n - 1,): the angles in radians by which the robot turns at each point but the first. least_s: no leg is
    driven in less time.
    """
    travel_s = np.maximum(np.hypot(*np.diff(line_m, axis=0).T) / (robot.speed_m_s * SLOWER), least_s)
    turn_s = np.zeros(len(travel_s))
    if robot.turn_rate_rad_s is not None:
        turn_s = turns / (robot.turn_rate_rad_s * SLOWER)
    # one row on arrival at each point, one more when turning there takes time
    steps = np.column_stack([travel_s, turn_s]).ravel()
    keep = steps > 0
    return np.concatenate([[0.0], np.cumsum(steps[keep])]), np.vstack([line_m[:1], np.repeat(line_m[1:], 2, 0)[keep]])


def places_at(moments_s: NDArray[np.floating[Any]], times_s: Floats, places_m: Floats) -> Floats:
    """Where a robot is (m, 2) at the moments (m,); before the first row at its place, after the last at that one's."""
    return np.column_stack([np.interp(moments_s, times_s, places_m[:, axis]) for axis in (0, 1)])


def line_of(places_m: Floats) -> shapely.LineString | shapely.Point:
    """The places (k, 2) as a line; as a point for a robot that stays."""
    moves = (places_m != places_m[0]).any()
    return shapely.LineString(places_m) if moves else shapely.Point(places_m[0])


def stretched(times_s: Floats, places_m: Floats, duration_s: float) -> tuple[Floats, Floats]:
    """The round driven slower, so that it takes exactly ``duration_s``; pauses stay as long as they are.

    A round that takes longer already is left as it is, and so is a robot that stays.
    """
    if len(times_s) == 1 or duration_s <= times_s[-1]:
        return times_s, places_m
    steps = np.diff(times_s)
    moves = (np.diff(places_m, axis=0) != 0).any(axis=1)
    steps[moves] *= (duration_s - steps[~moves].sum()) / steps[moves].sum()
    later_s = np.concatenate([[0.0], np.cumsum(steps)])
    later_s[-1] = duration_s
    return later_s, places_m


def paced_timetable(vertices_m: Floats, robot: Robot, pace: Pace) -> tuple[Floats, Floats]:
    """Times and places of all rounds of a robot that keeps step with others; it waits where a round ends early.

    Turning takes no time. The timetable begins the pace's lead into the first round.
    """
    speed_m_s = robot.speed_m_s * SLOWER
    round_s = pace.round_m / speed_m_s
    times_s, places = [np.zeros(1)], [vertices_m[:1]]
    for k, vertices in enumerate(np.split(vertices_m, pace.first[1:])):
        ring = timeable(vertices)
        ends = np.roll(ring, -1, axis=0)
        arrives_s = np.cumsum(np.hypot(*(ends - ring).T)) / speed_m_s
        if round_s - arrives_s[-1] > SHORTEST_WAIT_S:
            arrives_s, ends = np.append(arrives_s, round_s), np.vstack([ends, ends[-1:]])
        arrives_s[-1] = round_s
        keep = arrives_s > 0
        times_s.append(k * round_s + arrives_s[keep])
        places.append(ends[keep])
    return started_at(np.concatenate(times_s), np.vstack(places), pace.lead_m / speed_m_s)


def timeable(vertices_m: Floats) -> Floats:
    """The closed polyline without repeats and without legs too short to be timed; the first vertex stays."""
    vertices_m = without_repeats(vertices_m)
    keep = far_enough(vertices_m)
    while len(keep) > 1 and np.hypot(*(vertices_m[keep[-1]] - vertices_m[0])) < SHORTEST_LEG_M:
        keep.pop()
    return vertices_m[keep]


def far_enough(points_m: Floats) -> list[int]:
    """The numbers of the points (n, 2), from the first on, that end legs long enough to be timed."""
    keep = [0]
    for i in range(1, len(points_m)):
        if np.hypot(*(points_m[i] - points_m[keep[-1]])) >= SHORTEST_LEG_M:
            keep.append(i)
    return keep


def thinned(vertices_m: Floats) -> Floats:
    """The closed polyline as it can be timed, without vertices along straights."""
    vertices_m = timeable(vertices_m)
    bends = turns_rad(vertices_m) > 1e-12
    return vertices_m[bends] if bends.sum() >= 2 else vertices_m


def started_at(times_s: Floats, places_m: Floats, phase_s: float) -> tuple[Floats, Floats]:
    """The round begun ``phase_s`` after its start; its duration stays exactly the same."""
    duration_s = float(times_s[-1])
    phase_s = phase_s % duration_s
    near = int(np.argmin(np.abs(times_s - phase_s)))
    if abs(times_s[near] - phase_s) < 1e-6 * duration_s / len(times_s):
        phase_s = float(times_s[near])  # on a vertex: no leg of hardly any length
    if phase_s in (0.0, duration_s):
        return times_s, places_m
    begins_m = places_at(np.array([phase_s]), times_s, places_m)
    after, before = times_s > phase_s, times_s < phase_s
    on_vertex = bool((times_s == phase_s).any())
    if on_vertex:
        begins_m = places_m[[int(np.searchsorted(times_s, phase_s))]]
    # the seam's two rows are one: the end of the old round is the start of the new
    times = np.concatenate(
        [[0.0], times_s[after] - phase_s, times_s[before][1:] + (duration_s - phase_s), [duration_s]]
    )
    places = np.vstack([begins_m, places_m[after], places_m[before][1:], begins_m])
    return times, places


def evenly_spaced(times_s: Floats, places_m: Floats, robots: int, offset_s: float = 0.0) -> list[tuple[Floats, Floats]]:
    """The rounds of the robots that share one at equal headways; the first begins ``offset_s`` into it."""
    if len(times_s) == 1:
        return [(times_s, places_m)] * robots
    return [started_at(times_s, places_m, offset_s + k * float(times_s[-1]) / robots) for k in range(robots)]


def as_trajectories(rounds: Sequence[tuple[Floats, Floats]], names: Sequence[str]) -> tuple[Trajectory, ...]:
    """One trajectory per robot, which loops from the very start."""
    return tuple(
        Trajectory(robot=name, times_s=times_s, positions_m=places_m, loop_start_s=0.0)
        for name, (times_s, places_m) in zip(names, rounds, strict=True)
    )

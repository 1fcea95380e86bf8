"""From closed tours to timed trajectories: robots equally spaced on each tour, turning time at the corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.mission import Robot
from rota.plan import Trajectory
from rota.planners.patrol.tours.tour import Pace, turns_rad, without_repeats

Floats = NDArray[np.float64]

SLOWER = 1 - 1e-6  # below full speed, so that rounding of times never shows as speeding
LEAST_WAIT_S = 1e-6
SHORTEST_LEG_M = 1e-5  # shorter legs would be timed to fewer digits than the check asks


def loop_timetable(vertices_m: Floats, robot: Robot) -> tuple[Floats, Floats]:
    """Times (k,) and places (k, 2) of one round of a closed polyline (n, 2), turning at each corner included.

    As fast as the robot can. One vertex, or a polyline without length: one row, the robot stays. Starts and ends on the
    first vertex.
    """
    vertices_m = thinned(vertices_m)
    n = len(vertices_m)
    if n == 1:
        return np.zeros(1), vertices_m
    ends = np.roll(vertices_m, -1, axis=0)
    travel_s = np.hypot(*(ends - vertices_m).T) / (robot.speed_m_s * SLOWER)
    turn_s = np.zeros(n)
    if robot.turn_rate_rad_s is not None:
        turn_s = np.roll(turns_rad(vertices_m), -1) / (robot.turn_rate_rad_s * SLOWER)
    # one row on arrival at each vertex, one more when turning there takes time
    steps = np.column_stack([travel_s, turn_s]).ravel()
    places = np.repeat(ends, 2, axis=0)
    keep = steps > 0
    return np.concatenate([[0.0], np.cumsum(steps[keep])]), np.vstack([vertices_m[:1], places[keep]])


def stretched(times_s: Floats, places_m: Floats, duration_s: float) -> tuple[Floats, Floats]:
    """The same round, driven slower so that it takes ``duration_s``, to the last bit; pauses stay as long as they are.

    As it is where it takes longer already, or stays.
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
    """Times (k,) and places (k, 2) of all rounds of a robot that keeps step with others: it waits where one ends early.

    Turning takes no time. Begins its lead into the first round.
    """
    speed_m_s = robot.speed_m_s * SLOWER
    round_s = pace.round_m / speed_m_s
    times_s, places = [np.zeros(1)], [vertices_m[:1]]
    for k, one in enumerate(np.split(vertices_m, pace.first[1:])):
        ring = timeable(one)
        ends = np.roll(ring, -1, axis=0)
        here_s = np.cumsum(np.hypot(*(ends - ring).T)) / speed_m_s
        if round_s - here_s[-1] > LEAST_WAIT_S:
            here_s, ends = np.append(here_s, round_s), np.vstack([ends, ends[-1:]])
        here_s[-1] = round_s
        keep = here_s > 0
        times_s.append(k * round_s + here_s[keep])
        places.append(ends[keep])
    return started_at(np.concatenate(times_s), np.vstack(places), pace.lead_m / speed_m_s)


def timeable(vertices_m: Floats) -> Floats:
    """The closed polyline without repeats and without legs too short to be timed; the first vertex stays."""
    vertices_m = without_repeats(vertices_m)
    keep = [0]
    for i in range(1, len(vertices_m)):
        if np.hypot(*(vertices_m[i] - vertices_m[keep[-1]])) >= SHORTEST_LEG_M:
            keep.append(i)
    while len(keep) > 1 and np.hypot(*(vertices_m[keep[-1]] - vertices_m[0])) < SHORTEST_LEG_M:
        keep.pop()
    return vertices_m[keep]


def thinned(vertices_m: Floats) -> Floats:
    """The closed polyline as it can be timed, without vertices along straights."""
    vertices_m = timeable(vertices_m)
    bends = turns_rad(vertices_m) > 1e-12
    return vertices_m[bends] if bends.sum() >= 2 else vertices_m


def started_at(times_s: Floats, places_m: Floats, phase_s: float) -> tuple[Floats, Floats]:
    """The same round, begun ``phase_s`` after its start; the duration stays the same to the last bit."""
    duration_s = float(times_s[-1])
    phase_s = phase_s % duration_s
    near = int(np.argmin(np.abs(times_s - phase_s)))
    if abs(times_s[near] - phase_s) < 1e-6 * duration_s / len(times_s):
        phase_s = float(times_s[near])  # on a vertex: no leg of hardly any length
    if phase_s in (0.0, duration_s):
        return times_s, places_m
    here = np.array([np.interp(phase_s, times_s, places_m[:, axis]) for axis in (0, 1)])
    after, before = times_s > phase_s, times_s < phase_s
    on_vertex = bool((times_s == phase_s).any())
    if on_vertex:
        here = places_m[int(np.searchsorted(times_s, phase_s))]
    # the seam's two rows are one: the end of the old round is the start of the new
    times = np.concatenate(
        [[0.0], times_s[after] - phase_s, times_s[before][1:] + (duration_s - phase_s), [duration_s]]
    )
    places = np.vstack([here, places_m[after], places_m[before][1:], here])
    return times, places


def evenly_spaced(times_s: Floats, places_m: Floats, robots: int, offset_s: float = 0.0) -> list[tuple[Floats, Floats]]:
    """The round of each of the robots that share it at equal times between them, the first ``offset_s`` into it."""
    if len(times_s) == 1:
        return [(times_s, places_m)] * robots
    return [started_at(times_s, places_m, offset_s + k * float(times_s[-1]) / robots) for k in range(robots)]


def as_trajectories(rounds: Sequence[tuple[Floats, Floats]], names: Sequence[str]) -> tuple[Trajectory, ...]:
    """One trajectory per robot, its loop from the very start; a round of one row is a robot that stays."""
    return tuple(
        Trajectory(robot=name, times_s=times_s, positions_m=places_m, loop_start_s=0.0)
        for name, (times_s, places_m) in zip(names, rounds, strict=True)
    )

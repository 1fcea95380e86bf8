"""From closed tours to timed trajectories: robots equally spaced on each tour, turning time at the corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.mission import Robot
from rota.plan import Trajectory
from rota.planners.patrol.annealing.tour import Tour, turns_rad, without_repeats

Floats = NDArray[np.float64]

SLOWER = 1 - 1e-6  # below full speed, so that rounding of times never shows as speeding
SHORTEST_LEG_M = 1e-5  # shorter legs would be timed to fewer digits than the check asks


def loop_timetable(vertices_m: Floats, robot: Robot, duration_s: float | None = None) -> tuple[Floats, Floats]:
    """Times (k,) and places (k, 2) of one round of a closed polyline (n, 2), turning at each corner included.

    duration_s: stretch the round to this time, by driving slower; None: as fast as the robot can. One vertex, or a
    polyline without length: the robot stays, for ``duration_s`` or no time at all. Starts and ends on the first vertex.
    """
    vertices_m = thinned(vertices_m)
    n = len(vertices_m)
    if n == 1:
        stay = duration_s or 0.0
        return np.array([0.0, stay][: 2 if stay else 1]), np.repeat(vertices_m, 2 if stay else 1, axis=0)
    ends = np.roll(vertices_m, -1, axis=0)
    travel_s = np.hypot(*(ends - vertices_m).T) / (robot.speed_m_s * SLOWER)
    turn_s = np.zeros(n)
    if robot.turn_rate_rad_s is not None:
        turn_s = np.roll(turns_rad(vertices_m), -1) / (robot.turn_rate_rad_s * SLOWER)
    if duration_s is not None:
        travel_s *= max(1.0, (duration_s - turn_s.sum()) / travel_s.sum())
    # one row on arrival at each vertex, one more when turning there takes time
    steps = np.column_stack([travel_s, turn_s]).ravel()
    places = np.repeat(ends, 2, axis=0)
    keep = steps > 0
    times_s = np.concatenate([[0.0], np.cumsum(steps[keep])])
    places = np.vstack([vertices_m[:1], places[keep]])
    if duration_s is not None and times_s[-1] <= duration_s * (1 + 1e-9):
        times_s[-1] = duration_s
    return times_s, places


def thinned(vertices_m: Floats) -> Floats:
    """The closed polyline without repeats, without legs too short to be timed, and without vertices along straights."""
    vertices_m = without_repeats(vertices_m)
    keep = [0]
    for i in range(1, len(vertices_m)):
        if np.hypot(*(vertices_m[i] - vertices_m[keep[-1]])) >= SHORTEST_LEG_M:
            keep.append(i)
    while len(keep) > 1 and np.hypot(*(vertices_m[keep[-1]] - vertices_m[0])) < SHORTEST_LEG_M:
        keep.pop()
    vertices_m = vertices_m[keep]
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


def trajectories_of(
    tours: Sequence[Tour], durations_s: Sequence[float | None], offsets_s: Sequence[float]
) -> list[tuple[Floats, Floats]]:
    """Times and places of every robot, tour by tour; those of one tour follow each other at equal times."""
    found = []
    for tour, duration_s, offset_s in zip(tours, durations_s, offsets_s, strict=True):
        times_s, places_m = loop_timetable(tour.vertices_m, tour.robot, duration_s)
        for k in range(tour.robots):
            if len(times_s) == 1:
                found.append((times_s, places_m))
            else:
                found.append(started_at(times_s, places_m, offset_s + k * float(times_s[-1]) / tour.robots))
    return found


def as_trajectories(rounds: Sequence[tuple[Floats, Floats]], names: Sequence[str]) -> tuple[Trajectory, ...]:
    """One trajectory per robot, its loop from the very start; a round of one row is a robot that stays."""
    return tuple(
        Trajectory(robot=name, times_s=times_s, positions_m=places_m, loop_start_s=0.0)
        for name, (times_s, places_m) in zip(names, rounds, strict=True)
    )

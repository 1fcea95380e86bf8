"""The rounds of a plan: which robots share one, and rounds joined where robots are too few for all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import TOUCH_M, Robot
from rota.model.plan import Trajectory
from rota.planners.patrol.driving.polylines import without_straight_vertices
from rota.planners.patrol.driving.timed_line import TimedLine, start_at
from rota.planners.patrol.tours.curves import closed_curve
from rota.planners.patrol.tours.timetable import line_of, loop_timetable

SAME_M, SAME = 1e-4, 1e-7  # rounds are one that miss each other by no more, and whose times do by no greater share
COMPARED = 16  # moments of two rounds
PHASES = 8  # of a round, or moments at which all begin, that are tried, beside those at which somebody need not wait
HALVINGS = 4  # of the step between them, to try those beside the best
ENTRIES = 120  # places of a round at which robots may come into it, or another one may be joined to it


@dataclass(frozen=True, kw_only=True, eq=False)
class Round:
    """A round and who drives it: robots by their names, each so many seconds ahead of its beginning."""

    line: TimedLine
    ahead_s: dict[str, float]

    @property
    def duration_s(self) -> float:
        """Seconds of one round."""
        return self.line.duration_s


def rounds_of(trajectories: Sequence[Trajectory]) -> list[Round]:
    """The different rounds of trajectories, in their order; each robot is ahead of its round at the time 0."""
    rounds: list[Round] = []
    for trajectory in trajectories:
        line = loop_of(trajectory)
        for found in rounds:
            shift_s = shift_between(found.line, line)
            if shift_s is not None:
                found.ahead_s[trajectory.robot] = shift_s - trajectory.loop_start_s
                break
        else:
            rounds.append(Round(line=line, ahead_s={trajectory.robot: -trajectory.loop_start_s}))
    return rounds


def loop_of(trajectory: Trajectory) -> TimedLine:
    """The loop of a trajectory as a round; one row where its robot stays."""
    first = trajectory.loop_index
    changes = trajectory.accelerations_m_s2
    changes = np.zeros(len(trajectory.times_s) - 1) if changes is None else changes
    places_m = trajectory.positions_m[first:, :2]
    return TimedLine(trajectory.times_s[first:] - trajectory.loop_start_s, places_m, changes[first:])


def shift_between(one: TimedLine, other: TimedLine) -> float | None:
    """How far into the one the other begins, in seconds, where both are the same round; None where they are not."""
    if one.stays or other.stays or abs(one.duration_s - other.duration_s) > SAME * one.duration_s:
        return None
    steps, start = np.diff(one.places_m, axis=0), other.places_m[0]
    squares = (steps**2).sum(axis=1)
    share = np.clip(((start - one.places_m[:-1]) * steps).sum(axis=1) / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
    near = np.hypot(*(one.places_m[:-1] + share[:, None] * steps - start).T) <= SAME_M
    moments_s = np.linspace(0.0, one.duration_s, COMPARED, endpoint=False)
    for leg in np.flatnonzero(near):
        at_s = float(one.times_s[leg] + share[leg] * (one.times_s[leg + 1] - one.times_s[leg]))
        along = one.at((moments_s + at_s) % one.duration_s)
        if np.hypot(*(along - other.at(moments_s)).T).max() <= 10 * SAME_M:
            return at_s
    return None


def distances_between(rounds: Sequence[Round], paths: ShortestPaths) -> Floats:
    """Metres (n, n) of the shortest ways between rounds."""
    lengths_m = np.zeros((len(rounds), len(rounds)))
    for i, one in enumerate(rounds):
        for j in range(i):
            between_m = paths.distances(_places(one.line)[::4], _places(rounds[j].line)[::4])
            lengths_m[i, j] = lengths_m[j, i] = between_m.min()
    return lengths_m


def join_rounds(lines: Sequence[TimedLine], robot: Robot, paths: ShortestPaths) -> TimedLine:
    """One round of all: from the nearest place of one to the next one, round it, and back."""
    joined_m, left = _corners(lines[0]), list(lines[1:])
    while left:
        places = _places_along(joined_m)
        best = None
        for k, line in enumerate(left):
            others = _places(line)
            between_m = paths.distances(places, others)
            i, j = np.unravel_index(int(np.argmin(between_m)), between_m.shape)
            if best is None or between_m[i, j] < best[0]:
                best = (float(between_m[i, j]), k, places[i], others[j], line)
        assert best is not None
        _, k, here_m, there_m, line = best
        way_m = paths.path(here_m, there_m)
        side_m = _from_place(_corners(line), there_m)
        joined_m = np.vstack([_from_place(joined_m, here_m), way_m[:-1], side_m, way_m[::-1][:-1]])
        joined_m = without_straight_vertices(_without_repeats(joined_m))
        left.pop(k)
    if robot.turn_radius_m > 0:
        # turn radii between places that are passed in curves
        spaced_m = _places_along(joined_m, 1.5 * robot.turn_radius_m)
        joined_m = closed_curve(spaced_m, robot.turn_radius_m, paths.grid)
    return loop_timetable(joined_m, robot)


def _places(line: TimedLine) -> Floats:
    """Places (n, 2) of a round, evenly spaced in time."""
    return line.places_m[:1] if line.stays else line.at(np.linspace(0, line.duration_s, ENTRIES, endpoint=False))


def _places_along(corners_m: Floats, apart_m: float | None = None) -> Floats:
    """Places (n, 2) of a closed polyline, evenly spaced along it, so far apart at least; None: a number of them."""
    closed_m = np.vstack([corners_m, corners_m[:1]])
    along_m = np.append(0.0, np.cumsum(np.hypot(*np.diff(closed_m, axis=0).T)))
    number = ENTRIES if apart_m is None else max(3, int(along_m[-1] / apart_m))
    wanted_m = np.linspace(0, along_m[-1], number, endpoint=False)
    return np.column_stack([np.interp(wanted_m, along_m, closed_m[:, axis]) for axis in (0, 1)])


def _corners(line: TimedLine) -> Floats:
    """The corners (k, 2) of a round, the first not repeated."""
    return line.places_m if line.stays else _without_repeats(line.places_m[:-1])


def _without_repeats(places_m: Floats) -> Floats:
    """The places without those that are where the one before is."""
    kept = np.append(True, (np.hypot(*np.diff(places_m, axis=0).T) > SAME_M))
    return np.asarray(places_m[kept])


def _from_place(corners_m: Floats, place_m: Floats) -> Floats:
    """A closed polyline from a place on it round to that place again: its first row and its last."""
    if len(corners_m) == 1:
        return corners_m
    closed_m = np.vstack([corners_m, corners_m[:1]])
    steps = np.diff(closed_m, axis=0)
    squares = (steps**2).sum(axis=1)
    share = np.clip(((place_m - closed_m[:-1]) * steps).sum(axis=1) / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
    leg = int(np.argmin(np.hypot(*(closed_m[:-1] + share[:, None] * steps - place_m).T)))
    return np.vstack([place_m, np.roll(corners_m, -(leg + 1), axis=0), place_m])


def is_clear(places_m: Floats, ground: MultiPolygon, body_m: float) -> bool:
    """Whether a body can be led along a line (n, 2) on free ground."""
    line = line_of(places_m)
    roomy = ground.buffer(TOUCH_M)  # ways past corners are off them by rounding
    return bool(roomy.covers(line) and ground.boundary.distance(line) >= body_m - TOUCH_M)


def lead_round(line: TimedLine, robot: Robot, paths: ShortestPaths) -> TimedLine | None:
    """The round led past what is in its way now: corners that cannot be reached are left out; None: none can."""
    corners_m = _corners(line)
    parts = paths.part_of(corners_m)
    inside = parts[parts >= 0]
    if not len(inside):
        return None
    corners_m = corners_m[parts == np.bincount(inside).argmax()]
    ways = [paths.path(a, b)[:-1] for a, b in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True)]
    led_m = _without_repeats(np.vstack([way for way in ways if len(way)] or [corners_m[:1]]))
    return loop_timetable(without_straight_vertices(led_m), robot)


def slow_down(round_: Round, robot: Robot) -> Round:
    """The round as it is; where a robot is too slow for it, at that robot's speed."""
    line = round_.line
    speeds_m_s = np.hypot(*np.diff(line.places_m, axis=0).T) / np.diff(line.times_s)
    if speeds_m_s.max(initial=0.0) <= robot.ground_speed_m_s * (1 + SAME):
        return round_
    return Round(line=loop_timetable(_corners(line), robot), ahead_s={})


def begin_at(line: TimedLine, phase_s: float) -> TimedLine:
    """The round begun so far into it."""
    return line if line.stays else start_at(line, phase_s)

"""Rounds of closed tours as timed lines, and robots equally spaced on them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.model.plan import Trajectory
from rota.planners.patrol.driving.auto import Auto
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import timeable
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.tolerances import HAIR_M, SHORTEST_S, SLOWER
from rota.planners.patrol.tours.tour import Pace, Tour


def loop_timetable(vertices_m: Floats, robot: Robot) -> TimedLine:
    """One round of a closed polyline (n, 2) as fast as the robot can drive it; one row where it has no length."""
    return driving_of(robot).timed(vertices_m)


def line_of(places_m: Floats) -> shapely.LineString | shapely.Point:
    """The places (k, 2) as a line; as a point for a robot that stays."""
    moves = (places_m != places_m[0]).any()
    return shapely.LineString(places_m) if moves else shapely.Point(places_m[0])


def stretch_line(line: TimedLine, duration_s: float) -> TimedLine:
    """The round driven slower, so that it takes exactly ``duration_s``; pauses stay as long as they are.

    A round that takes longer already is left as it is, and so is a robot that stays.
    """
    if line.stays or duration_s <= line.duration_s:
        return line
    steps = np.diff(line.times_s)
    moves = (np.diff(line.places_m, axis=0) != 0).any(axis=1)
    slower = (duration_s - steps[~moves].sum()) / steps[moves].sum()
    steps[moves] *= slower
    later_s = np.concatenate([[0.0], np.cumsum(steps)])
    later_s[-1] = duration_s
    return TimedLine(later_s, line.places_m, line.accelerations_m_s2 / slower**2)


def paced_timetable(vertices_m: Floats, robot: Robot, pace: Pace) -> TimedLine:
    """All rounds of a robot that keeps step with others; it waits where a round ends early.

    Speeds change and turns are made in no time. The timetable begins the pace's lead into the first round.
    """
    speed_m_s = robot.ground_speed_m_s * SLOWER
    rounds_s = [round_m / speed_m_s for round_m in pace.rounds_m]
    times_s, places = [np.zeros(1)], [vertices_m[:1]]
    parts = [timeable(vertices) for vertices in np.split(vertices_m, pace.first[1:])]
    for k, (part, round_s) in enumerate(zip(parts, rounds_s, strict=True)):
        ends = np.vstack([part[1:], parts[(k + 1) % len(parts)][:1]])
        arrives_s = np.cumsum(np.hypot(*(ends - part).T)) / speed_m_s
        if round_s - arrives_s[-1] > SHORTEST_S:
            arrives_s, ends = np.append(arrives_s, round_s), np.vstack([ends, ends[-1:]])
        arrives_s[-1] = round_s
        keep = arrives_s > 0
        times_s.append(math.fsum(rounds_s[:k]) + arrives_s[keep])
        places.append(ends[keep])
    return start_at(steady(np.concatenate(times_s), np.vstack(places)), pace.lead_m / speed_m_s)


def evenly_spaced(line: TimedLine, robots: int, offset_s: float = 0.0) -> list[TimedLine]:
    """The rounds of the robots that share one at equal headways; the first begins ``offset_s`` into it."""
    if line.stays:
        return [line] * robots
    return [start_at(line, offset_s + k * line.duration_s / robots) for k in range(robots)]


def as_trajectories(rounds: Sequence[TimedLine], names: Sequence[str]) -> tuple[Trajectory, ...]:
    """One trajectory per robot, which loops from the very start."""
    return tuple(
        Trajectory(
            robot=name,
            times_s=line.times_s,
            positions_m=line.places_m,
            accelerations_m_s2=line.accelerations_m_s2 if line.accelerations_m_s2.any() else None,
            loop_start_s=0.0,
        )
        for name, line in zip(names, rounds, strict=True)
    )


def begin_by_autopilots(tours: Sequence[Tour], trajectories: Sequence[Trajectory]) -> tuple[Trajectory, ...]:
    """The trajectories of robots that share tours evenly, of those with autopilots as these can begin them.

    Those stay as they are whose timing keeps bodies apart: by other phases, or slower than their autopilots fly.
    """
    phases = ((tour, k / tour.robots) for tour in tours for k in range(tour.robots))
    begun = []
    for (tour, share), trajectory in zip(phases, trajectories, strict=True):
        driving = driving_of(tour.robot)
        made = None
        if isinstance(driving, Auto) and trajectory.loop_duration_s > 0:
            line = driving.timed(tour.vertices_m)
            begins_m = line.at(np.array([share * line.duration_s]))[0]
            as_fast = abs(line.duration_s - trajectory.loop_duration_s) <= SHORTEST_S
            if as_fast and np.hypot(*(begins_m - trajectory.positions_m[0])) <= HAIR_M:
                made = driving.begin_at_a_corner(trajectory.robot, tour.vertices_m, share * line.duration_s)
        begun.append(made or trajectory)
    return tuple(begun)

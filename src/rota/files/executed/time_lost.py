"""What robots with motion lose on the way between stops, which files of stops and speeds do not tell."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rota.model.plan import Trajectory
from rota.routes.driven_route import drive_stops, from_start
from rota.routes.route import RouteStop, route_of
from rota.routes.turning import turning

SAME_STOP_M = 0.1  # within which a stop of a file is one of the plan, rounded


def drive_by_file(
    trajectory: Trajectory,
    once: Sequence[RouteStop],
    every_round: Sequence[RouteStop],
    turn_rate_rad_s: float | None = None,
) -> Trajectory:
    """The trajectory of a robot that a file tells these stops, and then those of a round for ever; none: it stays.

    A robot whose plan has accelerations loses on each way what it loses there by plan, speeding up and braking, beside
    what the file's speed takes; others lose nothing. turn_rate_rad_s: of one that turns by itself where it is told to
    stop, beyond its waits.
    """
    if trajectory.accelerations_m_s2 is not None:
        route = route_of(trajectory, 0.0)
        planned = [*from_start(route), *route.every_round]
        once = _losing(planned, once)
        every_round = _losing(planned, [once[-1], *every_round])[1:]
    once, every_round = turning(once, every_round, turn_rate_rad_s)
    return drive_stops(trajectory.robot, once, every_round, flat=trajectory.positions_m.shape[1] == 2)


def _losing(planned: Sequence[RouteStop], stops: Sequence[RouteStop]) -> list[RouteStop]:
    """The stops, each way to them longer by what the plan loses on it; a way that the plan has not loses nothing."""
    ways_m = np.array([[*a.place_m[:2], *b.place_m[:2]] for a, b in itertools.pairwise(planned)]).reshape(-1, 4)
    lost_s = [
        stop.drive_s(before.place_m) - _at_speed_s(before, stop, stop.speed_m_s)
        for before, stop in itertools.pairwise(planned)
    ]
    made = list(stops[:1])
    for before, stop in itertools.pairwise(stops):
        off_m = np.abs(ways_m - np.array([*before.place_m[:2], *stop.place_m[:2]])).max(axis=1, initial=0.0)
        near = int(off_m.argmin()) if len(off_m) else -1
        if near >= 0 and off_m[near] <= SAME_STOP_M and stop.speed_m_s:
            takes_s = _at_speed_s(before, stop, stop.speed_m_s) + lost_s[near]
            stop = replace(stop, planned_s=max(takes_s, 0.0))
        made.append(stop)
    return made


def _at_speed_s(before: RouteStop, stop: RouteStop, speed_m_s: float | None) -> float:
    return math.dist(before.place_m[:2], stop.place_m[:2]) / speed_m_s if speed_m_s else 0.0

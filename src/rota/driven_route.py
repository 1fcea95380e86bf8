"""A route as it is driven: all stops from the start on, and the trajectory of a robot that drives it exactly."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from rota.errors import PlanError
from rota.limits import SHORTEST_LOOP_S
from rota.plan import Trajectory
from rota.route import Route, RouteStop


def from_start(route: Route) -> tuple[RouteStop, ...]:
    """The stops until the loop begins and the one where it does, from the place where the robot begins.

    The first has no speed, all others have one: stops at one place are taken together, with the sum of their waits.
    """
    stops = [RouteStop(place_m=route.start_m, speed_m_s=None)] if route.once[0].speed_m_s is not None else []
    for stop in route.once:
        if stops and stops[-1].place_m == stop.place_m:
            stops[-1] = replace(stops[-1], hold_s=stops[-1].hold_s + stop.hold_s)
        else:
            stops.append(stop)
    return tuple(stops)


def trajectory_of(route: Route, *, flat: bool) -> Trajectory:
    """The trajectory of a robot that drives the route exactly; ``flat``: with positions (n, 2), else (n, 3).

    Raises PlanError for a loop that takes less time than a trajectory's may.
    """
    start, *others = from_start(route)
    times_s, places = [0.0], [start.place_m]

    def drive(stops: Iterable[RouteStop]) -> None:
        for stop in stops:
            length_m = math.dist(places[-1], stop.place_m)
            for duration_s in (length_m / stop.speed_m_s if stop.speed_m_s else 0.0, stop.hold_s):
                if times_s[-1] + duration_s > times_s[-1]:
                    times_s.append(times_s[-1] + duration_s)
                    places.append(stop.place_m)

    drive([start, *others])
    loop_start_s = times_s[-1]
    drive(route.every_round)
    if route.every_round and times_s[-1] - loop_start_s < SHORTEST_LOOP_S:
        raise PlanError(
            f"robot {route.robot}: its loop takes {times_s[-1] - loop_start_s:.3g} s, too short to be driven"
        )
    positions_m = np.array(places)[:, : 2 if flat else 3]
    return Trajectory(robot=route.robot, times_s=np.array(times_s), positions_m=positions_m, loop_start_s=loop_start_s)

"""A route as it is driven: all stops from the start on, and the trajectory of a robot that drives it exactly."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from rota.errors import PlanError
from rota.model.limits import SHORTEST_LOOP_S
from rota.model.plan import Trajectory
from rota.routes.route import Route, RouteStop

DURATION_S = 1200.0  # how long robots go on where a format ends: about what a battery lasts, less a reserve
ROUNDING_SHARE = 1e-9  # of a round or a second, that sums of many legs may be off


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


def rounds_within(route: Route, duration_s: float) -> int:
    """How many whole rounds end within so many seconds after the start, at least one; none where the robot stays."""
    if not route.every_round:
        return 0
    driven = trajectory_of(route, flat=False)
    fit = (duration_s - driven.loop_start_s) / driven.loop_duration_s
    return max(1, math.floor(fit + ROUNDING_SHARE))


def with_whole_waits(stops: Sequence[RouteStop]) -> list[RouteStop]:
    """The stops with waits in whole seconds, rounded down; what is left of one makes the leg to it slower.

    So the robot leaves every stop when it was to leave it. What is left of the wait at the first stop makes the leg
    after it slower.
    """
    made: list[RouteStop] = []
    late_s = 0.0
    for stop in stops:
        whole_s = float(math.floor(stop.hold_s + ROUNDING_SHARE))
        late_s += max(stop.hold_s - whole_s, 0.0)
        if made:
            length_m = math.dist(made[-1].place_m, stop.place_m)
            if stop.speed_m_s and length_m and late_s:
                planned_s = None if stop.planned_s is None else stop.planned_s + late_s
                slower_m_s = length_m / (length_m / stop.speed_m_s + late_s)
                stop = replace(stop, speed_m_s=slower_m_s, planned_s=planned_s)
            late_s = 0.0
        made.append(replace(stop, hold_s=whole_s))
    return made


def route_with_whole_waits(route: Route) -> Route:
    """The same for a route: what is left of the wait at the loop's first stop makes the leg after it slower."""
    first = route.loop[0]
    *approach, reached = with_whole_waits((*route.approach, replace(first, hold_s=0.0)))
    if route.closing is None:
        return replace(route, approach=tuple(approach), loop=(reached,))
    begin, *others, closing = with_whole_waits((*route.loop, route.closing))
    loop = (replace(begin, speed_m_s=reached.speed_m_s), *others)
    return replace(route, approach=tuple(approach), loop=loop, closing=closing)


def trajectory_of(route: Route, *, flat: bool) -> Trajectory:
    """The trajectory of a robot that drives the route exactly, see ``driven``."""
    return drive_stops(route.robot, from_start(route), route.every_round, flat=flat)


def drive_stops(robot: str, once: Sequence[RouteStop], every_round: Sequence[RouteStop], *, flat: bool) -> Trajectory:
    """The trajectory of a robot that begins at the first stop of ``once`` and repeats ``every_round`` after the last.

    every_round: empty where the robot stays. flat: with positions (n, 2), else (n, 3). A stop without a speed is
    reached in no time. Raises PlanError for rounds that take less time than a trajectory's loop may.
    """
    times_s, places = [0.0], [once[0].place_m]

    def drive(stops: Iterable[RouteStop]) -> None:
        for stop in stops:
            for duration_s in (stop.drive_s(places[-1]), stop.hold_s):
                if times_s[-1] + duration_s > times_s[-1]:
                    times_s.append(times_s[-1] + duration_s)
                    places.append(stop.place_m)

    drive(once)
    loop_start_s = times_s[-1]
    drive(every_round)
    if every_round and times_s[-1] - loop_start_s < SHORTEST_LOOP_S:
        raise PlanError(f"robot {robot}: its loop takes {times_s[-1] - loop_start_s:.3g} s, too short to be driven")
    positions_m = np.array(places)[:, : 2 if flat else 3]
    return Trajectory(robot=robot, times_s=np.array(times_s), positions_m=positions_m, loop_start_s=loop_start_s)

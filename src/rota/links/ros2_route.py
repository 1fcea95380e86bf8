"""A route as a nav_msgs/Path carries it, and what differs between two.

Each pose has the time since the start at which to be there; two poses at one place are a wait. The path's own stamp is
the time at which the loop begins: from the last pose on the robot goes on with the pose of that time, for ever. Where
it is the last pose's, the robot stays there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rota.model.plan import Trajectory
from rota.routes.route import Place3, Route, RouteStop

SAME_M, SAME_S = 1e-3, 1e-3
NS_PER_S = 10**9


@dataclass(frozen=True, kw_only=True)
class TimedPath:
    """Places in metres with their times since the start, in nanoseconds, and the time at which the loop begins."""

    places_m: tuple[Place3, ...]
    times_ns: tuple[int, ...]
    loop_ns: int


def timed_path(route: Route) -> TimedPath:
    """The route by the clock of a robot that keeps its speeds and waits exactly."""
    if route.planned is not None:
        return _as_planned(route.planned, route.start_m[2])
    places, times_s = [route.start_m], [0.0]

    def go_through(stops: tuple[RouteStop, ...]) -> None:
        for stop in stops:
            if stop.speed_m_s is not None:
                times_s.append(times_s[-1] + stop.drive_s(places[-1]))
                places.append(stop.place_m)
            if stop.hold_s > 0:
                times_s.append(times_s[-1] + stop.hold_s)
                places.append(stop.place_m)

    go_through(route.once)
    loop_s = times_s[-1]
    go_through(route.every_round)
    return TimedPath(
        places_m=tuple(places),
        times_ns=tuple(round(time_s * NS_PER_S) for time_s in times_s),
        loop_ns=round(loop_s * NS_PER_S),
    )


def _as_planned(planned: Trajectory, height_m: float) -> TimedPath:
    """A trajectory's own points, at a height in metres where it has none."""
    return TimedPath(
        places_m=tuple((at[0], at[1], at[2] if len(at) > 2 else height_m) for at in planned.positions_m.tolist()),
        times_ns=tuple(round(time_s * NS_PER_S) for time_s in planned.times_s.tolist()),
        loop_ns=round(planned.loop_start_s * NS_PER_S),
    )


def path_differences(sent: TimedPath, held: TimedPath) -> tuple[str, ...]:
    """A sentence for each pose and time of what is held that is not as sent, within a millimetre and a millisecond."""
    if not held.places_m:
        return ("it holds no route",)
    if len(held.places_m) != len(sent.places_m):
        return (f"it holds {len(held.places_m)} poses of {len(sent.places_m)}",)
    found = []
    pairs = zip(sent.places_m, held.places_m, sent.times_ns, held.times_ns, strict=True)
    for number, (place, other, time_ns, other_ns) in enumerate(pairs, start=1):
        # a distance that is not a number is not within the limit
        if not math.dist(place, other) <= SAME_M:
            found.append(f"pose {number}: it holds {other}; {place} was sent")
        if abs(other_ns - time_ns) > SAME_S * NS_PER_S:
            found.append(f"pose {number}: it holds {other_ns / NS_PER_S:g} s; {time_ns / NS_PER_S:g} s was sent")
    if abs(held.loop_ns - sent.loop_ns) > SAME_S * NS_PER_S:
        found.append(f"its loop begins at {held.loop_ns / NS_PER_S:g} s; {sent.loop_ns / NS_PER_S:g} s was sent")
    return tuple(found)

"""A trajectory as robots without a clock drive it: stops, the speed to reach each with, and how long to wait there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import PlanError
from rota.limits import SHORTEST_LOOP_S
from rota.plan import Plan, Trajectory

PlaceM = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class RouteStop:
    """A place (x, y, height) in metres to reach at ``speed_m_s`` and to wait at for ``hold_s``.

    Raises PlanError for values that are not finite, a speed that is not more than 0 and a wait below 0.
    """

    place_m: PlaceM
    speed_m_s: float
    hold_s: float = 0.0

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.place_m)):
            raise PlanError(f"a stop at {self.place_m}; coordinates must be finite")
        if not 0 < self.speed_m_s < math.inf:
            raise PlanError(f"a stop reached at {self.speed_m_s} m/s; speeds must be finite and more than 0")
        if not 0 <= self.hold_s < math.inf:
            raise PlanError(f"a stop with a wait of {self.hold_s} s; waits must be finite and 0 or more")


@dataclass(frozen=True, kw_only=True)
class Route:
    """What one robot drives: ``approach`` once, then ``loop`` for ever; a loop of one stop is a place to stay at.

    The robot begins at ``approach[0]``, whose speed means nothing. The approach ends, and every round ends, at one
    place: ``approach[-1]`` and ``loop[-1]`` are there, and ``loop[0]`` is the first stop after it. A wait there is part
    of both. Raises PlanError where the loop does not close, and for an approach or a loop without stops.
    """

    robot: str
    approach: tuple[RouteStop, ...]
    loop: tuple[RouteStop, ...]

    def __post_init__(self) -> None:
        if not self.approach or not self.loop:
            raise PlanError(f"robot {self.robot}: a route needs a stop in its approach and one in its loop")
        if self.approach[-1].place_m != self.loop[-1].place_m:
            raise PlanError(
                f"robot {self.robot}: the loop does not close: the approach ends at {self.approach[-1].place_m}, the"
                f" loop at {self.loop[-1].place_m}"
            )

    @property
    def stays(self) -> bool:
        """Whether the robot stays where its approach ends."""
        return len(self.loop) == 1


def route_of(plan: Plan, trajectory: Trajectory) -> Route:
    """The stops of one robot of a plan. Legs of no length become waits; flat positions get the fleet's altitude.

    A wait at which the loop begins is added to the approach's last stop and to the loop's last, so that both the first
    round and all later ones begin with it.
    """
    fleet, k = plan.mission.fleet, trajectory.loop_index
    resting_m_s = fleet.robot(trajectory.robot).speed_m_s
    places_m = trajectory.positions_m
    if places_m.shape[1] == 2:
        places_m = np.column_stack([places_m, np.full(len(places_m), fleet.altitude_m)])
    lengths_m = np.sqrt((np.diff(places_m, axis=0) ** 2).sum(axis=1)).tolist()
    durations_s = np.diff(trajectory.times_s).tolist()
    places: list[PlaceM] = [(x, y, height) for x, y, height in places_m.tolist()]

    def visit(first: RouteStop, legs: range) -> list[RouteStop]:
        """``first``, then the stops after it at the ends of these legs."""
        stops = [first]
        for leg in legs:
            if lengths_m[leg] == 0:
                stops[-1] = replace(stops[-1], hold_s=stops[-1].hold_s + durations_s[leg])
            else:
                speed_m_s = lengths_m[leg] / durations_s[leg]
                stops.append(RouteStop(place_m=places[leg + 1], speed_m_s=speed_m_s))
        return stops

    approach = visit(RouteStop(place_m=places[0], speed_m_s=resting_m_s), range(k))
    here = RouteStop(place_m=places[k], speed_m_s=approach[-1].speed_m_s)
    begin, *loop = visit(here, range(k, len(lengths_m)))
    if not loop:
        return Route(robot=trajectory.robot, approach=tuple(approach), loop=(here,))
    approach[-1] = replace(approach[-1], hold_s=approach[-1].hold_s + begin.hold_s)
    loop[-1] = replace(loop[-1], hold_s=loop[-1].hold_s + begin.hold_s)
    return Route(robot=trajectory.robot, approach=tuple(approach), loop=tuple(loop))


def trajectory_of(route: Route, *, flat: bool) -> Trajectory:
    """The trajectory of a robot that drives the route exactly; ``flat``: with positions (n, 2), else (n, 3).

    Raises PlanError for a loop that takes less time than a trajectory's may.
    """
    times_s, places, now_s = [0.0], [route.approach[0].place_m], 0.0

    def add(stops: tuple[RouteStop, ...]) -> None:
        nonlocal now_s
        for stop in stops:
            for duration_s in (math.dist(places[-1], stop.place_m) / stop.speed_m_s, stop.hold_s):
                if now_s + duration_s > now_s:
                    now_s += duration_s
                    times_s.append(now_s)
                    places.append(stop.place_m)

    add(route.approach)
    loop_start_s = now_s
    if not route.stays:
        add(route.loop)
        if now_s - loop_start_s < SHORTEST_LOOP_S:
            raise PlanError(f"robot {route.robot}: its loop takes {now_s - loop_start_s:.3g} s, too short to be driven")
    positions_m = np.array(places)[:, : 2 if flat else 3]
    return Trajectory(robot=route.robot, times_s=np.array(times_s), positions_m=positions_m, loop_start_s=loop_start_s)

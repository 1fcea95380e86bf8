"""Trajectories as a picture needs them: where a robot is, which robots share a loop, where arrowheads go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rota.draw.palette import FLOWN_ONCE, route_style
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.routes.flights import flights_of, has_flights, takes_turns
from rota.routes.served_loops import Service, corners, loop_letter, same_ring, service_of

SAME_PLACE_M = 1e-6
ONCE = -1  # what flights serve that are flown once


@dataclass(frozen=True, kw_only=True)
class Route:
    """A closed loop, drawn once, and the robots on it. ``robots``: indices into the plan's trajectories, increasing.

    loop_m: (n, 2) metres, the first point again at the end; one point for robots that stay where they are. starts_m:
    (robots, 2), where each of them begins its loop. letter: what a loop is called that robots which charge take turns
    at; they come to it at starts_m, (k, 2). None: it is called by its robots.
    """

    robots: tuple[int, ...]
    loop_m: Floats
    starts_m: Floats
    duration_s: float
    letter: str | None = None

    @property
    def length_m(self) -> float:
        """Length of the loop in metres; 0 for robots that stay."""
        return float(np.hypot(*np.diff(self.loop_m, axis=0).T).sum())


def serves_loops(plan: Plan) -> bool:
    """Whether robots that charge take turns at loops; those of a swarm close the gap instead."""
    return takes_turns(plan) and not plan.mission.planning.makes_runs


def routes_of(plan: Plan) -> tuple[Route, ...]:
    """The plan's loops, each once, in the order of their first robots.

    Robots share a loop when their polylines are the same closed curve run the same way in the same time, wherever on it
    each begins. Robots that stay are never merged. Of robots that charge it is the loops that they take turns at.
    """
    routes = list(_loops_in_turns(plan)) if serves_loops(plan) else []
    rings: list[Floats] = [np.empty((0, 2))] * len(routes)
    for index, trajectory in enumerate(plan):
        if has_flights(trajectory) and serves_loops(plan):
            continue
        loop_m = trajectory.positions_m[trajectory.loop_index :, :2]
        ring = corners(loop_m) if trajectory.loop_duration_s > 0 else loop_m[:0]
        duration_s = trajectory.loop_duration_s
        for k, route in enumerate(routes):
            if abs(route.duration_s - duration_s) <= 1e-6 * duration_s and same_ring(rings[k], ring):
                starts_m = np.concatenate([route.starts_m, loop_m[:1]])
                routes[k] = replace(route, robots=(*route.robots, index), starts_m=starts_m)
                break
        else:
            routes.append(Route(robots=(index,), loop_m=loop_m, starts_m=loop_m[:1], duration_s=duration_s))
            rings.append(ring)
    return tuple(routes)


def service_in(plan: Plan) -> Service:
    """What the flights of the robots that charge serve: those of ``flights_of``, robot by robot.

    A plan that took over begins with flights that are flown once, to their ends. They serve ONCE, and no loop, where
    others are flown again and again.
    """
    flights = [flight for one in plan if has_flights(one) for flight in flights_of(one)]
    found = service_of(flights)
    again = sorted({loop for loop, flight in zip(found.serves, flights, strict=True) if flight.every_s > 0})
    if not again:
        return found
    number_of = {loop: number for number, loop in enumerate(again)}
    serves = tuple(number_of.get(loop, ONCE) for loop in found.serves)
    return replace(found, loops=tuple(found.loops[loop] for loop in again), serves=serves)


def flight_colour(loop: int) -> str:
    """The colour of flights that serve a loop, or ONCE."""
    return FLOWN_ONCE if loop == ONCE else route_style(loop)[0]


def _loops_in_turns(plan: Plan) -> Iterator[Route]:
    """The loops that robots which charge take turns at."""
    number_of = {trajectory.robot: number for number, trajectory in enumerate(plan)}
    for number, loop in enumerate(service_in(plan).loops):
        yield Route(
            robots=tuple(sorted(number_of[name] for name in loop.robots)),
            loop_m=loop.line_m,
            starts_m=loop.handovers_m,
            duration_s=loop.round_s,
            letter=loop_letter(number),
        )


def arrowheads(loop_m: Floats, count: int, clear_m: float) -> tuple[Floats, Floats]:
    """Places (n, 2) in metres and directions (n, 2), unit vectors, of ``count`` arrowheads spread evenly along a loop.

    They stay ``clear_m`` away from the corners, or on short legs in the middle. None at all on a loop without length.
    """
    steps = np.diff(loop_m, axis=0)
    lengths_m = np.hypot(*steps.T)
    legs = np.flatnonzero(lengths_m > SAME_PLACE_M)
    if not len(legs):
        return np.empty((0, 2)), np.empty((0, 2))
    ends_m = np.cumsum(lengths_m[legs])
    along_m = (np.arange(count) + 0.5) / count * ends_m[-1]
    which = np.minimum(np.searchsorted(ends_m, along_m), len(legs) - 1)
    leg = legs[which]
    edge = np.minimum(clear_m / lengths_m[leg], 0.5)
    fraction = np.clip(1 - (ends_m[which] - along_m) / lengths_m[leg], edge, 1 - edge)
    return loop_m[leg] + fraction[:, None] * steps[leg], steps[leg] / lengths_m[leg][:, None]

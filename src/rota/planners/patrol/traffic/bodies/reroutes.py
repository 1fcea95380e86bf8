"""Tours led elsewhere where no timing keeps bodies apart: in lanes, round who stays, cut, or changed over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.tours.tour import Tour, over_budget_share
from rota.planners.patrol.traffic.bodies.exchanges import exchanges, with_more_robots
from rota.planners.patrol.traffic.bodies.lanes import in_lanes, round_those_who_stay
from rota.planners.patrol.traffic.bodies.timing import can_be_timed, crowds_that_touch


def reroute(
    tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths, *, may_add: bool = False
) -> list[Tour] | None:
    """The tours led elsewhere, so that all bodies can be kept apart by timing; None when no routes were found.

    Each crowd keeps its budgets and its number of robots; with ``may_add`` it gets more where that is not enough. What
    is seen may change a little, at corners that are cut and beside lanes: repair is left to the caller.
    """
    touching = crowds_that_touch(tours, body_radius_m)
    if not touching:
        return None
    led = [tour for k, tour in enumerate(tours) if not any(k in crowd for crowd in touching)]
    for crowd in touching:
        some = [tours[k] for k in crowd]
        apart = crowd_led_apart(some, body_radius_m, space, paths, more=False)
        if apart is None and may_add:
            apart = crowd_led_apart(some, body_radius_m, space, paths, more=True)
        if apart is None:
            return None
        led += apart
    return led


def crowd_led_apart(
    tours: list[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths, *, more: bool
) -> list[Tour] | None:
    """One crowd led elsewhere, with as many robots as it has, or with more; None when no routes were found."""
    robots = sum(tour.robots for tour in tours)
    fitting = (
        anew
        for anew in other_routes(tours, body_radius_m, space, paths, more=more)
        if (sum(tour.robots for tour in anew) > robots) == more and over_budget_share(anew) == 0
    )
    # twelve other routes for one crowd
    return next((anew for anew in islice(fitting, 12) if can_be_timed(anew, body_radius_m)), None)


def other_routes(
    tours: list[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths, *, more: bool
) -> Iterator[list[Tour]]:
    """Other tours for as many robots, or also for more, those that change least first."""
    near_m = 4.0 * body_radius_m  # lines so near to each other can be cut and joined across
    around = round_those_who_stay(tours, body_radius_m, space)
    begun = [tours] if around is None else [around, tours]
    if around is not None:
        yield around
    for some in begun:
        yield from move_into_lanes(some, body_radius_m, space, paths)
    for some in begun:
        for anew in exchanges(some, near_m, paths):
            yield anew
            yield from move_into_lanes(anew, body_radius_m, space, paths)
        if more:
            yield from with_more_robots(some, near_m, paths)


def move_into_lanes(
    tours: list[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths
) -> Iterator[list[Tour]]:
    """The tours in lanes, if that moves any of them."""
    moved = in_lanes(tours, body_radius_m, space, paths)
    if any(after is not before for after, before in zip(moved, tours, strict=True)):
        yield moved

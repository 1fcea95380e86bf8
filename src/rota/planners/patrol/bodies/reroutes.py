"""Tours led another way where no timing keeps bodies apart: in lanes, round who stays, cut, or changed over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.annealing.tour import Tour, over_budget_share
from rota.planners.patrol.bodies.exchanges import exchanges, with_more_robots
from rota.planners.patrol.bodies.lanes import in_lanes, round_those_who_stay
from rota.planners.patrol.bodies.timing import can_be_timed, crowds_that_touch

MOST_TRIED = 12  # other ways for one crowd
NEAR = 4.0  # bodies: lines so near each other can be cut and joined across


def rerouted(
    tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths, *, may_add: bool = False
) -> list[Tour] | None:
    """The tours led another way, so that all bodies can be kept apart by timing; None when no way was found.

    Crowd by crowd, within the budgets, with as many robots; with ``may_add`` there may be more. What is seen may change
    a little, at corners that are cut and beside lanes; it is left to the caller to mend that.
    """
    touching = crowds_that_touch(tours, body_radius_m)
    if not touching:
        return None
    found = [tour for k, tour in enumerate(tours) if not any(k in crowd for crowd in touching)]
    for crowd in touching:
        some = [tours[k] for k in crowd]
        robots = sum(tour.robots for tour in some)
        ways = other_ways(some, body_radius_m, space, paths, may_add=may_add)
        fitting = (
            anew
            for anew in ways
            if over_budget_share(anew) == 0 and (may_add or sum(tour.robots for tour in anew) <= robots)
        )
        apart = next((anew for anew in islice(fitting, MOST_TRIED) if can_be_timed(anew, body_radius_m)), None)
        if apart is None:
            return None
        found += apart
    return found


def other_ways(
    tours: list[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths, *, may_add: bool
) -> Iterator[list[Tour]]:
    """Other tours for the same robots, or for more if that may be, those that change least first."""
    near_m = NEAR * body_radius_m
    around = round_those_who_stay(tours, body_radius_m, space)
    if around is not None:
        # nothing else helps as long as somebody stays in the way
        yield around
        tours = around
    yield in_lanes(tours, body_radius_m, space, paths)
    for anew in exchanges(tours, near_m, paths):
        yield anew
        yield in_lanes(anew, body_radius_m, space, paths)
    if may_add:
        yield from with_more_robots(tours, near_m, paths)

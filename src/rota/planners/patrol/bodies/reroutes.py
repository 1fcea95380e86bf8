"""Tours led another way where no timing keeps bodies apart: in lanes, round who stays, cut, or changed over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.annealing.tour import Tour, over_budget_share
from rota.planners.patrol.bodies.exchanges import exchanges
from rota.planners.patrol.bodies.lanes import in_lanes, round_those_who_stay
from rota.planners.patrol.bodies.timing import can_be_timed, crowds_that_touch

MOST_TRIED = 16  # other ways for one crowd
NEAR = 4.0  # bodies: lines so near each other can be cut and joined across


def rerouted(
    tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths
) -> list[Tour] | None:
    """The tours led another way, so that all bodies can be kept apart by timing; None when no way was found.

    Crowd by crowd, within the budgets. What is seen may change a little, at corners that are cut and beside lanes.
    """
    found = list(tours)
    for crowd in crowds_that_touch(tours, body_radius_m):
        rest = [tour for k, tour in enumerate(found) if k not in crowd]
        apart = None
        for anew in islice(other_ways([tours[k] for k in crowd], body_radius_m, space, paths), MOST_TRIED):
            if over_budget_share(anew) == 0 and can_be_timed(anew, body_radius_m):
                apart = anew
                break
        if apart is None:
            return None
        keep = [tour for tour in rest if not any(tour is tours[k] for k in crowd)]
        found = [*keep, *apart]
    return None if crowds_that_touch(found, body_radius_m) else found


def other_ways(
    tours: list[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths
) -> Iterator[list[Tour]]:
    """Other tours for the same robots, those that change least first."""
    near_m = NEAR * body_radius_m
    begun = [tours]
    around = round_those_who_stay(tours, body_radius_m, space)
    if around is not None:
        begun.append(around)
        yield around
    for some in begun:
        yield in_lanes(some, body_radius_m, space, paths)
    for some in begun:
        for anew in exchanges(some, near_m, paths):
            yield anew
            yield in_lanes(anew, body_radius_m, space, paths)

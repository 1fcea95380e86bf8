"""Tours led elsewhere where no timing keeps bodies apart: in lanes, round who stays, cut, or changed over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
from scipy.spatial import cKDTree
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.planners.patrol.driving.polylines import split_legs, without_straight_vertices
from rota.planners.patrol.tours.tour import Tour, over_budget_share, tour_length_m
from rota.planners.patrol.traffic.bodies.lanes import in_lanes, round_those_who_stay
from rota.planners.patrol.traffic.bodies.loops import FEW_TRIED
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


def cut_in_two(tour: Tour, near_m: float, paths: ShortestPaths) -> Iterator[tuple[Tour, Tour]]:
    """Two loops instead of one with several robots, cut where it comes within ``near_m`` of itself; roomiest first.

    Both keep the period and share the robots; only cuts that keep both within their budgets.
    """
    if tour.robots < 2 or len(tour.vertices_m) < 2:
        return
    length_m = float(np.hypot(*(np.roll(tour.vertices_m, -1, axis=0) - tour.vertices_m).T).sum())
    points = split_legs(tour.vertices_m, max(length_m / 240, 1e-9))  # places along a loop
    legs = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    along = np.concatenate([[0.0], np.cumsum(legs)[:-1]])
    pairs = cKDTree(points).query_pairs(near_m, output_type="ndarray")
    if not len(pairs):
        return
    i, j = np.sort(pairs, axis=1).T
    across = np.hypot(*(points[i] - points[j]).T)
    inner = along[j] - along[i]
    one, other = inner + across, length_m - inner + across
    budget_m = replace(tour, robots=1).budget_m
    shares = np.arange(1, tour.robots)
    fullest = np.maximum(one[:, None] / shares, other[:, None] / (tour.robots - shares)) / budget_m
    best = fullest.argmin(axis=1)
    order = np.argsort(fullest[np.arange(len(i)), best], kind="stable")
    taken: list[tuple[float, float]] = []
    for k in order:
        if len(taken) == FEW_TRIED or fullest[k, best[k]] > 1:
            return
        ends = (along[i[k]] / length_m, along[j[k]] / length_m)
        # of the loop: of cuts so near to each other one is tried
        if any(max(abs(ends[0] - a), abs(ends[1] - b)) < 0.08 for a, b in taken):
            continue
        taken.append(ends)
        robots = int(shares[best[k]])
        inside = close(replace(tour, robots=robots), points[i[k] : j[k] + 1], paths)
        rest = np.vstack([points[j[k] :], points[: i[k] + 1]])
        outside = close(replace(tour, robots=tour.robots - robots), rest, paths)
        if inside is not None and outside is not None:
            yield inside, outside


def close(tour: Tour, points_m: Floats, paths: ShortestPaths) -> Tour | None:
    """The tour along the points (n, 2) and back to the first by the shortest way; None when that is over its budget."""
    try:
        route = paths.paths_along(np.vstack([points_m, points_m[:1]]))
    except PlanError:
        return None
    loop = replace(tour, vertices_m=without_straight_vertices(route[:-1] if len(route) > 1 else route))
    return loop if tour_length_m(loop) <= loop.budget_m else None


def join(a: Tour, b: Tour, near_m: float) -> Tour | None:
    """One loop for the robots of both, over the lines of both, changed over where they are nearest; None: too far."""
    points = [split_legs(tour.vertices_m, near_m / 2) for tour in (a, b)]
    apart, nearest = cKDTree(points[1]).query(points[0])
    i = int(np.argmin(apart))
    if apart[i] > near_m:
        return None
    first = np.vstack([np.roll(points[0], -i, axis=0), points[0][i : i + 1]])
    second = np.roll(points[1], -int(nearest[i]), axis=0)
    quick = a if a.period_class <= b.period_class else b
    return replace(quick, vertices_m=np.vstack([first, second, second[:1]]), robots=a.robots + b.robots)


def change_over(a: Tour, b: Tour, near_m: float, paths: ShortestPaths) -> Iterator[tuple[Tour, Tour]]:
    """Two other loops over the lines of both, each with robots of its own, for tours of one period and one part."""
    if a.period_class != b.period_class or a.component != b.component or len(a.vertices_m) < 2 or len(b.vertices_m) < 2:
        return
    whole = join(a, b, near_m)
    if whole is not None:
        yield from cut_in_two(whole, near_m, paths)


def cut_to_the_last(tour: Tour, near_m: float, paths: ShortestPaths) -> list[Tour] | None:
    """As many loops as robots, each its own; None where cuts within the budgets do not lead that far."""
    if tour.robots == 1:
        return [tour]
    for inner, outer in islice(cut_in_two(tour, near_m, paths), 2):  # cuts whose pieces are cut further
        parts = [cut_to_the_last(part, near_m, paths) for part in (inner, outer)]
        if parts[0] is not None and parts[1] is not None:
            return [*parts[0], *parts[1]]
    return None


def exchanges(tours: Sequence[Tour], near_m: float, paths: ShortestPaths) -> Iterator[list[Tour]]:
    """Other tours for the same robots: shared loops cut up, then pairs that change over."""
    shared = [k for k, tour in enumerate(tours) if tour.robots > 1]
    if sum(tours[k].robots - 1 for k in shared) > 1:  # else it is the cut in two below
        split = [cut_to_the_last(tour, near_m, paths) for tour in tours]
        if all(parts is not None for parts in split):
            yield [part for parts in split for part in parts or ()]
    for k in shared:
        for first, second in cut_in_two(tours[k], near_m, paths):
            yield [*tours[:k], first, second, *tours[k + 1 :]]
    for k in range(len(tours)):
        for i in range(k):
            for first, second in change_over(tours[i], tours[k], near_m, paths):
                yield [*(tour for n, tour in enumerate(tours) if n not in (i, k)), first, second]


def with_more_robots(tours: Sequence[Tour], near_m: float, paths: ShortestPaths) -> Iterator[list[Tour]]:
    """The tours with one of them cut up, for one or more robots more than it has."""
    for more in range(1, 4):  # robots more than the loop has
        for k, tour in enumerate(tours):
            parts = cut_to_the_last(replace(tour, robots=tour.robots + more), near_m, paths)
            if parts is not None:
                yield [*tours[:k], *parts, *tours[k + 1 :]]

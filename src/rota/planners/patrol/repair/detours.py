"""Ways of their own to what bending does not bring into sight: past places that see it, by the least detour."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.line_of_sight import points_inside, segments_free, visibility_polygon
from rota.planners.patrol.ground.nearest_kernels import nearest_on_segments
from rota.planners.patrol.ground.nearest_places import nearest_places, segments_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.ground.sight import sensor_arguments
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, place_that_sees, what_places_see
from rota.planners.patrol.tours.tour import Tour, room_m

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ON_ROUTE_M = 1e-7  # a place so near a route is on it
ONE_PLACE_M = 1e-5  # places nearer to each other than this are one
ON_BORDER_M = 1e-9  # a place so near a border is on it
OFF_BORDER_M = 1e-8  # a place so far inside is surely inside
HAIRS_M = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 0.0)  # off the edge of a view, as far as it is wide enough
ACROSS = 0.02  # of the reach: how far to either side of a line of sight a tour goes across it
HALVINGS, BISECTIONS = 6, 32  # of that way, where something stands in it
DEPTHS = 16  # places along the line of sight that are tried, up to the reach
FIRST_DETOURS, MOST_DETOURS = 2, 32  # legs for which ways round obstacles are measured at once, at first and at most


def visit_places(
    problem: Problem, tours: list[Tour], points: SamplePoints, samples: Samples, unseen: Ints, *, further: bool
) -> list[Tour] | None:
    """Tours led along shortest paths past places that see the unseen samples; None where there are none.

    further: also past places other than the candidates, of which each sees the one sample that it was looked for.
    """
    wanted = np.zeros(len(points), dtype=bool)
    wanted[unseen] = True
    places_m = near_places(problem, points.xy_m[unseen])
    start, items = what_places_see(places_m, problem.robot, problem.range_margin_m, samples)
    chosen, hidden = choose_viewpoints(start, items, wanted, points.area_m2)
    stops = [
        (places_m[i][None], min(points.period[s] for s in items[start[i] : start[i + 1]] if wanted[s])) for i in chosen
    ]
    for i in np.flatnonzero(hidden) if further else ():
        place = last_place(problem, points, int(i))
        if place is not None:
            stops.append((way_across(problem, points.xy_m[i], place), int(points.period[i])))
    if not stops:
        return None
    for way_m, period in stops:
        middle_m = way_m[len(way_m) // 2]
        if not any((np.hypot(*(tour.vertices_m - middle_m).T) < ONE_PLACE_M).any() for tour in tours):
            tours = led_past(problem, tours, way_m, int(period))
    return tours


def way_across(problem: Problem, point_m: Floats, place_m: Floats) -> Floats:
    """A short straight way (k, 2) across a line of sight, near the place that sees the point; k is 1 to 3.

    Between the walls of a scanned floor much is seen through slits only: the nearer to a wall a point lies, the nearer
    to that wall's line is all that sees it. No place sees all points beside the wall, but who crosses the line does,
    one after the other. Where robots can stand begins at that line, too often: so the way is the first, from the place
    onwards, that has room on both sides, and where none has, it ends at the very border. Elsewhere than on ragged
    ground it is the place alone.
    """
    away_m = float(np.hypot(*(place_m - point_m)))
    if not problem.is_ragged or away_m == 0:
        return place_m[None]
    along = (place_m - point_m) / away_m
    across = ACROSS * problem.reach_m * np.array([-along[1], along[0]])
    furthest_m = max(0.0, (1 - 2 * ACROSS) * problem.reach_m - away_m)
    middles = place_m + np.linspace(0.0, furthest_m, DEPTHS)[:, None] * along
    shares = 0.5 ** np.arange(HALVINGS + 1)
    ends = middles[:, None, None] + np.array([-1.0, 1.0])[:, None, None] * (shares[:, None] * across)
    free = reached_straight(problem, np.broadcast_to(middles[:, None, None], ends.shape), ends)
    room = np.where(free, shares, 0.0).max(axis=2)  # (depths, sides) of the way to either side
    room[~reached_straight(problem, np.broadcast_to(place_m, middles.shape), middles)] = -1.0
    k = int(np.argmax(room.min(axis=1) + room.max(axis=1) / 2**HALVINGS))
    if room[k].max() == 0:  # in a corridor as narrow as the body a timetable could not tell the ends of the way apart
        return place_m[None]
    left, right = (border_along(problem, middles[k], side * across, room[k, i]) for i, side in enumerate((-1.0, 1.0)))
    return np.array([place for place in (left, middles[k], right) if place is not None])


def reached_straight(problem: Problem, begins_m: Floats, ends_m: Floats) -> NDArray[np.bool_]:
    """Whether robots get straight from places in the space to others, (..., 2) each: (...) flags."""
    grid = problem.paths.grid
    begins, ends = begins_m.reshape(-1, 2), ends_m.reshape(-1, 2)
    return np.asarray(points_inside(ends, grid) & segments_free(begins, ends, grid)).reshape(ends_m.shape[:-1])


def border_along(problem: Problem, begin_m: Floats, way_m: Floats, share: float) -> Floats | None:
    """How far robots get from a place along a straight way, a share of which is known to be free; None: nowhere.

    A hair before the border: what touches it counts as inside, and might be just outside.
    """
    low, high = share, min(1.0, 2 * share) if share > 0 else 0.5**HALVINGS
    for _ in range(BISECTIONS if share < 1 else 0):
        middle = (low + high) / 2
        if reached_straight(problem, begin_m[None], (begin_m + middle * way_m)[None])[0]:
            low = middle
        else:
            high = middle
    low -= OFF_BORDER_M / float(np.hypot(*way_m)) if share < 1 else 0.0
    return begin_m + low * way_m if low > 0 else None


def last_place(problem: Problem, points: SamplePoints, i: int) -> Floats | None:
    """A place for a sample that no candidate sees: with room all round if there is any, or at the border."""
    space, walls, robot = problem.space, problem.walls, problem.robot
    place = None
    if points.shrink_m[i] >= 0:
        place = place_that_sees(points.xy_m[i], points.visit_m[i], space, walls, robot, problem.range_margin_m)
    return border_place(problem, points.xy_m[i]) if place is None and points.visit_m[i] == 0 else place


def near_places(problem: Problem, xy_m: Floats) -> Floats:
    """The candidate places within reach of any of the points (n, 2)."""
    tree = cKDTree(problem.viewpoints.xy_m)
    near = tree.query_ball_point(xy_m, problem.robot.sensor.reach_m)
    return problem.viewpoints.xy_m[sorted({int(i) for row in near for i in row})].reshape(-1, 2)


def nearby_place(problem: Problem, point_m: Floats, visit_m: float, turn: int) -> Floats | None:
    """A place from where the point is seen well: in the middle of its view, of a view cut shorter every turn."""
    margin_m = problem.reach_m * (1 - 0.6**turn) + problem.range_margin_m
    place = place_that_sees(point_m, visit_m, problem.space, problem.walls, problem.robot, margin_m)
    return border_place(problem, point_m) if place is None and visit_m == 0 else place


def border_place(problem: Problem, point_m: Floats) -> Floats | None:
    """The place that sees the point from least far, on the border of where robots can stand; None out of reach.

    On ragged ground it is a hair inside of what the point sees: from the very edge of a view rounding decides. Of a
    view narrower than any hair it is where the space ends: what is nearer to a wall than the point is seen from there.
    """
    if not problem.is_ragged:
        nearest_m, ranges_m = nearest_places(point_m, problem.space, problem.walls, problem.robot)
        return nearest_m[0] if ranges_m[0] <= problem.reach_m else None
    _, square = sensor_arguments(problem.robot, 0.0)
    places = places_in_view(problem, point_m)
    for hair_m in HAIRS_M:
        inside = segments_of(places.buffer(-hair_m)) if hair_m > 0 else ends_of(places, problem.space)
        if len(inside):
            place_m, range_m = nearest_on_segments(point_m[None], inside, square)
            if range_m[0] <= problem.reach_m:
                return np.asarray(place_m[0])
    return None


def places_in_view(problem: Problem, point_m: Floats) -> BaseGeometry:
    """Where a robot may stand in sight of the point, as far off as the corner of a square sensor."""
    view = visibility_polygon(point_m, problem.walls, problem.robot.sensor.reach_m)
    return view.intersection(problem.space)


def ends_of(places: BaseGeometry, space: MultiPolygon) -> Floats:
    """The sides (k, 4) of the places where the space ends too; all their sides where there are none."""
    sides = segments_of(places)
    on_border = shapely.dwithin(space.boundary, shapely.points(sides.reshape(-1, 2, 2)), ON_BORDER_M).all(axis=1)
    return sides[on_border] if on_border.any() else sides


def led_past(problem: Problem, tours: list[Tour], way_m: Floats, period: int) -> list[Tour]:
    """The tours, the one that has the least detour led along a short straight way (k, 2), or past a place (1, 2).

    A new tour when none may or can go there. A robot of its own is posted there also where the detour would take more
    than one robot travels in a period.
    """
    place_m = way_m[len(way_m) // 2]
    component = int(problem.paths.part_of(place_m[None])[0])
    able = [k for k, tour in enumerate(tours) if tour.period_class <= period and tour.component == component]
    straight_m = {k: float(straight_detours(tours[k].vertices_m, place_m).min()) for k in able}
    best: tuple[float, int, int] | None = None
    for k in sorted(able, key=straight_m.__getitem__):
        if best is not None and straight_m[k] > best[0] + ON_ROUTE_M:
            break  # no detour is shorter than straight
        tour = tours[k]
        i, detour_m = least_detour(problem, tour.vertices_m, place_m)
        room = room_m(tours, k)
        if min(detour_m, detour_m - room) > replace(tour, robots=1).budget_m:
            continue
        cost = detour_m + 3 * max(0.0, detour_m - room)
        if math.isfinite(cost) and (best is None or (cost, k) < best[:2]):
            best = (cost, k, i)
    if best is None:
        alone = Tour(
            vertices_m=way_m, period_class=period, period_s=problem.periods_s[period], robots=1,
            robot=problem.robot, component=component,
        )  # fmt: skip
        return [*tours, alone]
    _, k, i = best
    return [*tours[:k], with_detour(problem, tours[k], i, way_m), *tours[k + 1 :]]


def with_detour(problem: Problem, tour: Tour, i: int, way_m: Floats) -> Tour:
    """The tour led along a way (k, 2), in the direction that is shorter, between its i-th place and the next."""
    vertices = tour.vertices_m
    before, after = vertices[i], vertices[(i + 1) % len(vertices)]
    ways = (way_m, way_m[::-1])
    way_m = min(ways, key=lambda way: float(np.hypot(*(way[0] - before)) + np.hypot(*(way[-1] - after))))
    detour = problem.paths.paths_along(np.vstack([before, way_m, after]))[1:-1]
    # a timetable keeps but one of places so near each other; slivers of views lie beside each other on ragged ground
    away_m = np.hypot(*(vertices - way_m[len(way_m) // 2]).T)
    replaced = (len(way_m) == 1) & (away_m > 0) & (away_m < ONE_PLACE_M) & problem.is_ragged & (tour.nest < 0)
    longer = np.vstack([vertices[: i + 1][~replaced[: i + 1]], detour, vertices[i + 1 :][~replaced[i + 1 :]]])
    return replace(tour, vertices_m=longer)


def least_detour(problem: Problem, vertices_m: Floats, place_m: Floats) -> tuple[int, float]:
    """The leg of a closed tour (n, 2) with the shortest detour past the place, the first of several; and its metres.

    inf where no way leads there. Legs are looked at by their straight detours, for no way is shorter than straight.
    """
    ends_m = np.roll(vertices_m, -1, axis=0)
    legs_m = np.hypot(*(ends_m - vertices_m).T)
    straight_m = straight_detours(vertices_m, place_m)
    order = np.argsort(straight_m, kind="stable")
    best = (math.inf, 0)
    first, count = 0, FIRST_DETOURS
    while first < len(order):
        some = order[first : first + count]
        first, count = first + count, min(2 * count, MOST_DETOURS)
        if straight_m[some[0]] > best[0] + ON_ROUTE_M:
            break
        ways_m = problem.paths.distances(np.vstack([vertices_m[some], ends_m[some]]), place_m[None])[:, 0]
        detours_m = ways_m[: len(some)] + ways_m[len(some) :] - legs_m[some]
        best = min(best, *zip(detours_m.tolist(), some.tolist(), strict=True))
    return best[1], best[0]


def straight_detours(vertices_m: Floats, place_m: Floats) -> Floats:
    """Metres (n,) that each leg of a closed tour (n, 2) would be longer past the place, if nothing were in the way."""
    legs_m = np.hypot(*(np.roll(vertices_m, -1, axis=0) - vertices_m).T)
    away_m = np.hypot(*(vertices_m - place_m).T)
    straight_m: Floats = away_m + np.roll(away_m, -1) - legs_m
    return straight_m

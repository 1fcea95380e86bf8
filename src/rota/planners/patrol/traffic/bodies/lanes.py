"""Routes moved sideways: lanes for robots that come towards each other, and ways round robots that stay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry.free_space import nearest_free_point
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.polygons import polygons_of
from rota.planners.patrol.driving.polylines import split_legs, without_straight_vertices
from rota.planners.patrol.ground.keeping_off import QUARTER_CORNERS
from rota.planners.patrol.tours.tour import Tour, tour_length_m

LANE_SPACING = 1.1  # of two bodies: between two lanes, with what timing on a grid of samples takes
STRAIGHTENING = 0.02  # of a body: points of a route that stand out less are left out


def in_lanes(tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths) -> list[Tour]:
    """The tours, moved apart where robots come towards each other on nearly the same line: they keep right.

    A robot that has the other one clearly on its right keeps left. Tours move as far as the space, where centres of
    bodies can be, allows. Tours of robots that stay remain as they are, and so does a tour on which a lone robot meets
    only itself.
    """
    led = list(tours)
    for _ in range(3):  # steps in which tours move apart
        moved = move_apart(led, body_radius_m, space, paths)
        if moved is None:
            break
        led = moved
    return led


def move_apart(
    tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths
) -> list[Tour] | None:
    """The tours after one step apart; None when nobody comes towards anybody too near."""
    wide_m = 2 * body_radius_m * LANE_SPACING
    # four points of a line per body radius, and 20,000 over all tours
    between_m = max(body_radius_m / 4, sum(tour_length_m(tour) for tour in tours) / 20_000)
    lines = [split_legs(tour.vertices_m, between_m) for tour in tours]
    line = np.repeat(np.arange(len(lines)), [len(points) for points in lines])
    places = np.vstack(lines)
    ahead = np.vstack([np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0) for points in lines])
    ahead /= np.maximum(np.hypot(*ahead.T), 1e-12)[:, None]
    who, whom = cKDTree(places).query_pairs(wide_m, output_type="ndarray").T
    who, whom = np.concatenate([who, whom]), np.concatenate([whom, who])
    shared = np.array([tour.robots > 1 for tour in tours])
    # towards each other: at 120 degrees or more
    meets = ((line[who] != line[whom]) | shared[line[who]]) & ((ahead[who] * ahead[whom]).sum(axis=1) < -0.5)
    who, whom = who[meets], whom[meets]
    gap = places[whom] - places[who]
    left_m = ahead[who, 0] * gap[:, 1] - ahead[who, 1] * gap[:, 0]
    right = left_m > -0.5 * body_radius_m  # whoever is farther to the right is passed on the other side
    step_m = np.where(right, wide_m - left_m, -(wide_m + left_m)) / 2
    # to the right as far as the nearest on the left asks; a place with nobody there goes to the left
    to_right, to_left = np.zeros(len(places)), np.zeros(len(places))
    np.maximum.at(to_right, who[right], step_m[right])
    np.minimum.at(to_left, who[~right], step_m[~right])
    shift_m = np.where(to_right > 0, to_right, to_left)
    if np.abs(shift_m).max(initial=0.0) < 1e-3 * body_radius_m:
        return None
    led = list(tours)
    for k, tour in enumerate(tours):
        mine = line == k
        if (shift_m[mine] != 0).any():
            lane = beside(places[mine], ahead[mine], shift_m[mine], body_radius_m)
            led[k] = lead_along(tour, lane, space, paths, STRAIGHTENING * body_radius_m)
    return led


def beside(points_m: Floats, ahead: Floats, shift_m: Floats, body_radius_m: float) -> Floats:
    """Points (m, 2), m <= n, shift_m (n,) to the right of a closed line (n, 2) with unit directions ahead (n, 2).

    Points that come nearer to the line than their shift, inside of its bends, are left out.
    """
    shifted = points_m + shift_m[:, None] * np.column_stack([ahead[:, 1], -ahead[:, 0]])
    near_m = np.full(len(points_m), np.inf)
    for step in range(-12, 13):  # a line may bend back beside so many samples before and after a place
        near_m = np.minimum(near_m, np.hypot(*(shifted - np.roll(points_m, step, axis=0)).T))
    kept = near_m > np.abs(shift_m) * (1 - STRAIGHTENING)
    return np.asarray(shifted[kept | (shift_m == 0)])


def lead_along(tour: Tour, points_m: Floats, space: MultiPolygon, paths: ShortestPaths, straight_m: float) -> Tour:
    """The tour led along the points (n, 2), each moved to the nearest place in the space, without needless points."""
    shapely.prepare(space)
    outside = ~shapely.covers(space, shapely.points(points_m))
    points_m = points_m.copy()
    for i in np.flatnonzero(outside):
        points_m[i] = nearest_free_point(space, (points_m[i, 0], points_m[i, 1]))
    try:
        route = paths.paths_along(np.vstack([points_m, points_m[:1]]))
    except PlanError:
        return tour
    if len(route) > 3:
        simple = shapely.get_coordinates(shapely.LineString(route).simplify(straight_m))
        if len(simple) > 3 and shapely.covers(space, shapely.LineString(simple)):
            route = simple
    return replace(tour, vertices_m=np.ascontiguousarray(route[:-1])) if len(route) > 1 else tour


def round_those_who_stay(tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon) -> list[Tour] | None:
    """The tours led by shortest paths round the robots that stay; None when nobody stays, or a tour has nothing left.

    A robot that keeps within half a body of a place stays there. Where it blocks the space, a tour past it becomes one
    on either side, each with robots of its own.
    """
    spots = [shapely.convex_hull(shapely.MultiPoint(tour.vertices_m)) for tour in tours]
    stays = [shapely.minimum_bounding_radius(spot) <= body_radius_m / 2 for spot in spots]
    if not any(stays) or all(stays):
        return None
    round_m = 2 * body_radius_m * LANE_SPACING / math.cos(math.pi / (4 * QUARTER_CORNERS))
    discs = shapely.union_all([spot.buffer(round_m, quad_segs=QUARTER_CORNERS) for spot in compress(spots, stays)])
    free = polygons_of(space.difference(discs), body_radius_m**2 / 100)
    paths = ShortestPaths(free)
    led: list[Tour] = []
    for tour, stays_here in zip(tours, stays, strict=True):
        if stays_here:
            led.append(tour)
            continue
        points = split_legs(tour.vertices_m, body_radius_m / 2)
        part = paths.part_of(points)
        sides = [points[part == side] for side in dict.fromkeys(part[part >= 0].tolist())]
        if not sides:
            return None
        for side in sides:
            route = without_straight_vertices(paths.paths_along(np.vstack([side, side[:1]])))
            past = replace(tour, vertices_m=route, robots=1)
            needed = math.ceil(tour_length_m(past) / past.budget_m)
            led.append(replace(past, robots=max(1, needed, tour.robots if len(sides) == 1 else 1)))
    return led

"""Routes moved sideways: lanes for robots that come towards each other, and ways round robots that stay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry.free_space import nearest_free_point
from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.tours.timetable import thinned
from rota.planners.patrol.tours.tour import Tour, split_legs, tour_length_m
from rota.polygons import polygons_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LANES = 1.1  # times two bodies: distance of two lanes, with what timing on a grid of samples takes
TOWARDS = -0.5  # cosine between directions of robots that come towards each other, at most
ON_THE_RIGHT = 0.5  # bodies: who is farther to the right of a route is passed on the other side
ROUNDS = 3  # of moving apart
BEND = 12  # samples before and after a place of a line, beside which it may bend back
SAMPLES, MOST_POINTS = 4, 20_000  # of a line to a body, and in all
QUARTER = 3  # corners of a quarter turn round a robot that stays
STRAIGHT = 0.02  # bodies: points of a route that stand out less are left out again


def in_lanes(tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths) -> list[Tour]:
    """The tours, moved apart where robots come towards each other on nearly the same line: everybody keeps right.

    Who has the other one clearly on the right already keeps left. As far as the space (where centres of bodies can be)
    allows; tours of robots that stay remain as they are, and so does a tour that a lone robot meets only itself on.
    """
    found = list(tours)
    for _ in range(ROUNDS):
        moved = moved_apart(found, body_radius_m, space, paths)
        if moved is None:
            break
        found = moved
    return found


def moved_apart(
    tours: Sequence[Tour], body_radius_m: float, space: MultiPolygon, paths: ShortestPaths
) -> list[Tour] | None:
    """The tours after one step apart; None when nobody comes towards anybody too near."""
    wide_m = 2 * body_radius_m * LANES
    between_m = max(body_radius_m / SAMPLES, sum(tour_length_m(tour) for tour in tours) / MOST_POINTS)
    lines = [split_legs(tour.vertices_m, between_m) for tour in tours]
    line = np.repeat(np.arange(len(lines)), [len(points) for points in lines])
    places = np.vstack(lines)
    ahead = np.vstack([np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0) for points in lines])
    ahead /= np.maximum(np.hypot(*ahead.T), 1e-12)[:, None]
    one, other = cKDTree(places).query_pairs(wide_m, output_type="ndarray").T
    one, other = np.concatenate([one, other]), np.concatenate([other, one])
    shared = np.array([tour.robots > 1 for tour in tours])
    meets = ((line[one] != line[other]) | shared[line[one]]) & ((ahead[one] * ahead[other]).sum(axis=1) < TOWARDS)
    one, other = one[meets], other[meets]
    gap = places[other] - places[one]
    left_m = ahead[one, 0] * gap[:, 1] - ahead[one, 1] * gap[:, 0]
    right = left_m > -ON_THE_RIGHT * body_radius_m
    step_m = np.where(right, wide_m - left_m, -(wide_m + left_m)) / 2
    # to the right as far as the nearest on the left asks; only who has nobody there keeps left
    to_right, to_left = np.zeros(len(places)), np.zeros(len(places))
    np.maximum.at(to_right, one[right], step_m[right])
    np.minimum.at(to_left, one[~right], step_m[~right])
    shift_m = np.where(to_right > 0, to_right, to_left)
    if np.abs(shift_m).max(initial=0.0) < 1e-3 * body_radius_m:
        return None
    found = list(tours)
    for k, tour in enumerate(tours):
        mine = line == k
        if (shift_m[mine] != 0).any():
            lane = beside(places[mine], ahead[mine], shift_m[mine], body_radius_m)
            found[k] = led_along(tour, lane, space, paths, STRAIGHT * body_radius_m)
    return found


def beside(points_m: Floats, ahead: Floats, shift_m: Floats, body_radius_m: float) -> Floats:
    """Points (m, 2), m <= n, so far to the right of a closed line (n, 2) that is led in directions ahead (n, 2).

    Points that come nearer to the line than that, inside of its bends, are left out.
    """
    shifted = points_m + shift_m[:, None] * np.column_stack([ahead[:, 1], -ahead[:, 0]])
    near_m = np.full(len(points_m), np.inf)
    for step in range(-BEND, BEND + 1):
        near_m = np.minimum(near_m, np.hypot(*(shifted - np.roll(points_m, step, axis=0)).T))
    kept = near_m > np.abs(shift_m) * (1 - STRAIGHT)
    return np.asarray(shifted[kept | (shift_m == 0)])


def led_along(tour: Tour, points_m: Floats, space: MultiPolygon, paths: ShortestPaths, straight_m: float) -> Tour:
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
    """The tours led by shortest ways round the robots that stay; None when nobody stays, or nothing is left of a tour.

    Who keeps within half a body of a place stays there. Where a robot that stays blocks the ground, a tour past it
    becomes one on either side, each with robots of its own.
    """
    spots = [shapely.convex_hull(shapely.MultiPoint(tour.vertices_m)) for tour in tours]
    stays = [shapely.minimum_bounding_radius(spot) <= body_radius_m / 2 for spot in spots]
    if not any(stays) or all(stays):
        return None
    round_m = 2 * body_radius_m * LANES / math.cos(math.pi / (4 * QUARTER))
    discs = shapely.union_all([spot.buffer(round_m, quad_segs=QUARTER) for spot in compress(spots, stays)])
    free = polygons_of(space.difference(discs), body_radius_m**2 / 100)
    paths = ShortestPaths(free)
    found: list[Tour] = []
    for tour, stays_here in zip(tours, stays, strict=True):
        if stays_here:
            found.append(tour)
            continue
        points = split_legs(tour.vertices_m, body_radius_m / 2)
        part = paths.part_of(points)
        sides = [points[part == side] for side in dict.fromkeys(part[part >= 0].tolist())]
        if not sides:
            return None
        for side in sides:
            route = thinned(paths.paths_along(np.vstack([side, side[:1]])))
            one = replace(tour, vertices_m=route, robots=1)
            needed = math.ceil(tour_length_m(one) / one.budget_m)
            found.append(replace(one, robots=max(1, needed, tour.robots if len(sides) == 1 else 1)))
    return found

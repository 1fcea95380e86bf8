"""Room kept for robots that stay for ever in pockets of the space: others see what they must from farther off.

Those in a pocket beside it may have no other place to see it from: with them the robot takes turns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.ground.limits_of_sight import ARC_STEPS
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import rows_in_order
from rota.planners.patrol.tolerances import HAIR_M

QUARTER_CORNERS = 4  # of a quarter turn round a robot that stays


def keeping_off(problem: Problem, spots: Sequence[BaseGeometry], components: Sequence[int]) -> Problem:
    """The problem with the space of all others cut back from robots that keep to spots (n), each in its component.

    Who stays in a pocket that is cut off by the corner of a wall cannot give way. No part of the space is lost or
    moves to another place in their order. A robot that would cut off much of a part is not kept clear of.

    Robots in two pockets beside each other, parts no larger than a body, can take turns. One whose spot is all of its
    pocket waits at the place there that is farthest from the other (``Problem.waits_m``), and the other keeps clear of
    that place alone.
    """
    apart_m = 2 * problem.robot.body_radius_m
    parts, kept_off, waits_m = list(problem.paths.parts), list(problem.kept_off), dict(problem.waits_m)
    for spot, own in zip(spots, components, strict=True):
        disc = grow(shapely.convex_hull(spot), 1.01 * apart_m, QUARTER_CORNERS)  # a hundredth more than two bodies
        near = [int(k) for k in shapely.STRtree(parts).query(disc, predicate="intersects") if k != own]
        beside = [k for k in near if parts[k].area <= math.pi * (apart_m / 2) ** 2]
        waits_at = farthest_place(spot, [parts[k] for k in beside]) if beside and spot.area > 0 else None
        if waits_at is not None:
            waits_m[own] = (waits_at.x, waits_at.y)
        for k in near:
            takes_turns = waits_at is not None and k in beside
            taken = grow(waits_at, 1.0005 * apart_m, ARC_STEPS) if takes_turns else disc
            part = cut_back(parts, k, taken)
            if part is not parts[k]:
                parts[k] = part
                kept_off.append((k, taken))
    # another robot that stays may have taken the place
    waits_m = {k: place_m for k, place_m in waits_m.items() if parts[k].distance(Point(place_m)) < HAIR_M}
    if waits_m != dict(problem.waits_m):
        problem = replace(problem, waits_m=tuple(waits_m.items()))
    if all(new is old for new, old in zip(parts, problem.paths.parts, strict=True)):
        return problem
    space = MultiPolygon(parts)
    paths, seen = ShortestPaths(space, like=problem.paths), problem.viewpoints
    kept = np.flatnonzero(paths.part_of(seen.xy_m) == seen.component)
    viewpoints = type(seen)(seen.xy_m[kept], seen.component[kept], *rows_in_order(seen.start, seen.seen, kept))
    return replace(problem, space=space, paths=paths, viewpoints=viewpoints, kept_off=tuple(kept_off))


def grow(shape: BaseGeometry, by_m: float, quarter_corners: int) -> Polygon:
    """The shape, all round it at least so much larger, with so many corners to a quarter turn."""
    return shape.buffer(by_m / math.cos(math.pi / (4 * quarter_corners)), quad_segs=quarter_corners)


def farthest_place(pocket: BaseGeometry, others: Sequence[Polygon]) -> Point:
    """The place in a pocket that is farthest from the others, a hair off its border."""
    inside = shapely.buffer(pocket, -HAIR_M)
    places = shapely.points(shapely.get_coordinates(pocket.representative_point() if inside.is_empty else inside))
    return Point(places[int(np.argmax(shapely.distance(places, shapely.union_all(others))))])


def cut_back(parts: Sequence[Polygon], k: int, disc: Polygon) -> Polygon:
    """The k-th part without the disc; itself where that would cut off much of it, or leave less than the next has."""
    left = [each for each in shapely.get_parts(shapely.difference(parts[k], disc)) if each.area > 0]
    largest = max(left, key=lambda each: float(each.area), default=None)
    # a robot that cuts off more is in everybody's way
    if largest is None or sum(each.area for each in left) - largest.area > 1e-3 * parts[k].area:
        return parts[k]
    return parts[k] if k + 1 < len(parts) and largest.area <= parts[k + 1].area else largest

"""Room kept for robots that stay for ever in pockets of the space: others see what they must from farther off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import rows_in_order

SPARE = 1.01  # of two bodies: centres are kept apart by that
QUARTER_CORNERS = 4  # of a quarter turn round a robot that stays
MOST_LOST = 1e-3  # of a part: where more is cut off, the robot that stays is in everybody's way


def keeping_off(problem: Problem, spots: Sequence[BaseGeometry], components: Sequence[int]) -> Problem:
    """The problem with the space of all others cut back from robots that keep to spots (n), each in its component.

    Who stays in a pocket that is cut off by the corner of a wall cannot give way. No part of the space is lost or
    moves to another place in their order. A robot that would cut off much of a part is not kept clear of.
    """
    radius_m = SPARE * 2 * problem.robot.body_radius_m / math.cos(math.pi / (4 * QUARTER_CORNERS))
    parts, kept_off = list(problem.paths.parts), list(problem.kept_off)
    for spot, own in zip(spots, components, strict=True):
        disc = shapely.convex_hull(spot).buffer(radius_m, quad_segs=QUARTER_CORNERS)
        for k in (int(k) for k in shapely.STRtree(parts).query(disc, predicate="intersects")):
            part = parts[k] if k == own else cut_back(parts, k, disc)
            if part is not parts[k]:
                parts[k] = part
                kept_off.append((k, disc))
    if all(new is old for new, old in zip(parts, problem.paths.parts, strict=True)):
        return problem
    space = MultiPolygon(parts)
    paths, seen = ShortestPaths(space, like=problem.paths), problem.viewpoints
    kept = np.flatnonzero(paths.part_of(seen.xy_m) == seen.component)
    viewpoints = type(seen)(seen.xy_m[kept], seen.component[kept], *rows_in_order(seen.start, seen.seen, kept))
    return replace(problem, space=space, paths=paths, viewpoints=viewpoints, kept_off=tuple(kept_off))


def cut_back(parts: Sequence[Polygon], k: int, disc: Polygon) -> Polygon:
    """The k-th part without the disc; itself where that would cut off much of it, or leave less than the next has."""
    left = [each for each in shapely.get_parts(shapely.difference(parts[k], disc)) if each.geom_type == "Polygon"]
    largest = max(left, key=lambda each: float(each.area), default=None)
    if largest is None or sum(each.area for each in left) - largest.area > MOST_LOST * parts[k].area:
        return parts[k]
    return parts[k] if k + 1 < len(parts) and largest.area <= parts[k + 1].area else largest

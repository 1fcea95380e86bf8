"""Round corners drawn finer where coarse ones keep robots from the only places that see something."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from rota.geometry.free_space import standing_anywhere, standing_space_in
from rota.geometry.shortest_path import ShortestPaths
from rota.geometry.tiles import Box, clip
from rota.model.arrays import Floats
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.surroundings import MANY_WALLS
from rota.planners.patrol.tolerances import HAIR_M

# of a whole turn: 3e-4 and, where that does not do, 1e-6 of the body's radius too far from a corner at most


def with_room_to_see(problem: Problem, points_m: Floats) -> Problem:
    """The problem with its space drawn finer where only that lets a robot see some of the points (n, 2).

    Ground with very many corners has coarse arcs round them, so that its paths stay few. A place that is seen through
    a slit between two corners may be seen from just behind such an arc only. The same problem where no point gains.
    """
    space, body_m = problem.space, problem.robot.body_radius_m
    _, ranges_m = nearest_places(points_m, space, problem.walls, problem.robot)
    hidden_m = points_m[ranges_m > problem.reach_m]
    # points in one cell are seen past one corner: one of them is looked at
    hidden_m = hidden_m[np.unique(np.floor(hidden_m / (0.004 * problem.reach_m)), axis=0, return_index=True)[1]]
    tree = shapely.STRtree(problem.paths.parts)
    near_m, patches = problem.robot.sensor.reach_m + 2 * body_m, []
    # points of one square share the finer space, which takes long to draw
    for group_m in _groups(hidden_m, 0.5 * problem.reach_m):
        box = (*(group_m.min(axis=0) - near_m), *(group_m.max(axis=0) + near_m))
        for arc_corners in (128, 2048):
            fine = finer_space_in(problem, box, arc_corners)
            fine = MultiPolygon([part for part in fine.geoms if tree.query(part, predicate="intersects").size])
            places_m, ranges_m = nearest_places(group_m, fine, problem.walls, problem.robot)
            for place_m in places_m[ranges_m <= problem.reach_m]:
                patch = fine.intersection(shapely.Point(place_m).buffer(body_m))
                patches += [part for part in shapely.get_parts(patch) if part.geom_type == "Polygon"]
            group_m = group_m[ranges_m > problem.reach_m]
            if not len(group_m):
                break
    if not patches:
        return problem
    parts = with_patches(problem.paths.parts, patches, problem.kept_off)
    if all(new is old for new, old in zip(parts, problem.paths.parts, strict=True)):
        return problem
    wider = MultiPolygon(parts)
    paths = ShortestPaths(wider, like=problem.paths)
    if not np.array_equal(paths.part_of(problem.viewpoints.xy_m), problem.viewpoints.component):
        return problem  # parts have been joined or stand in another order: tours know theirs by number
    return replace(problem, space=wider, paths=paths)


def finer_space_in(problem: Problem, box: Box, arc_corners: int) -> MultiPolygon:
    """The part in a box of the space with arcs of so many corners, which is drawn once for all where that is soon."""
    mission, body_m = problem.mission, problem.robot.body_radius_m
    if len(problem.paths.corners_m) > MANY_WALLS:
        return standing_space_in(mission, body_m, box, arc_corners=arc_corners)
    return clip(standing_anywhere(mission, body_m, arc_corners=arc_corners), box)


def _groups(points_m: Floats, side_m: float) -> list[Floats]:
    """The points (n, 2) in groups: those of each square of this side, if there are any."""
    if not len(points_m):
        return []
    _, group = np.unique(np.floor(points_m / side_m), axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    return np.split(points_m[order], np.cumsum(np.bincount(group))[:-1])


def with_patches(
    parts: Sequence[Polygon], patches: Sequence[Polygon], kept_off: Sequence[tuple[int, Polygon]] = ()
) -> list[Polygon]:
    """The parts of the space, largest first, with the patches that lie at one of them; they stay apart and in order.

    Of a patch at several parts the largest gets what leaves a seam to the others. A patch that would make a part larger
    than the one before it is left out. kept_off: parts by number, and ground that patches give none of back to them.
    """
    tree, wider = shapely.STRtree(parts), list(parts)
    for patch in patches:
        at = sorted(int(k) for k in tree.query(patch, predicate="intersects"))
        if not at:
            continue
        k, others = at[0], [wider[i].buffer(HAIR_M) for i in at[1:]]
        others += [ground for part, ground in kept_off if part == k]
        grown = shapely.union(wider[k], shapely.difference(patch, shapely.union_all(others)))
        grown = max(shapely.get_parts(grown), key=lambda part: float(part.area))
        if grown.geom_type == "Polygon" and (k == 0 or grown.area < wider[k - 1].area):
            wider[k] = grown
    return wider

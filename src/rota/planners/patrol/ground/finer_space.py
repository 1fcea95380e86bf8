"""Round corners drawn finer where coarse ones keep robots from the only places that see something."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.geometry.free_space import standing_space_in
from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import Problem
from rota.polygons import polygons_of

Floats = NDArray[np.float64]

FINE_ARC_CORNERS = 128  # of a whole turn: 3e-4 of the body's radius too far from a corner at most
PATCH_RADIUS = 1.0  # of the body's radius: how far round a place the space is drawn anew


def with_room_to_see(problem: Problem, points_m: Floats) -> Problem:
    """The problem with its space drawn finer where only that lets a robot see some of the points (n, 2).

    Ground with very many corners has coarse arcs round them, so that its paths stay few. A place that is seen through
    a slit between two corners may be seen from just behind such an arc only. The same problem where no point gains.
    """
    space, body_m = problem.space, problem.robot.body_radius_m
    _, ranges_m = nearest_places(points_m, space, problem.walls, problem.robot)
    patches = []
    for point_m in points_m[ranges_m > problem.reach_m]:
        near_m = problem.robot.sensor.reach_m + 2 * body_m
        box = (*(point_m - near_m), *(point_m + near_m))
        fine = standing_space_in(problem.mission, body_m, box, arc_corners=FINE_ARC_CORNERS)
        place_m, range_m = nearest_places(point_m[None], fine, problem.walls, problem.robot)
        if range_m[0] > problem.reach_m:
            continue
        patch = fine.intersection(shapely.Point(place_m[0]).buffer(PATCH_RADIUS * body_m))
        patches += [part for part in shapely.get_parts(patch) if shapely.intersection(part, space).area > 0]
    if not patches:
        return problem
    wider = polygons_of(shapely.union_all([space, *patches]))
    paths = ShortestPaths(wider)
    if not np.array_equal(paths.part_of(problem.viewpoints.xy_m), problem.viewpoints.component):
        return problem  # parts have been joined or stand in another order: tours know theirs by number
    return replace(problem, space=wider, paths=paths)

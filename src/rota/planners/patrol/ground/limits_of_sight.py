"""The rim of what can be seen at all: the last ground in reach, seen only from the border of where robots can stand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion, border_segments
from rota.geometry.line_of_sight import segments_free
from rota.geometry.shortest_path import ShortestPaths
from rota.mission import Robot
from rota.planners.patrol.ground.samples import SamplePoints, joined, points_of
from rota.planners.patrol.ground.viewpoints import sensor_arguments
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]

ARC_STEPS = 64  # per quarter of a circle
NEAR_RIM_M = 0.001  # how far inside of the rim its samples lie: legs that see them run along the very border
HAIR_M = 1e-6
FINE_ARC_M = 0.0005  # how much farther from an obstacle's corner than its body a robot may be kept where rims matter


def area_in_range(space: MultiPolygon, robot: Robot, short_m: float) -> BaseGeometry:
    """All that is in range of a place in the space, of a sensor that reaches ``short_m`` less; sight is not asked.

    Arcs become chords, so that the area is never too large.
    """
    reach_m, square = sensor_arguments(robot, short_m)
    if not square:
        return space.buffer(reach_m, quad_segs=ARC_STEPS)
    sides = border_segments(space).reshape(-1, 2, 1, 2)
    corners = reach_m * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    swept = shapely.convex_hull(shapely.multipoints((sides + corners).reshape(-1, 8, 2)))
    return shapely.union_all([space, *swept])


def fine_arc_corners(body_radius_m: float) -> int:
    """Corners of a whole turn round a grown corner that keep a robot at most ``FINE_ARC_M`` too far from it."""
    return max(16, math.ceil(math.pi / math.acos(1 / (1 + FINE_ARC_M / max(body_radius_m, FINE_ARC_M)))))


def has_rim(regions: Sequence[DemandedRegion], space: MultiPolygon, robot: Robot, margin_m: float) -> bool:
    """Whether some ground that must be seen is out of reach of a sensor that reaches ``margin_m`` less."""
    asked = [region.shape for region in regions if region.demand == "every_point"]
    beyond = shapely.difference(shapely.union_all(asked), space)
    if beyond.is_empty:
        return False
    return not bool(shapely.covers(area_in_range(space, robot, margin_m), beyond))


def rim_points(
    regions: Sequence[DemandedRegion],
    region_class: Sequence[int],
    space: MultiPolygon,
    robot: Robot,
    *,
    margin_m: float,
    spacing_m: float,
) -> SamplePoints:
    """Samples along the rim of what is in range, at most ``spacing_m`` apart, just inside of it; none where none is.

    Also half a margin inside: ground hardly wider than twice the reach has no rim and yet is seen from its border only.
    Their shrink is still to be fitted to where they are seen from.
    """
    depths = (min(NEAR_RIM_M, margin_m / 8), margin_m / 2)
    found = [points_of(np.zeros((0, 2)), 0.0, 0, 0)]
    for depth_m in depths:
        border = area_in_range(space, robot, depth_m).boundary
        for i, region in enumerate(regions):
            if region.demand == "every_point":
                lines = shapely.segmentize(border.intersection(region.shape), spacing_m)
                xy = np.unique(shapely.get_coordinates(lines), axis=0)
                found.append(points_of(xy, spacing_m**2 / 4, region_class[i], i))
    return joined(found)


def with_reach_for(points: SamplePoints, ranges_m: Floats, reach_m: float, margin_m: float) -> SamplePoints:
    """The points, each seen from as far as its range (n,) and half of what the full reach leaves beyond that.

    Points nearer than that keep their shrink; a shrink may become negative, at most by the margin.
    """
    most_m = np.maximum((reach_m - ranges_m) / 2, 0.0) - margin_m
    return replace(points, shrink_m=np.minimum(points.shrink_m, most_m))


def along_the_rim(
    tours: Sequence[Tour],
    rim_places_m: Floats,
    space: MultiPolygon,
    paths: ShortestPaths,
    *,
    near_m: float,
    wide_m: float,
) -> list[Tour]:
    """The tours, drawn to the border of the space where the rim is seen from: from a hair off it, a strip stays unseen.

    rim_places_m: (n, 2) on the border. Vertices within ``wide_m`` of one and within ``near_m`` of the border move onto
    it; legs that this leads through an obstacle go round its corner.
    """
    if not len(rim_places_m):
        return list(tours)
    tree = cKDTree(rim_places_m)
    border = space.boundary
    shapely.prepare(border)
    found = []
    for tour in tours:
        close = np.flatnonzero(tree.query(tour.vertices_m)[0] <= wide_m)
        close = close[shapely.dwithin(border, shapely.points(tour.vertices_m[close]), near_m)]
        if not len(close):
            found.append(tour)
            continue
        vertices = tour.vertices_m.copy()
        lines = shapely.shortest_line(border, shapely.points(vertices[close]))
        vertices[close] = shapely.get_coordinates(lines)[::2]
        ends = np.roll(vertices, -1, axis=0)
        if paths.part_of(vertices[close]).min() < 0:
            found.append(tour)
            continue
        if not segments_free(vertices, ends, paths.grid).all():
            vertices = paths.paths_along(np.vstack([vertices, vertices[:1]]))[:-1]
        found.append(replace(tour, vertices_m=vertices))
    return found

"""The rim of what can be seen at all: the last ground in reach, seen only from the border of where robots can stand."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion, border_segments
from rota.geometry.line_of_sight import segments_free
from rota.geometry.shortest_path import ShortestPaths
from rota.geometry.tiles import clipped, few_cornered_boxes, grown_box
from rota.mission import Robot
from rota.planners.patrol.ground.samples import SamplePoints, joined, points_of
from rota.planners.patrol.ground.viewpoints import sensor_arguments
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]

ARC_STEPS = 64  # per quarter of a circle
NEAR_RIM_M = 0.001  # how far inside of the rim its samples lie: legs that see them run along the very border
HAIR_M = 1e-6
FINE_ARC_M = 0.0005  # how much farther from an obstacle's corner than its body a robot may be kept where rims matter


def grown(space: MultiPolygon, robot: Robot, short_m: float, *, outwards: bool = False) -> BaseGeometry:
    """All that is in range of a place in the space, of a sensor that reaches ``short_m`` less; sight is not asked.

    Arcs become chords: what is told is never too much, or with ``outwards`` never too little.
    """
    reach_m, square = sensor_arguments(robot, short_m)
    if not square:
        wider = 1 / math.cos(math.pi / (4 * ARC_STEPS)) if outwards else 1.0
        return space.buffer(reach_m * wider, quad_segs=ARC_STEPS)
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
    return not bool(shapely.covers(grown(space, robot, margin_m), beyond))


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
        border = grown(space, robot, depth_m).boundary
        for i, region in enumerate(regions):
            if region.demand == "every_point":
                lines = shapely.segmentize(border.intersection(region.shape), spacing_m)
                xy = np.unique(shapely.get_coordinates(lines), axis=0)
                found.append(points_of(xy, spacing_m**2 / 4, region_class[i], i))
    return joined(found)


class _Near(NamedTuple):
    """What is asked in a box (None: zones to visit), and the space and the walls that matter to it."""

    asked: list[MultiPolygon | None]
    space: MultiPolygon
    lines: NDArray[np.object_]


def surely_seeable_m2(
    regions: Sequence[DemandedRegion], space: MultiPolygon, walls: Floats, robot: Robot
) -> list[float]:
    """For each region an area that is surely seen from somewhere, never too much; 0 for zones that ask for visits.

    walls: (k, 4), the borders of what blocks sight. Surely seen is where a body covers the ground, for nothing that
    blocks motion comes between (unless walls run through where robots can stand), and what is in range with no wall
    within reach. Ground seen only past walls is left out: a bound on robots must stay one.

    Whether a place is among it depends on nothing that is farther than the reach. Where corners are very many, boxes
    are looked at by themselves, each with all that lies so near to it, and the areas in the boxes are added up.
    """
    reach_m, _ = sensor_arguments(robot, 0.0)
    parts = list(_near_boxes(regions, space, walls, 1.1 * robot.sensor.reach_m))
    walls_inside = any(_walls_run_through(part) for part in parts)
    body_m = 0.0 if walls_inside else min(robot.body_radius_m, reach_m)
    each = [_surely_seen_m2(part, robot, body_m) for part in parts]
    return [math.fsum(areas) for areas in zip(*each, strict=True)]


def _near_boxes(
    regions: Sequence[DemandedRegion], space: MultiPolygon, walls: Floats, near_m: float
) -> Iterator[_Near]:
    """All ground in boxes with few corners near each: one, of all there is, for ordinary ground."""
    asked = [region.shape if region.demand == "every_point" else None for region in regions]
    shapes = [space, *(shape for shape in asked if shape is not None)]
    corners = np.vstack([*map(shapely.get_coordinates, shapes), walls.reshape(-1, 2)])
    x0, y0, x1, y1 = shapely.union_all([shapely.box(*shape.bounds) for shape in shapes]).bounds
    lines = shapely.linestrings(walls.reshape(-1, 2, 2))
    boxes = few_cornered_boxes((x0, y0, x1, y1), corners, near_m)
    if len(boxes) == 1:
        yield _Near(asked, space, lines)
        return
    tree = shapely.STRtree(lines)
    for box in boxes:
        here = [None if shape is None else clipped(shape, box) for shape in asked]
        if any(shape is not None and not shape.is_empty for shape in here):
            wide = grown_box(box, near_m)
            yield _Near(here, clipped(space, wide), lines[np.sort(tree.query(shapely.box(*wide)))])


def _walls_run_through(part: _Near) -> bool:
    """Whether walls run through where robots can stand, by more than a hair."""
    inner = part.space.buffer(-HAIR_M)
    shapely.prepare(inner)
    return bool(shapely.intersects(inner, part.lines).any())


def _surely_seen_m2(part: _Near, robot: Robot, body_m: float) -> list[float]:
    """The areas of what is asked in one box that is surely seen, as ``surely_seeable_m2`` gives them."""
    space, lines = part.space, part.lines
    wide_m = robot.sensor.reach_m / math.cos(math.pi / (4 * ARC_STEPS))
    bodies = space.buffer(body_m, quad_segs=ARC_STEPS) if body_m > 0 else space
    beyond = shapely.difference(shapely.union_all([shape for shape in part.asked if shape is not None]), bodies)
    seen = bodies
    if not _all_near(beyond, lines, robot.sensor.reach_m):
        hidden = shapely.buffer(shapely.union_all(lines), wide_m, quad_segs=ARC_STEPS)
        seen = shapely.union_all([bodies, grown(space, robot, 0.0).difference(hidden)])
    return [0.0 if shape is None else float(shapely.intersection(shape, seen).area) for shape in part.asked]


def _all_near(shape: BaseGeometry, lines: NDArray[np.object_], near_m: float) -> bool:
    """Whether every part of the shape is so small, and so near one of the lines, that all of it surely is near."""
    pieces = shapely.get_parts(shapely.get_parts(np.atleast_1d(shape)))
    if not len(pieces) or not len(lines):
        return not len(pieces)
    x0, y0, x1, y1 = shapely.bounds(pieces).T
    middles = shapely.points((x0 + x1) / 2, (y0 + y1) / 2)
    _, away_m = shapely.STRtree(lines).query_nearest(middles, return_distance=True, all_matches=False)
    return bool((away_m + np.hypot(x1 - x0, y1 - y0) / 2 <= near_m).all())


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

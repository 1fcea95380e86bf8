"""The closed route round a segment of the frame (Sun et al. 2019, Section 4.4, Figures 9a and 10).

The border of the segment widened by r_s: a robot on it sees the segment's ground up to 2 r_s away on either side. The
paper re-adjusts it where an obstacle blocks it, without saying how; here the widened segment is cut to the space where
robots can be, so that the route follows obstacles and the area's border. Lanes of the frame nearer than 2 r_s to each
other have one border together, and what lies between them stays unseen; that is left to the repair.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rota.errors import PlanError
from rota.geometry.free_space import nearest_free_point
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.planners.patrol.tolerances import HAIR_M, SAME_PLACE_M


def route_round(line_m: Floats, paths: ShortestPaths, *, radius_m: float) -> Floats:
    """The closed route (n, 2), n >= 1, round a segment's polyline (k, 2) at distance radius_m; the last leg leads back.

    The line lies in the space of ``paths``, which the route does not leave. In the open its length is 2 x segment +
    2 pi r_s, bends apart, less what the corners of its arcs cut off (0.2 %). Ground that the widened segment encloses
    is gone round as well where it is a quarter of a disc of radius_m or more, by the shortest way there and back.
    Where the space has no width, the route is the segment, there and back. Raises PlanError for a line outside.
    """
    part = int(paths.part_of(line_m[:1])[0])
    if part < 0:
        raise PlanError(f"the segment at {line_m[0].tolist()} lies outside the space where robots can be")
    space = MultiPolygon([paths.parts[part]])
    line = as_line(line_m)
    rings = borders_of(widen(line, radius_m, space), line, space, radius_m=radius_m)
    if not rings:
        return paths.paths_along(np.vstack([line_m, line_m[-2:0:-1]]))
    route = inside(rings[0], space, paths)
    for ring in rings[1:]:
        route = joined_rings(route, inside(ring, space, paths), paths)
    return route


def as_line(line_m: Floats) -> LineString | Point:
    """A polyline (k, 2), or the point where all of it lies."""
    return Point(line_m[0]) if (line_m == line_m[0]).all() else LineString(line_m)


def widen(lines: Any, radius_m: float, space: BaseGeometry) -> Any:
    """A line or an array of them, widened and cut to the space; eight corners to a quarter stay within 0.5 % of r_s."""
    return shapely.intersection(shapely.buffer(lines, radius_m, quad_segs=8), space)


def borders_of(
    widened: BaseGeometry, line: LineString | Point, space: BaseGeometry, *, radius_m: float
) -> list[Floats]:
    """The rings (n, 2) that the route round a widened segment follows, first the outer ring of its largest part."""
    hole_m2 = 0.25 * np.pi * radius_m**2  # less is left to the repair
    parts = [part for part in shapely.get_parts(widened) if isinstance(part, Polygon)]
    if len(parts) > 1:
        parts = [part for part in parts if part.distance(line) < HAIR_M]
        parts = sorted(parts, key=lambda part: -float(part.area))
    return [ring for part in parts for ring in rings_of(part, space, hole_m2=hole_m2)]


def rings_of(part: Polygon, space: BaseGeometry, *, hole_m2: float) -> list[Floats]:
    """The outer ring (n, 2) of a widened segment, and the inner ones round more than hole_m2 of the space."""
    holes = [ring for ring in part.interiors if shapely.intersection(Polygon(ring), space).area > hole_m2]
    simple = [shapely.simplify(ring, SAME_PLACE_M) for ring in (part.exterior, *holes)]
    return [shapely.get_coordinates(ring)[:-1] for ring in simple]


def inside(ring_m: Floats, space: MultiPolygon, paths: ShortestPaths) -> Floats:
    """The closed ring (n, 2) with corners that rounding put outside moved back and blocked legs led round."""
    outside = np.flatnonzero(paths.part_of(ring_m) < 0)
    ring_m = ring_m.copy()
    for k in outside:
        ring_m[k] = nearest_free_point(space, (float(ring_m[k, 0]), float(ring_m[k, 1])))
    ring_m = ring_m[paths.part_of(ring_m) == paths.part_of(ring_m)[0]]
    closed = paths.paths_along(np.vstack([ring_m, ring_m[:1]]))
    return closed[:-1] if len(closed) > 1 else closed


def joined_rings(one_m: Floats, other_m: Floats, paths: ShortestPaths) -> Floats:
    """One closed route along two (n, 2) and (m, 2), going over and back by the shortest way between their corners."""
    apart = paths.distances(one_m, other_m)
    i, j = (int(k) for k in np.unravel_index(int(np.argmin(apart)), apart.shape))
    way = np.vstack([one_m[: i + 1], np.roll(other_m, -j, axis=0), other_m[j], one_m[i:], one_m[:1]])
    return paths.paths_along(way)[:-1]

"""Mission and trajectory -> the fence for the robot: the area that it is in, less holes and obstacles."""

from __future__ import annotations

import numpy as np
from shapely import LineString, MultiPolygon, Point, Polygon

from rota.model.mission import Mission
from rota.model.plan import Trajectory
from rota.routes.route import Disc, Fence, Ring

CIRCLE_CORNERS, REGULAR = 64, 1e-6  # of the polygon that stands for a circle, and the share that it may be uneven by
FENCE_MARGIN_M = 3.0  # a satellite fix is no better; a fence any closer to the route would end the patrol by itself


def fence_of(mission: Mission, trajectory: Trajectory) -> Fence | None:
    """The polygon of the area that the robot is in, less holes and obstacles; None: the route runs close to them.

    What was drawn as a circle is a circle in the fence, which vehicles keep as one item.
    Only one polygon includes, since autopilots differ on whether several mean all of them or any.
    """
    points_m = trajectory.positions_m[:, :2]
    route = LineString(points_m) if len(points_m) > 1 else Point(points_m[0])
    home = min(mission.area.geoms, key=lambda polygon: polygon.distance(route))
    outer = Polygon(home.exterior)
    blocked = [Polygon(hole) for hole in home.interiors]
    blocked += [Polygon(p.exterior) for o in mission.obstacles if o.blocks_motion for p in o.shape.geoms]
    blocked = [polygon for polygon in blocked if polygon.intersects(outer)]
    inside = outer.contains(route) and route.distance(outer.exterior) >= FENCE_MARGIN_M
    if not inside or route.distance(MultiPolygon(blocked)) < FENCE_MARGIN_M:
        return None
    discs = [(polygon, _disc(polygon)) for polygon in blocked]
    return Fence(
        inside_m=_ring(outer),
        outside_m=tuple(_ring(polygon) for polygon, disc in discs if disc is None),
        circles_m=tuple(disc for _, disc in discs if disc is not None),
    )


def _disc(polygon: Polygon) -> Disc | None:
    """The circle through the corners of a regular polygon of many, which stands for a circle; None of others."""
    corners_m = np.array(polygon.exterior.coords[:-1])[:, :2]
    if len(corners_m) < CIRCLE_CORNERS:
        return None
    centre_m = corners_m.mean(axis=0)
    radii_m = np.hypot(*(corners_m - centre_m).T)
    sides_m = np.hypot(*(corners_m - np.roll(corners_m, 1, axis=0)).T)
    regular = max(np.ptp(radii_m) / radii_m.max(), np.ptp(sides_m) / sides_m.max()) <= REGULAR
    return (float(centre_m[0]), float(centre_m[1]), float(radii_m.max())) if regular else None


def _ring(polygon: Polygon) -> Ring:
    return tuple((x, y) for x, y, *_ in polygon.exterior.coords[:-1])

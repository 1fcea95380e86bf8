"""Mission and trajectory -> the fence for the robot: the area that it is in, less holes and obstacles."""

from __future__ import annotations

from shapely import LineString, MultiPolygon, Point, Polygon

from rota.mission import Mission
from rota.plan import Trajectory
from rota.route import Fence, Ring

FENCE_MARGIN_M = 3.0  # a satellite fix is no better; a fence any closer to the route would end the patrol by itself


def fence_of(mission: Mission, trajectory: Trajectory) -> Fence | None:
    """The polygon of the area that the robot is in, less holes and obstacles; None: the route runs close to them.

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
    return Fence(inside_m=_ring(outer), outside_m=tuple(_ring(polygon) for polygon in blocked))


def _ring(polygon: Polygon) -> Ring:
    return tuple((x, y) for x, y, *_ in polygon.exterior.coords[:-1])

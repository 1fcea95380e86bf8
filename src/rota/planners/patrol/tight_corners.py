"""Ground in corners too tight for robots that turn along arcs: no loop leads near enough to see it."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.errors import NoPlanFound
from rota.geometry.free_space import demanded_regions
from rota.model.mission import Mission
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.limits_of_sight import ARC_STEPS


def require_corners_in_reach(mission: Mission) -> None:
    """NoPlanFound, with the place and what helps, where loops of arcs leave ground in corners out of reach.

    Also where there are no loops, and one robot that stays does not see all.

    A path of no tighter arcs that stays in convex ground stays in the union of the discs of that radius within it: to
    cut into a corner beyond the disc that touches both its sides it would have to turn more tightly. Nobody is nearer
    than that to ground in corners of the area's convex hull. Robots that have hardly any time to move stand, and may
    stand there.
    """
    fleet = mission.fleet
    robots = fleet.unlike_robots
    radius_m = min(robot.turn_radius_m for robot in robots)
    reach_m = max(robot.sensor.reach_m for robot in robots)
    regions = [region for region in demanded_regions(mission) if region.demand == "every_point"]
    slowest_m_s = min(robot.ground_speed_m_s for robot in robots)
    shortest_m = min((region.period_s for region in regions), default=0.0) * slowest_m_s
    if radius_m == 0 or shortest_m <= reach_m:
        return
    spare_m = 0.01 * radius_m  # corners of arcs driven as straight legs lie up to 0.5 % of the radius outside
    hull, body_m = mission.area.convex_hull, min(robot.body_radius_m for robot in robots)
    middles = shapely.buffer(hull, -(radius_m + body_m))
    asked = shapely.union_all([region.shape for region in regions])
    if middles.is_empty:
        # around a loop of such arcs there is room for a disc: its convex hull is bounded by arcs no tighter
        has_room = not shapely.buffer(hull, -(radius_m - spare_m + body_m)).is_empty
        if shapely.minimum_bounding_radius(asked) > reach_m and not has_room:
            raise NoPlanFound(_no_room_sentence(hull, radius_m=radius_m, body_m=body_m))
        return  # who stays may see all
    driven_m = (radius_m + spare_m) / math.cos(math.pi / 4 / ARC_STEPS)
    near = shapely.buffer(middles, driven_m + reach_m, quad_segs=ARC_STEPS)
    # of the sensor's disc: less is rounding
    left = polygons_of(shapely.difference(asked, near), 1e-5 * math.pi * reach_m**2)
    if not left.is_empty:
        raise NoPlanFound(_sentence(left, asked, middles, radius_m=radius_m, reach_m=reach_m))


def _no_room_sentence(hull: BaseGeometry, *, radius_m: float, body_m: float) -> str:
    """That no loop fits in, and what helps."""
    widest_m, needed_m = shapely.maximum_inscribed_circle(hull).length, radius_m + body_m
    body = f" and a body_radius_m of {body_m:g}" if body_m > 0 else ""
    return (
        f"no circle that robots can drive fits into the area: with a turn_radius_m of {radius_m:g}{body} it takes a"
        f" radius of {needed_m:g} m, and {widest_m:.1f} m is the most that fits; so no robot can come back to where it"
        " was: give a smaller radius or a wider area"
    )


def _sentence(
    left: MultiPolygon, asked: BaseGeometry, middles: BaseGeometry, *, radius_m: float, reach_m: float
) -> str:
    """How much is out of reach, where, by how much, and what helps."""
    corners_m = shapely.get_coordinates(left)
    away_m = shapely.distance(middles, shapely.points(corners_m)) - radius_m
    farthest = int(np.argmax(away_m))
    (x, y), share = corners_m[farthest], left.area / asked.area
    return (
        f"about {left.area:.2f} m2 ({share:.2%} of what is asked) lies in corners that no loop comes near, for instance"
        f" at ({x:.2f}, {y:.2f}): with a turn_radius_m of {radius_m:g} robots come no nearer than"
        f" {away_m[farthest]:.1f} m, and sensors reach {reach_m:g} m; cut the corners off the area, or give a smaller"
        " radius or a longer reach"
    )

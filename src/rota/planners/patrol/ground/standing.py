"""The space where robots can stand, with corners as finely rounded as what they must see there needs it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely
from shapely import MultiPolygon

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion, standing_space, standing_space_in
from rota.geometry.tiles import grown_box
from rota.mission import Mission, Robot
from rota.planners.patrol.ground.limits_of_sight import limit_is_asked_for
from rota.planners.patrol.ground.samples import MANY_CORNERS
from rota.polygons import polygons_of

ARC_CORNERS = 16  # corners of a whole turn round a grown corner
COARSE_ARC_CORNERS = 8  # the same in a mission with more than MANY_CORNERS corners
POCKET_ARC_CORNERS = 128  # the same there, beside parts of the space that are no larger than a body
GRAZE_M = 9e-7  # by so much bodies may touch the walls of a scanned floor; a plan may have them touch by 1e-6 m
FINE_ARC_M = 0.0005  # at the limit of sight a corner may keep a robot at most this much farther off than its body does


def space_for(
    mission: Mission, regions: Sequence[DemandedRegion], robot: Robot, range_margin_m: float
) -> tuple[MultiPolygon, bool]:
    """Where the robot's centre may be, and whether the regions reach to the limit of what it sees from there.

    The walls of a scanned floor follow its pixels, as the border of where robots can stand then does. Much is seen only
    from the very line of another wall, that is only if bodies may touch walls a little.

    Corners are rounded finely where they do, or where a zone to visit can be entered only so. Raises NoPlanFound where
    the robot can stand nowhere at all, or nowhere in a zone to visit.
    """
    body_m = robot.body_radius_m
    corners = shapely.get_num_coordinates([mission.area, *(obstacle.shape for obstacle in mission.obstacles)]).sum()
    if corners <= MANY_CORNERS:
        space = standing_space(mission, body_m, arc_corners=ARC_CORNERS)
    else:
        space = standing_space(mission, max(0.0, body_m - GRAZE_M), arc_corners=COARSE_ARC_CORNERS)
        space = with_pockets_opened(mission, space, max(0.0, body_m - GRAZE_M))
    visits = [region for region in regions if region.demand == "visit"]
    at_limit = limit_is_asked_for(regions, space, robot, range_margin_m)
    if at_limit or any(shapely.disjoint(region.shape, space) for region in visits):
        space = standing_space(mission, body_m, arc_corners=fine_arc_corners(body_m))
    if space.is_empty:
        raise NoPlanFound(f"there is no place where a body of radius {body_m} m can stand")
    for region in visits:
        if shapely.disjoint(region.shape, space):
            spot = region.shape.representative_point()
            fits = "blocked to motion" if body_m == 0 else f"no place for a body of radius {body_m} m"
            raise NoPlanFound(
                f"no robot can be inside zone {region.name}, at ({spot.x:.2f}, {spot.y:.2f}): it is {fits}"
            )
    return space, at_limit


def with_pockets_opened(mission: Mission, space: MultiPolygon, body_radius_m: float) -> MultiPolygon:
    """The space, with round corners drawn finely about its pockets: parts no larger than a body.

    Coarse arcs cut off places in which a robot would stay for ever, and in the way of all others.
    """
    pockets = [part for part in space.geoms if part.area <= math.pi * body_radius_m**2]
    finer = [
        standing_space_in(
            mission, body_radius_m, grown_box(part.bounds, 2 * body_radius_m), arc_corners=POCKET_ARC_CORNERS
        )
        for part in pockets
    ]
    return polygons_of(shapely.union_all([space, *finer])) if finer else space


def fine_arc_corners(body_radius_m: float) -> int:
    """Corners of a whole turn round a grown corner that keep a robot at most ``FINE_ARC_M`` too far from it."""
    return max(ARC_CORNERS, math.ceil(math.pi / math.acos(1 / (1 + FINE_ARC_M / max(body_radius_m, FINE_ARC_M)))))

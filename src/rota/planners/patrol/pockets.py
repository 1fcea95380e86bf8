"""Robots that a plan leaves in parts of the ground to which nothing can bring them."""

from __future__ import annotations

import numpy as np
import shapely

from rota.geometry.free_space import standing_space
from rota.model.arrays import Floats
from rota.model.mission import inner_reach_m
from rota.model.plan import Plan
from rota.planners.patrol.ground.fewer_corners import with_fewer_corners
from rota.planners.patrol.ground.standing import ARC_CORNERS, POCKET_ARC_CORNERS


def pockets_sentence(plan: Plan) -> str | None:
    """How many robots live apart from the ground where most live, and what keeps them out of there; None for none.

    Where the fleet has entrances, all of its robots can be driven to where they are.
    """
    fleet = plan.mission.fleet
    if fleet.entrances is not None or len(plan.trajectories) < 2:
        return None
    body_m = max(robot.body_radius_m for robot in fleet.unlike_robots)
    places_m = np.array([trajectory.positions_m[-1, :2] for trajectory in plan])
    if are_surely_together(places_m, plan, body_m):
        return None
    parts = shapely.get_parts(standing_space(plan.mission, body_m, arc_corners=POCKET_ARC_CORNERS))
    if len(parts) < 2:
        return None
    part = shapely.STRtree(parts).query_nearest(shapely.points(places_m), all_matches=False)[1]
    robots = np.bincount(part, minlength=len(parts))
    apart = np.flatnonzero(part != int(np.lexsort((shapely.area(parts), robots))[-1]))
    if not len(apart):
        return None
    x, y = places_m[apart[0]]
    others = "1 robot is" if len(apart) == 1 else f"{len(apart)} of {len(part)} robots are"
    return (
        f"{others} where no way leads to from the rest, for instance at ({x:.2f}, {y:.2f}):"
        " fleet.entrances keeps robots where they can come to."
    )


def are_surely_together(places_m: Floats, plan: Plan, body_m: float) -> bool:
    """Whether ways between the places (n, 2) are there even in a space with few corners, as a search may have drawn it.

    False may be so.
    """
    roomy = with_fewer_corners(plan.mission, inner_reach_m(plan.mission.fleet.sensor), body_m)
    parts = shapely.get_parts(standing_space(roomy, body_m, arc_corners=ARC_CORNERS))
    return bool(shapely.covers(parts, shapely.multipoints(places_m)).any())

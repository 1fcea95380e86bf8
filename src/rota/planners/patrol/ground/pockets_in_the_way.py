"""Pockets that are needed and in the way: a proof that no plan sees all of the ground, before any is looked for.

A pocket is a part of the standing space so small that whoever stands in it touches all who come near. Where something
is seen from the pocket alone there is always a robot in it, since no way leads out. What others see only from where
they touch that robot, wherever in its pocket it is, is then never seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.errors import NoPlanFound
from rota.geometry.free_space import nooks, standing_space_in
from rota.geometry.tiles import Box, clip, grown_box
from rota.model.arrays import Floats
from rota.model.mission import TOUCH_M
from rota.planners.patrol.ground.limits_of_sight import ARC_STEPS
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.standing import POCKET_ARC_CORNERS
from rota.planners.patrol.ground.surroundings import places_in_sight
from rota.planners.patrol.tolerances import BESIDE_M, HAIR_M, SLIVER_M2


class Around(NamedTuple):
    """A pocket and the places round it, as polygons in metres.

    ``pocket`` and ``beside`` hold all places where robots may be, and a little more; ``clear``: of those beside the
    pocket where they can be without touching a robot in it. ``sure_pocket`` and ``sure_touching`` hold only places
    where robots may be: all of the pocket, and others where they touch a robot in it wherever that stands.
    """

    pocket: Polygon
    beside: BaseGeometry
    clear: BaseGeometry
    sure_pocket: Polygon
    sure_touching: BaseGeometry

    def is_needed_for(self, view: BaseGeometry) -> bool:
        """Whether what has this view is seen from the pocket alone."""
        return are_apart(view, self.beside) and view.intersection(self.sure_pocket).area > SLIVER_M2

    def keeps_from(self, view: BaseGeometry) -> bool:
        """Whether what has this view is seen only from where a robot touches one in the pocket."""
        hidden = are_apart(view, self.clear) and are_apart(view, self.pocket)
        return hidden and view.intersection(self.sure_touching).area > SLIVER_M2


def refuse_pockets_in_the_way(problem: Problem) -> None:
    """Raise NoPlanFound where a pocket is needed, and keeps others from something that they alone can see.

    Robots of a fleet with entrances come to no pockets. Nothing is said of fleets whose bodies differ.
    """
    fleet = problem.mission.fleet
    bodies_m = {robot.body_radius_m for robot in fleet.unlike_robots}
    if fleet.entrances is not None or len(bodies_m) > 1 or bodies_m == {0.0}:
        return
    for part in problem.paths.parts[1:]:
        around = places_around(problem, part)
        if around is None:
            continue
        lost_m = first_asked(problem, around, around.sure_touching, around.keeps_from)
        for_m = None if lost_m is None else first_asked(problem, around, part, around.is_needed_for)
        if lost_m is not None and for_m is not None:
            raise NoPlanFound(in_words(part, for_m, lost_m))


def places_around(problem: Problem, part: Polygon) -> Around | None:
    """The places round a part of the space; None where it is no pocket, or in nobody's way.

    Round corners the check lets bodies come a little nearer than they can.
    """
    body_m = problem.robot.body_radius_m
    if shapely.minimum_bounding_radius(part) >= body_m:
        return None
    box = box_around(problem, part)
    loose_m = (body_m - TOUCH_M) * math.cos(math.pi / POCKET_ARC_CORNERS)
    parts = shapely.get_parts(standing_space_in(problem.mission, loose_m, box, arc_corners=POCKET_ARC_CORNERS))
    is_own = shapely.intersects(parts, part)
    if np.count_nonzero(is_own) != 1 or shapely.minimum_bounding_radius(parts[is_own][0]) >= body_m:
        return None  # it is joined to others, if but by a hair
    pocket, beside = parts[is_own][0], shapely.union_all(parts[~is_own])
    corners = shapely.points(shapely.get_coordinates(shapely.convex_hull(pocket)))
    touching = shapely.intersection_all(shapely.buffer(corners, 2 * body_m - TOUCH_M, quad_segs=ARC_STEPS))
    sure_touching = clip(problem.space, box).difference(part).intersection(touching)
    if sure_touching.area < SLIVER_M2:
        return None
    return Around(pocket, beside, beside.difference(touching), part, sure_touching)


def box_around(problem: Problem, shape: BaseGeometry) -> Box:
    """The box that holds what is in reach of all that is in reach of a shape."""
    return grown_box(shape.bounds, 2 * (problem.robot.sensor.reach_m + problem.robot.body_radius_m))


def are_apart(one: BaseGeometry, other: BaseGeometry) -> bool:
    """Whether two shapes, of which one may be empty, do not even touch."""
    return not shapely.dwithin(one, other, HAIR_M)


def first_asked(
    problem: Problem, around: Around, near: BaseGeometry, is_such: Callable[[BaseGeometry], bool]
) -> Floats | None:
    """The first point (2,) of what is asked within reach of some places whose view is such; None without any.

    The view of a point is where robots may be that see it.
    """
    reach_m = problem.robot.sensor.reach_m
    space = MultiPolygon([part for part in shapely.get_parts([around.pocket, around.beside]) if part.area > 0])
    for region in problem.regions:
        if region.demand != "every_point":
            continue
        ground = clip(region.shape, grown_box(near.bounds, reach_m))
        points_m = nooks(ground, BESIDE_M)
        for point_m in points_m[shapely.contains_xy(ground, points_m)]:
            if is_such(places_in_sight(point_m, space, problem.walls, reach_m)):
                return np.asarray(point_m)
    return None


def in_words(pocket: Polygon, for_m: Floats, lost_m: Floats) -> str:
    """Why no plan sees both places, and what to do about it."""
    stand = pocket.representative_point()
    return (
        f"nobody sees all that is asked: ({for_m[0]:.3f}, {for_m[1]:.3f}) is seen only from the pocket round"
        f" ({stand.x:.3f}, {stand.y:.3f}), which no robot leaves, and ({lost_m[0]:.3f}, {lost_m[1]:.3f}) only from"
        " where a body touches whoever is in there; fleet.entrances keeps robots out of pockets and leaves out what is"
        " seen only from there; close_gaps_m of a map closes them"
    )

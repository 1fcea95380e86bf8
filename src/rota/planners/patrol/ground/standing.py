"""The space where robots can stand, with corners as finely rounded as what they must see there needs it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import shapely
from shapely import MultiPolygon, Polygon

from rota.errors import NoPlanFound
from rota.geometry.free_space import (
    DemandedRegion,
    parts_entered,
    sight_walls,
    standing_anywhere,
    standing_space_in,
)
from rota.geometry.threads import side_by_side
from rota.geometry.tiles import grown_box
from rota.model.mission import Mission, Robot
from rota.model.polygons import polygons_of
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.limits_of_sight import limit_is_asked_for
from rota.planners.patrol.ground.samples import MANY_CORNERS
from rota.planners.patrol.ground.sight import Sight
from rota.planners.patrol.ground.unseeable import ground_asked_for, unseeable_ground
from rota.planners.patrol.tolerances import SLIVER_M2
from rota.vehicles.models import MODELS

ARC_CORNERS = 16  # corners of a whole turn round a grown corner
POCKET_ARC_CORNERS = 128  # the same beside pockets of the space, which coarse arcs would part from it
FEW_CORNERS = 100  # of walls that are drawn as finely as arcs may be
GRAZE_M = 9e-7  # by so much bodies may touch the walls of a scanned floor; a plan may have them touch by 1e-6 m
CLEARANCE = 2e-3  # of its radius by which a body keeps off walls on its way from an entrance


class StandingSpace(NamedTuple):
    """Where the robot's centre may be.

    robot: it, with corners that it cuts no more than walls allow. sure: the part of it in which the check, too, has
    robots stand: all, unless the fleet has entrances. Proofs count on what is seen from there. at_limit: what is asked
    reaches to the limit of what is seen from the whole.
    """

    whole: MultiPolygon
    sure: MultiPolygon
    at_limit: bool
    robot: Robot


def space_for(
    mission: Mission, regions: Sequence[DemandedRegion], robot: Robot, range_margin_m: float
) -> StandingSpace:
    """Where the robot's centre may be, and whether the regions reach to the limit of what it sees from there.

    The walls of a scanned floor follow its pixels, as the border of where robots can stand then does. Much is seen only
    from the very line of another wall, that is only if bodies may touch walls a little.

    Where robots cut corners, their polylines keep so much farther off walls. Where what is asked can be seen only from
    nearer, or a zone to visit be entered only there, they cut corners half as much, a quarter, an eighth, or stop at
    each, if they choose that themselves. Corners of the space are rounded finely where that is not enough. Raises
    NoPlanFound where the robot can stand nowhere at all, or nowhere in a zone to visit.
    """
    visits = [region for region in regions if region.demand == "visit"]
    for own in cutting_less(robot):
        body_m = thin_m(mission, own) + driving_of(own).off_m
        space, sure = _drawn_coarsely(mission, body_m)
        at_limit = limit_is_asked_for(regions, space, own, range_margin_m)
        enters = not any(shapely.disjoint(region.shape, space) for region in visits)
        if not at_limit and enters and not hides_more(mission, regions, own, space):
            break
    else:
        few = corners_of(mission) <= FEW_CORNERS
        space, sure = _draw(mission, body_m, fine_arc_corners(body_m, few_walls=few))
    if space.is_empty:
        raise NoPlanFound(f"there is no place where a body of radius {body_m} m can stand")
    for region in visits:
        if shapely.disjoint(region.shape, space):
            spot = region.shape.representative_point()
            fits = "blocked to motion" if body_m == 0 else f"no place for a body of radius {body_m} m"
            raise NoPlanFound(
                f"no robot can be inside zone {region.name}, at ({spot.x:.2f}, {spot.y:.2f}): it is {fits}"
            )
    return StandingSpace(space, sure, at_limit, own)


def cutting_less(robot: Robot) -> Iterator[Robot]:
    """The robot as it is, and, if its planner and not its firmware cuts corners, with corners cut less and less."""
    yield robot
    driving, motion = driving_of(robot), robot.motion
    if driving.off_m == 0 or motion.vehicle in MODELS:
        return
    for share in (1 / 2, 1 / 4, 1 / 8, 0.0):
        yield replace(robot, motion=replace(motion, corner_m=share * driving.off_m))


def hides_more(mission: Mission, regions: Sequence[DemandedRegion], robot: Robot, space: MultiPolygon) -> bool:
    """Whether walls hide more of what is asked from the space of a robot that cuts corners than if it stopped there.

    False for one whose firmware cuts them.
    """
    if driving_of(robot).off_m == 0 or robot.motion.vehicle in MODELS:
        return False
    asked, walls = ground_asked_for(tuple(regions)), sight_walls(mission)
    hidden_m2 = unseeable_ground(asked, Sight(space, walls, robot, 0.0)).m2
    if hidden_m2 == 0:
        return False
    whole, _ = _drawn_coarsely(mission, thin_m(mission, robot))
    return hidden_m2 > 1.01 * unseeable_ground(asked, Sight(whole, walls, robot, 0.0)).m2 + SLIVER_M2


def thin_m(mission: Mission, robot: Robot) -> float:
    """The radius that a robot's body is planned with: a little less than its own on a scanned floor."""
    return max(0.0, robot.body_radius_m - GRAZE_M) if has_many_corners(mission) else robot.body_radius_m


def clear_body_m(mission: Mission, body_radius_m: float) -> float:
    """The radius of the body that the sure part of the space is made for, and that touches no wall there."""
    return body_radius_m if mission.fleet.entrances is None else body_radius_m * (1 + CLEARANCE)


def has_many_corners(mission: Mission) -> bool:
    """Whether the area and the obstacles have as many corners as a scanned floor."""
    return corners_of(mission) > MANY_CORNERS


def corners_of(mission: Mission) -> int:
    """How many corners the area and the obstacles have."""
    shapes = [mission.area, *(obstacle.shape for obstacle in mission.obstacles)]
    return int(shapely.get_num_coordinates(shapes).sum())


def _drawn_coarsely(mission: Mission, body_radius_m: float) -> tuple[MultiPolygon, MultiPolygon]:
    """Where the centre of a body may be, and surely comes to, with few corners."""
    if not has_many_corners(mission):
        return _draw(mission, body_radius_m, ARC_CORNERS)
    few = 8
    space, sure = _anywhere(mission, body_radius_m, few)
    space = with_pockets_opened(mission, space, body_radius_m)
    return _behind_entrances(mission, space, sure, body_radius_m, few)


def _draw(mission: Mission, body_radius_m: float, arc_corners: int) -> tuple[MultiPolygon, MultiPolygon]:
    """The same with so many corners of a whole turn."""
    space, sure = _anywhere(mission, body_radius_m, arc_corners)
    return _behind_entrances(mission, space, sure, body_radius_m, arc_corners)


def _anywhere(mission: Mission, body_radius_m: float, arc_corners: int) -> tuple[MultiPolygon, MultiPolygon]:
    """Where the centres of a body and of one that keeps off walls may be, entrances aside; drawn on two cores."""
    radii_m = sorted({body_radius_m, clear_body_m(mission, body_radius_m)})
    spaces = side_by_side(lambda radius_m: standing_anywhere(mission, radius_m, arc_corners=arc_corners), radii_m)
    return spaces[0], spaces[-1]


def _behind_entrances(
    mission: Mission, space: MultiPolygon, sure: MultiPolygon, body_radius_m: float, arc_corners: int
) -> tuple[MultiPolygon, MultiPolygon]:
    """The part of the space that ways lead to from the fleet's entrances, and of that where bodies keep off walls.

    All of it where the fleet has none. For the check bodies keep off walls by ``check.standing.CLEARANCE``, here by
    twice that. Corners are drawn finely about all that coarse ones cut off.
    """
    if mission.fleet.entrances is None:
        return space, space
    clear_m = clear_body_m(mission, body_radius_m)
    cut_off = _parts_beside(sure, parts_entered(sure, mission, clear_m, arc_corners=arc_corners))
    sure = drawn_finer(mission, sure, cut_off, clear_m)
    space = drawn_finer(mission, space, cut_off, body_radius_m)
    sure = parts_entered(sure, mission, clear_m, arc_corners=arc_corners)
    near = sure.buffer(4 * CLEARANCE * body_radius_m + GRAZE_M, quad_segs=2)
    far = [part for part in shapely.get_parts(shapely.difference(space, near)) if part.area > SLIVER_M2]
    within = polygons_of(shapely.difference(space, shapely.union_all(far))) if far else space
    return parts_entered(within, mission, body_radius_m, arc_corners=arc_corners), sure


def _parts_beside(space: MultiPolygon, inside: MultiPolygon) -> list[Polygon]:
    """The parts of a space but for those inside."""
    known = {part.wkb for part in inside.geoms}
    return [part for part in space.geoms if part.wkb not in known]


def with_pockets_opened(mission: Mission, space: MultiPolygon, body_radius_m: float) -> MultiPolygon:
    """The space, with round corners drawn finely about its pockets: parts no larger than a body.

    Coarse arcs cut off places in which a robot would stay for ever, and in the way of all others.
    """
    pockets = [part for part in space.geoms if part.area <= math.pi * body_radius_m**2]
    return drawn_finer(mission, space, pockets, body_radius_m)


def drawn_finer(mission: Mission, space: MultiPolygon, parts: Sequence[Polygon], body_radius_m: float) -> MultiPolygon:
    """The space, with round corners drawn finely about some of its parts, which that may join to others."""
    finer = side_by_side(
        lambda part: standing_space_in(
            mission, body_radius_m, grown_box(part.bounds, 2 * body_radius_m), arc_corners=POCKET_ARC_CORNERS
        ),
        parts,
    )
    return polygons_of(shapely.union_all([space, *finer])) if finer else space


def fine_arc_corners(body_radius_m: float, *, few_walls: bool = False) -> int:
    """Corners of a whole turn round a grown corner that keep a robot at most half a millimetre too far from it.

    few_walls: a tenth of one, since squares see into no-fly zones from all of an arc; the check draws it finely, too.
    """
    off_m = 0.00005 if few_walls else 0.0005
    return max(ARC_CORNERS, math.ceil(math.pi / math.acos(1 / (1 + off_m / max(body_radius_m, off_m)))))

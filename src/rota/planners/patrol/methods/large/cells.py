"""A mission cut into missions for boxes of its area, each of which asks for the ground in its box alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion, demanded_regions
from rota.model.arrays import Floats
from rota.model.mission import Fleet, Mission, Obstacle, Zone
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tolerances import SLIVER_M2

Box = tuple[float, float, float, float]  # x0, y0, x1, y1 in metres

ELSEWHERE = "outside the district"


class Entered(NamedTuple):
    """Where robots with a body of this radius surely come to from a mission's entrances."""

    space: MultiPolygon
    body_radius_m: float


def where_robots_come(problem: Problem) -> Entered | None:
    """Where the problem's robots come to; None where its mission has no entrances."""
    if problem.mission.fleet.entrances is None:
        return None
    return Entered(problem.sure_space, problem.sure_robot.body_radius_m)


def weighed_boxes(shape: BaseGeometry, weights: Floats) -> list[Box]:
    """A box for each of the weights (n,): they share no ground, cover the shape, and hold of it what their weights say.

    The bounds of the shape are cut across their longer side, again and again.
    """
    return list(_cut(shape, shape.bounds, weights))


def _cut(shape: BaseGeometry, box: Box, weights: Floats) -> Iterator[Box]:
    """Boxes that share the shape out by the weights, by cutting it in halves across its longer side."""
    if len(weights) == 1 or shape.is_empty:
        yield from [box] * len(weights)
        return
    x0, y0, x1, y1 = box
    first = len(weights) // 2
    left, low, right, high = shape.bounds
    upright = right - left >= high - low
    bottom, top = (left, right) if upright else (low, high)
    wanted_m2 = shape.area * float(weights[:first].sum() / weights.sum())
    for _ in range(40):  # halvings, as far as digits go
        at = (bottom + top) / 2
        below = shapely.clip_by_rect(shape, x0 - 1, y0 - 1, *((at, y1 + 1) if upright else (x1 + 1, at)))
        bottom, top = (at, top) if below.area < wanted_m2 else (bottom, at)
    one: Box = (x0, y0, at, y1) if upright else (x0, y0, x1, at)
    other: Box = (at, y0, x1, y1) if upright else (x0, at, x1, y1)
    yield from _cut(polygons_of(shapely.intersection(shape, shapely.box(*one))), one, weights[:first])
    yield from _cut(polygons_of(shapely.intersection(shape, shapely.box(*other))), other, weights[first:])


def missions_of(mission: Mission, count: int, margin_m: float, entered: Entered | None = None) -> list[Mission]:
    """Missions for so many boxes with about as much demanded ground each, which together ask for what the whole asks.

    margin_m: how far round its box a robot may go. What it may pass there asks nothing, and neither do boxes without
    demanded ground, which are absent. entered: where robots come to in the whole, if it has entrances. Each box then
    has entrances of its own to that; boxes in which robots come to nothing are absent. A zone to visit is asked for in
    the box with most of it. Numbers of robots, and what is to be done when ground cannot be seen, are for the whole
    alone.
    """
    regions = demanded_regions(mission)
    asked = shapely.union_all([region.shape for region in regions if region.demand == "every_point"])
    boxes = weighed_boxes(asked, np.ones(count))
    missions = [mission_in(mission, k, boxes, regions, margin_m, entered) for k in range(len(boxes))]
    return [each for each in missions if each is not None]


def mission_in(
    mission: Mission,
    k: int,
    boxes: list[Box],
    regions: tuple[DemandedRegion, ...],
    margin_m: float,
    entered: Entered | None = None,
) -> Mission | None:
    """The mission for the k-th of the boxes; None when nothing is asked there, or no robot comes there."""
    own = shapely.box(*boxes[k])
    visits = {region.name for region in regions if region.demand == "visit" and k == box_with_most(region, boxes)}
    x0, y0, x1, y1 = boxes[k]
    wide = shapely.box(x0 - margin_m, y0 - margin_m, x1 + margin_m, y1 + margin_m)
    wide = shapely.union_all([wide, *(region.shape.envelope for region in regions if region.name in visits)])
    near = shapely.get_parts(shapely.intersection(mission.area, wide))
    area = polygons_of(near[shapely.intersects(near, own)])
    zones = [zone for zone in (zone_in(zone, own, asked=zone.name in visits) for zone in mission.zones) if zone]
    zones = [zone for zone in zones if zone.shape.intersection(area).area > SLIVER_M2]
    outside = polygons_of(shapely.difference(area, own))
    if outside.area > SLIVER_M2:
        zones.append(Zone(name=new_name(ELSEWHERE, [zone.name for zone in zones]), shape=outside, period_s=None))
    inside = any(
        region.demand == "every_point" and region.shape.intersection(own).area > SLIVER_M2 for region in regions
    )
    fleet = mission.fleet if entered is None else with_entrances_to(entered, mission.fleet, area, wide)
    if area.is_empty or not (inside or visits) or fleet is None:
        return None
    return replace(
        mission,
        fleet=fleet,
        area=area,
        zones=tuple(zones),
        obstacles=tuple(obstacles_near(mission.obstacles, wide)),
        unseeable="exclude",
    )


def with_entrances_to(entered: Entered, fleet: Fleet, area: MultiPolygon, wide: BaseGeometry) -> Fleet | None:
    """The fleet with an entrance to each part of what robots come to in an area; None where that is nothing.

    wide: what the area was cut with. A body keeps clear of the cut.
    """
    room = shapely.intersection(entered.space, wide.buffer(-entered.body_radius_m, join_style="mitre"))
    parts = shapely.get_parts(polygons_of(shapely.intersection(room, area)))
    doors = shapely.get_coordinates(shapely.point_on_surface(parts[shapely.area(parts) > SLIVER_M2]))
    return replace(fleet, entrances=tuple((float(x), float(y)) for x, y in doors)) if len(doors) else None


def zone_in(zone: Zone, own: Polygon, *, asked: bool) -> Zone | None:
    """What a zone is in a box: the part of it there; a zone to visit is whole where it is asked for.

    Where it is not, its ground asks nothing, as it does in the whole mission. None when there is none of it.
    """
    if asked:
        return zone
    shape = polygons_of(shapely.intersection(zone.shape, own))
    if shape.is_empty:
        return None
    if zone.demand == "visit":
        return Zone(name=zone.name, shape=shape, period_s=None)
    return replace(zone, shape=shape)


def new_name(name: str, taken: Sequence[str]) -> str:
    """The name, made longer until it is none of those taken."""
    while name in taken:
        name += "'"
    return name


def box_with_most(region: DemandedRegion, boxes: list[Box]) -> int:
    """The first of the boxes with the greatest part of the region; the nearest when none has any."""
    cells = shapely.box(*np.array(boxes).T)
    shares = shapely.area(shapely.intersection(region.shape, cells))
    if shares.max() > 0:
        return int(np.argmax(shares))
    return int(np.argmin(shapely.distance(region.shape, cells)))


def obstacles_near(obstacles: tuple[Obstacle, ...], shape: BaseGeometry) -> Iterator[Obstacle]:
    """The obstacles that meet the shape, whole."""
    if obstacles:
        shapely.prepare(shape)
        meets = shapely.intersects(shape, np.array([obstacle.shape for obstacle in obstacles]))
        yield from (obstacle for obstacle, near in zip(obstacles, meets, strict=True) if near)


def boxes_for(asked_m2: float, most_m2: float) -> int:
    """How many boxes hold so much ground each at most."""
    return max(1, math.ceil(asked_m2 / most_m2))

"""How much of what is asked can surely be seen: the area that every other proof may count on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion
from rota.geometry.tiles import clip, few_cornered_boxes, grown_box
from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Robot, inner_reach_m
from rota.planners.patrol.ground.limits_of_sight import ARC_STEPS, area_in_range
from rota.planners.patrol.tolerances import HAIR_M

# before GEOS draws round a shape it leaves out dents of the outline that are shallower than this share of the distance
DENTS = 0.01


class _Near(NamedTuple):
    """What is asked in a box (None: zones to visit), and the space and the walls that matter to it."""

    asked: list[MultiPolygon | None]
    space: MultiPolygon
    lines: NDArray[np.object_]


def surely_seeable_m2(
    regions: Sequence[DemandedRegion], space: MultiPolygon, walls: Floats, robot: Robot
) -> list[float]:
    """For each region an area in m2 that is surely seen from somewhere, never too large; 0 for zones to visit.

    walls: (k, 4) metres, the borders of what blocks sight. Surely seen is the ground that a body covers, unless walls
    run through where robots can stand: nothing that blocks motion comes between. Surely seen is also what is in range
    with no wall within reach. Ground that is seen only past walls is left out.

    Whether a place belongs to it depends on nothing farther than the reach. Where corners are very many, boxes with all
    that is so near them are looked at one by one, and their areas are added up.
    """
    parts = list(_near_boxes(regions, space, walls, 1.1 * robot.sensor.reach_m))
    walls_inside = any(_walls_run_through(part) for part in parts)
    body_m = 0.0 if walls_inside else min(robot.body_radius_m, inner_reach_m(robot.sensor))
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
        within = [None if shape is None else clip(shape, box) for shape in asked]
        if any(shape is not None and not shape.is_empty for shape in within):
            wide = grown_box(box, near_m)
            yield _Near(within, clip(space, wide), lines[np.sort(tree.query(shapely.box(*wide)))])


def _walls_run_through(part: _Near) -> bool:
    """Whether walls run through where robots can stand, by more than a hair."""
    inner = part.space.buffer(-HAIR_M)
    shapely.prepare(inner)
    return bool(shapely.intersects(inner, part.lines).any())


def _surely_seen_m2(part: _Near, robot: Robot, body_m: float) -> list[float]:
    """The areas of what is asked in one box that is surely seen, as ``surely_seeable_m2`` gives them.

    An outline without its shallow dents lies outside of the shape by at most their depth. Bodies and reaches count as
    that much shorter, so that nothing is drawn that nobody sees.
    """
    space, lines = part.space, part.lines
    disc = isinstance(robot.sensor, DiscSensor)
    short_m = robot.sensor.reach_m * DENTS / (1 + DENTS) if disc else 0.0
    wide_m = robot.sensor.reach_m / math.cos(math.pi / (4 * ARC_STEPS))
    covered, bodies = space, space
    if body_m > 0:
        covered = space.buffer(body_m, quad_segs=ARC_STEPS)
        bodies = space.buffer(body_m / (1 + DENTS), quad_segs=ARC_STEPS)
    beyond = shapely.difference(shapely.union_all([shape for shape in part.asked if shape is not None]), covered)
    seen = bodies
    if not _all_near(beyond, lines, robot.sensor.reach_m):  # else there is hardly more than what bodies cover
        # each line by itself: round all at once, where most are nearer than the reach, takes a hundred times as long
        hidden = shapely.union_all(shapely.buffer(lines, wide_m, quad_segs=ARC_STEPS))
        seen = shapely.union_all([bodies, area_in_range(space, robot, short_m).difference(hidden)])
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

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
from rota.geometry.tiles import Box, clipped, few_cornered_boxes, grown_box
from rota.mission import Robot, inner_reach_m
from rota.planners.patrol.ground.limits_of_sight import ARC_STEPS, area_in_range

Floats = NDArray[np.float64]

HAIR_M = 1e-6
CLOSE = 0.02  # of the reach, and twice a body's radius: farther off nothing tells what bodies cover


class _Near(NamedTuple):
    """What is asked in a box (None: zones to visit), and the space and the walls that matter to it."""

    box: Box
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
    that is so near them are looked at one by one, and their areas are added up. What bodies cover there depends on much
    less, and mostly walls are near all the rest: then a box needs no more.
    """
    reach_m, body_m = robot.sensor.reach_m, min(robot.body_radius_m, inner_reach_m(robot.sensor))
    whole = _whole(regions, space, walls)
    is_ordinary = len(_boxes(whole, 1.1 * reach_m)) == 1
    parts = [whole] if is_ordinary else list(_near_boxes(whole, 2 * body_m + CLOSE * reach_m))
    if any(_walls_run_through(part) for part in parts):
        body_m = 0.0
    if is_ordinary:
        each = [_surely_seen_m2(whole, robot, body_m)]
    else:
        tree = shapely.STRtree(whole.lines)
        each = [areas for part in parts for areas in _seen_in_box_m2(part, whole, tree, robot, body_m)]
    return [math.fsum(areas) for areas in zip(*each, strict=True)]


def _whole(regions: Sequence[DemandedRegion], space: MultiPolygon, walls: Floats) -> _Near:
    """All ground."""
    asked = [region.shape if region.demand == "every_point" else None for region in regions]
    shapes = [space, *(shape for shape in asked if shape is not None)]
    x0, y0, x1, y1 = shapely.union_all([shapely.box(*shape.bounds) for shape in shapes]).bounds
    return _Near((x0, y0, x1, y1), asked, space, shapely.linestrings(walls.reshape(-1, 2, 2)))


def _boxes(whole: _Near, near_m: float) -> list[Box]:
    """Boxes with few corners near each that cover the ground: one for ordinary ground."""
    shapes = [whole.space, *(shape for shape in whole.asked if shape is not None)]
    corners = np.vstack([*map(shapely.get_coordinates, shapes), shapely.get_coordinates(whole.lines)])
    return few_cornered_boxes(whole.box, corners, near_m)


def _near_boxes(whole: _Near, near_m: float) -> Iterator[_Near]:
    """What is asked in each of these boxes, and what is near it; boxes in which nothing is asked are left out."""
    tree = shapely.STRtree(whole.lines)
    for box in _boxes(whole, near_m):
        within = [None if shape is None else clipped(shape, box) for shape in whole.asked]
        if any(shape is not None and not shape.is_empty for shape in within):
            wide = grown_box(box, near_m)
            lines = whole.lines[np.sort(tree.query(shapely.box(*wide)))]
            yield _Near(box, within, clipped(whole.space, wide), lines)


def _walls_run_through(part: _Near) -> bool:
    """Whether walls run through where robots can stand, by more than a hair."""
    inner = part.space.buffer(-HAIR_M)
    shapely.prepare(inner)
    return bool(shapely.intersects(inner, part.lines).any())


def _seen_in_box_m2(
    part: _Near, whole: _Near, walls: shapely.STRtree, robot: Robot, body_m: float
) -> Iterator[list[float]]:
    """The areas of what is asked in one box that is surely seen, or those of several that share it.

    The part tells what is close to the box only. walls: the lines of the whole.
    """
    bodies = _under_bodies(part, body_m)
    if _all_near(_beyond(part, bodies), walls, robot.sensor.reach_m):
        yield _areas_m2(part, bodies)
        return
    near_m = 1.1 * robot.sensor.reach_m
    wide = grown_box(part.box, near_m)
    lines = whole.lines[np.sort(walls.query(shapely.box(*wide)))]
    for smaller in _near_boxes(_Near(part.box, part.asked, clipped(whole.space, wide), lines), near_m):
        yield _surely_seen_m2(smaller, robot, body_m)


def _surely_seen_m2(part: _Near, robot: Robot, body_m: float) -> list[float]:
    """The areas of what is asked in one box that is surely seen, as ``surely_seeable_m2`` gives them."""
    bodies = _under_bodies(part, body_m)
    if _all_near(_beyond(part, bodies), shapely.STRtree(part.lines), robot.sensor.reach_m):
        return _areas_m2(part, bodies)
    wide_m = robot.sensor.reach_m / math.cos(math.pi / (4 * ARC_STEPS))
    hidden = shapely.buffer(shapely.union_all(part.lines), wide_m, quad_segs=ARC_STEPS)
    return _areas_m2(part, shapely.union_all([bodies, area_in_range(part.space, robot, 0.0).difference(hidden)]))


def _under_bodies(part: _Near, body_m: float) -> BaseGeometry:
    """The ground that bodies cover."""
    return part.space.buffer(body_m, quad_segs=ARC_STEPS) if body_m > 0 else part.space


def _beyond(part: _Near, bodies: BaseGeometry) -> BaseGeometry:
    """What is asked beyond the ground that bodies cover."""
    return shapely.difference(shapely.union_all([shape for shape in part.asked if shape is not None]), bodies)


def _areas_m2(part: _Near, seen: BaseGeometry) -> list[float]:
    """The areas of what is asked and seen."""
    return [0.0 if shape is None else float(shapely.intersection(shape, seen).area) for shape in part.asked]


def _all_near(shape: BaseGeometry, lines: shapely.STRtree, near_m: float) -> bool:
    """Whether every part of the shape is so small, and so near one of the lines, that all of it surely is near."""
    pieces = shapely.get_parts(shapely.get_parts(np.atleast_1d(shape)))
    if not len(pieces) or not len(lines):
        return not len(pieces)
    x0, y0, x1, y1 = shapely.bounds(pieces).T
    middles = shapely.points((x0 + x1) / 2, (y0 + y1) / 2)
    _, away_m = lines.query_nearest(middles, return_distance=True, all_matches=False)
    return bool((away_m + np.hypot(x1 - x0, y1 - y0) / 2 <= near_m).all())

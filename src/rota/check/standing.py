"""Where a body can stand."""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.check.arrays import Floats
from rota.check.blocking import blocks_motion
from rota.check.routes import lines_of, segments_of
from rota.check.tolerances import TOUCH_M
from rota.model.mission import Fleet, Mission, Obstacle, Robot, Sensor

Box = tuple[float, float, float, float]  # x0, y0, x1, y1 in metres

# per quarter of a circle: at corners a body may stand 3e-4 of its radius too near, never too far; 2e-5 of few sides
ARC_STEPS, FINE_ARC_STEPS, FEW_SIDES = 32, 128, 200
CLEARANCE = 1e-3  # of its radius by which a body keeps off walls on its way from an entrance
TILE_SIDES, LEAST_TILE_M = 1_000, 0.01
_ONE_AT_A_TIME = threading.Lock()


@dataclass(frozen=True, kw_only=True, eq=False)
class StandingArea:
    """Where the bodies of one kind of robot can stand (a shapely geometry), and what their sensor reaches."""

    shape: Any
    sensor: Sensor


def standing(area: MultiPolygon, obstacles: tuple[Obstacle, ...], body_radius_m: float) -> Any:
    """All places where a whole body disc is inside the area and out of what blocks motion, give or take 1e-6 m.

    It need not be connected, and it may be empty. Round corners it is larger by up to 3e-4 of the radius, or by 2e-5
    where sides are few, as arcs are replaced by their chords.
    """
    blocked = blocks_motion(obstacles)
    body = body_radius_m - TOUCH_M
    if body <= 0:
        return shapely.difference(area, blocked)
    open_ground = shapely.difference(area, blocked)
    sides = np.vstack([segments_of(area), segments_of(blocked)])
    if len(sides) <= TILE_SIDES or open_ground.is_empty:
        return _out_of(lines_of(sides), body, open_ground, FINE_ARC_STEPS if len(sides) <= FEW_SIDES else ARC_STEPS)
    # where a map is read all around as an obstacle, area and obstacle share their sides
    turned = (sides[:, 0] > sides[:, 2]) | ((sides[:, 0] == sides[:, 2]) & (sides[:, 1] > sides[:, 3]))
    sides = np.unique(np.where(turned[:, None], sides[:, [2, 3, 0, 1]], sides), axis=0)
    lines = lines_of(sides)
    tree = shapely.STRtree(lines)

    def in_tile(box: Box) -> Any:
        frame = shapely.box(*box)
        near = np.sort(tree.query(shapely.buffer(frame, 1.01 * body)))
        return _out_of(lines[near], body, _cut_to(frame, open_ground), ARC_STEPS)

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        return shapely.union_all(list(pool.map(in_tile, _tiles(open_ground.bounds, sides))))


def _out_of(lines: Any, body_m: float, ground: Any, steps: int) -> Any:
    """The part of the ground that is farther than ``body_m`` from the lines (n,); steps: of a quarter of a circle.

    Lines are grown one by one, since offsetting a whole polygon loses corridors only just as wide as the body.
    """
    return shapely.difference(ground, shapely.union_all(shapely.buffer(lines, body_m, quad_segs=steps)))


def _tiles(box: Box, sides: Floats) -> Iterator[Box]:
    """Boxes that share no ground and together are the box, each with few of the sides (n, 4): their middles count."""
    x0, y0, x1, y1 = box
    middles = (sides[:, :2] + sides[:, 2:]) / 2
    inside = ((middles >= (x0, y0)) & (middles <= (x1, y1))).all(axis=1)
    if inside.sum() <= TILE_SIDES or max(x1 - x0, y1 - y0) <= LEAST_TILE_M:
        yield box
        return
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    wide = x1 - x0 >= y1 - y0
    yield from _tiles((x0, y0, x, y1) if wide else (x0, y0, x1, y), sides[inside])
    yield from _tiles((x, y0, x1, y1) if wide else (x0, y, x1, y1), sides[inside])


def standing_areas(mission: Mission, names: tuple[str, ...] = ()) -> tuple[StandingArea, ...]:
    """One area for each kind of robot (body and sensor) that the fleet has; names: of the sensors that count, if any.

    Where no robot has any of these, all have an area: ground is no less asked for since nobody can see it by them.

    With entrances it holds only where a body can be driven to from one of them with clearance: as if it were larger by
    a thousandth of its radius. No robot drives through a gap just as wide as itself, nor looks along a wall that it
    touches to a micrometre.
    """
    with _ONE_AT_A_TIME:  # several parts of a check ask at once: the first works it out for all
        every = _standing_areas(mission.area, mission.obstacles, _kinds(mission.fleet), mission.fleet.entrances)
    return tuple(area for area in every if not names or area.sensor.name in names) or every


def standing_area_of(mission: Mission, robot: Robot) -> StandingArea:
    """The area for the kind of this robot of the fleet."""
    return standing_areas(mission)[_kinds(mission.fleet).index((robot.body_radius_m, robot.sensor))]


def _kinds(fleet: Fleet) -> tuple[tuple[float, Sensor], ...]:
    """Body radius and sensor of each kind of robot that the fleet has, in the order of its robots."""
    robots = fleet.unlike_robots
    return tuple({(robot.body_radius_m, robot.sensor): None for robot in robots})


@functools.lru_cache(maxsize=4)
def _standing_areas(
    area: MultiPolygon,
    obstacles: tuple[Obstacle, ...],
    kinds: tuple[tuple[float, Sensor], ...],
    entrances: tuple[tuple[float, float], ...] | None,
) -> tuple[StandingArea, ...]:
    """The same for the kinds of robots; a search has missions checked that differ in their periods only."""
    clear = 0.0 if entrances is None else CLEARANCE
    shapes = [standing(area, obstacles, body_m * (1 + clear)) for body_m, _ in kinds]
    return tuple(
        StandingArea(shape=_parts_at_entrances(shape, entrances, near_entrance_m(body_m)), sensor=sensor)
        for shape, (body_m, sensor) in zip(shapes, kinds, strict=True)
    )


def near_entrance_m(body_radius_m: float) -> float:
    """How far from where bodies come with clearance an entrance may be: a body there may touch walls."""
    return 10 * CLEARANCE * body_radius_m + 2 * TOUCH_M


def near_way_in_m(body_radius_m: float) -> float:
    """How far from where bodies come with clearance robots may drive, which touch walls and turn in corners.

    In a corner of 3 degrees a body that touches both walls is so far off; in a gap just as wide as itself, between the
    ends of two walls, it is 4.5 % of its radius off.
    """
    return 40 * CLEARANCE * body_radius_m + 2 * TOUCH_M


def _parts_at_entrances(places: Any, entrances: tuple[tuple[float, float], ...] | None, near_m: float) -> Any:
    """The parts of the places that an entrance lies in, or near to; all of them where none are given."""
    if entrances is None:
        return places
    parts = shapely.get_parts(shapely.get_parts(np.atleast_1d(places)))
    return shapely.multipolygons(parts[shapely.dwithin(parts, shapely.multipoints(np.array(entrances)), near_m)])


def _cut_to(frame: Any, shape: Any) -> Any:
    """The polygons of what the frame and the shape have in common."""
    return _polygons(shapely.intersection(shape, frame))


def _polygons(shape: Any) -> Any:
    """The polygons among the parts of a shape."""
    parts = shapely.get_parts(shapely.get_parts(np.atleast_1d(shape)))
    return shapely.multipolygons(parts[shapely.get_type_id(parts) == 3])

"""Whether a fleet can start, and come in, where its mission says: in free space, and bodies apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import MultiPolygon, Point, box, union_all

from rota.model.fleet import COORDINATES, Fleet, Place, StartBox, StartPoints
from rota.model.limits import LARGEST_M

TOUCH_M = 1e-6  # by which a body may overlap what it touches
ENTRANCE_CLEARANCE = 1e-3  # of its radius by which a body keeps off walls on its way from an entrance
ENTRANCE_NEAR = 0.01  # of its radius: so far from that way an entrance may be, where a body touches walls
MOST_START_FAULTS = 100  # told at once; whoever mends them hears of the rest
_STARTS_AT_ONCE = 256


def start_faults(area: MultiPolygon, blocking: Sequence[MultiPolygon], fleet: Fleet) -> list[tuple[str, str]]:
    """What is wrong with the fleet's entrances, rally points and starts: the field at fault and a message.

    A body must stand in the area and out of the shapes that block motion, and bodies apart; a box must have room for a
    centre. Every robot's body must fit into every entrance, and have room to move on from there, and onto every rally
    point.
    """
    placed: list[tuple[str, Place, float]] = []
    faults: list[tuple[str, str]] = []
    if isinstance(fleet.start, StartPoints):
        for k, point in enumerate(fleet.start.points_m):
            placed.append((f"fleet.start.points[{k}]", point, fleet.body_radius_m))
    if isinstance(fleet.start, StartBox):
        room = box(*fleet.start.low_m, *fleet.start.high_m).intersection(area)
        if room.is_empty or room.difference(union_all(blocking)).is_empty:
            faults.append(("fleet.start.box", "lies outside the area or in obstacles; must overlap the free space"))
    widest_m = max(robot.body_radius_m for robot in fleet.unlike_robots)
    for k, entrance in enumerate(fleet.entrances or ()):
        wrong = entrance_fault(entrance, widest_m, area, blocking)
        if wrong is not None:
            faults.append((f"fleet.entrances[{k}]", f"[{entrance[0]:.9g}, {entrance[1]:.9g}] {wrong}"))
    for k, place in enumerate(fleet.rally_points):
        wrong = standing_fault(place, widest_m, area, blocking)
        if wrong is not None:
            faults.append((f"fleet.rally_points[{k}]", f"[{place[0]:.9g}, {place[1]:.9g}] {wrong}"))
    for k, robot in enumerate(fleet.robots or ()):
        if robot.start is not None:
            placed.append((f"fleet.robots[{k}].start", robot.start, robot.body_radius_m))
    for i, others in _doubtful(placed, area, blocking):
        where, point, body_m = placed[i]
        wrong = standing_fault(point, body_m, area, blocking)
        for other, beside, its_body_m in (placed[j] for j in others):
            if wrong is None and math.dist(point, beside) < max(body_m + its_body_m - TOUCH_M, TOUCH_M):
                need_m = body_m + its_body_m
                gap_m = math.dist(point, beside)
                wrong = f"is {gap_m:.6g} m from {other}; bodies need {need_m:.6g} m, and no two may be equal"
        if wrong is not None:
            faults.append((where, f"[{point[0]:.9g}, {point[1]:.9g}] {wrong}"))
        if len(faults) == MOST_START_FAULTS:
            break
    return faults


def entrance_fault(
    place_m: Place, body_radius_m: float, area: MultiPolygon, blocking: Sequence[MultiPolygon]
) -> str | None:
    """Why a body cannot come in there: it does not fit, or has no way on; None when it can."""
    wrong = standing_fault(place_m, body_radius_m, area, blocking)
    return wrong or _why_stuck(place_m, body_radius_m, area, blocking)


def _doubtful(
    placed: list[tuple[str, Place, float]], area: MultiPolygon, blocking: Sequence[MultiPolygon]
) -> Iterator[tuple[int, list[int]]]:
    """The starts that may be at fault, in their order, each with those before it that its body may touch.

    Trees and prepared shapes find them, so that ten thousand starts take no longer than to write them down.
    """
    points = np.array([point for _, point, _ in placed], dtype=np.float64).reshape(-1, 2)
    bodies_m = np.array([body_m for _, _, body_m in placed], dtype=np.float64)
    known = np.isfinite(points).all(axis=1)
    points[~known] = 0.0
    shapely.prepare(area)
    border = area.boundary
    shapely.prepare(border)
    there = shapely.points(points)
    doubtful = ~known | ~shapely.covers(area, there) | shapely.dwithin(border, there, bodies_m)
    if blocking:
        doubtful[shapely.STRtree(blocking).query(there, predicate="dwithin", distance=bodies_m)[0]] = True
    rooms = shapely.box(*(points - bodies_m[:, None] - TOUCH_M).T, *(points + bodies_m[:, None] + TOUCH_M).T)
    tree = shapely.STRtree(rooms)
    # in parts, since a crowd in one place has as many pairs as the square of its number
    for begin in range(0, len(placed), _STARTS_AT_ONCE):
        part = np.arange(begin, min(begin + _STARTS_AT_ONCE, len(placed)))
        one, other = tree.query(rooms[part])
        before = other < one + begin
        one, other = one[before] + begin, other[before]
        for i in part:
            others = np.sort(other[one == i]).tolist()
            if doubtful[i] or others:
                yield int(i), others


def standing_fault(
    place_m: Place, body_radius_m: float, area: MultiPolygon, blocking: Sequence[MultiPolygon]
) -> str | None:
    """Why a body cannot stand with its centre there; None when it can."""
    if not all(abs(value) <= LARGEST_M for value in place_m):
        return f"is not allowed; {COORDINATES}"
    point = Point(place_m)
    if not area.covers(point):
        return f"lies {area.distance(point):.6g} m outside the area; it must be in the free space"
    if area.boundary.distance(point) < body_radius_m - TOUCH_M:
        gap_m = area.boundary.distance(point)
        return f"is {gap_m:.6g} m from the area's border; a body of radius {body_radius_m:.6g} m does not fit there"
    for shape in blocking:
        if shape.contains(point):
            return "lies in an obstacle; it must be in the free space"
        if shape.distance(point) < body_radius_m - TOUCH_M:
            gap_m = shape.distance(point)
            return f"is {gap_m:.6g} m from an obstacle; a body of radius {body_radius_m:.6g} m does not fit there"
    return None


def _why_stuck(
    place_m: Place, body_radius_m: float, area: MultiPolygon, blocking: Sequence[MultiPolygon]
) -> str | None:
    """Why a body that can stand there comes nowhere, as in a gap just as wide as itself; None when it can move on."""
    point, clear_m = Point(place_m), body_radius_m * (1 + ENTRANCE_CLEARANCE)
    near_m = ENTRANCE_NEAR * body_radius_m + 2 * TOUCH_M
    sides = [area.boundary, *(shape.boundary for shape in blocking)]
    if body_radius_m == 0 or all(side.distance(point) >= clear_m for side in sides):
        return None
    around = point.buffer(3 * clear_m)
    walls = union_all([shape for shape in (side.intersection(around) for side in sides) if not shape.is_empty])
    room = around.buffer(-clear_m).difference(walls.buffer(clear_m, quad_segs=128))
    if room.distance(point) <= near_m:
        return None
    return f"leaves a body of radius {body_radius_m:.6g} m no way on; gaps must be wider than it by 0.1 %"

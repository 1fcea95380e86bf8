"""Ground that no robot of a swarm can come to, and the doors that are too narrow for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely
from shapely import MultiPolygon, Point
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import free_ground
from rota.model.plan import Plan

SPOT = 0.1  # of the smallest sensor's radius: a disc of it is too little ground to be told of
HALVINGS = 20  # of a door's width
NARROWER, BEYOND = 0.98, 1.5  # of a door's width, and of what bodies that pass are smaller by: looking for its place
FIT = 1 - 1e-6  # of a body: what touches both sides of a door still passes


@dataclass(frozen=True, kw_only=True)
class Unreached:
    """A part of the ground that the smallest body cannot come to, in square metres.

    door_m, door_at_m: the width of the widest door to it, and where it is; None: there is no door.
    """

    area_m2: float
    door_m: float | None
    door_at_m: tuple[float, float] | None


def unreached_ground(plan: Plan) -> list[Unreached]:
    """The parts of the ground that no robot can come to from where it begins, the largest first."""
    robots = plan.mission.fleet.robots or ()
    ground = free_ground(plan.mission)
    body_m = FIT * min((robot.body_radius_m for robot in robots), default=0.0)
    spot_m2 = math.pi * (SPOT * min((robot.sensor.reach_m for robot in robots), default=0.0)) ** 2
    starts = [Point(trajectory.positions_m[0, :2]) for trajectory in plan]
    reached: list[BaseGeometry] = []
    found: list[BaseGeometry] = []
    for part in _rooms(ground, body_m):
        (reached if part.distance(shapely.MultiPoint(starts)) < 1e-6 else found).append(part)
    told = [_describe_part(part, reached, ground, body_m) for part in found if part.area > spot_m2] if reached else []
    return sorted(told, key=lambda part: -part.area_m2)


def _rooms(ground: MultiPolygon, body_m: float) -> list[BaseGeometry]:
    """Where the middle of a body may be, part by part."""
    return list(shapely.get_parts(ground.buffer(-body_m, join_style="mitre") if body_m > 0 else ground))


def _describe_part(part: BaseGeometry, reached: list[BaseGeometry], ground: MultiPolygon, body_m: float) -> Unreached:
    """What there is to tell of a part that is not reached."""
    area_m2 = part.buffer(body_m, join_style="mitre").intersection(ground).area if body_m > 0 else part.area
    others = shapely.union_all(reached)

    def is_joined(half_m: float) -> bool:
        """Whether a body of this radius comes from the one to the other."""
        return any(room.intersects(part) and room.intersects(others) for room in _rooms(ground, half_m))

    low, high = 0.0, body_m
    if body_m <= 0 or not is_joined(1e-6 * body_m):
        return Unreached(area_m2=area_m2, door_m=None, door_at_m=None)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_joined(middle) else (low, middle)
    place = _bridge(part, others, _rooms(ground, NARROWER * low), body_m - NARROWER * low)
    return Unreached(area_m2=area_m2, door_m=2 * low, door_at_m=place)


def _bridge(part: BaseGeometry, others: BaseGeometry, rooms: list[BaseGeometry], apart_m: float) -> tuple[float, float]:
    """The middle of what joins two parts in rooms for a body that is smaller by apart_m, and passes the door."""
    both = shapely.union_all([part, others]).buffer(BEYOND * apart_m)
    between = [
        piece
        for room in rooms
        if room.intersects(part) and room.intersects(others)
        for piece in shapely.get_parts(room.difference(both))
    ]
    if not between:
        place = shapely.shortest_line(part, others).centroid
    else:
        place = min(between, key=lambda piece: piece.distance(part) + piece.distance(others)).centroid
    return (place.x, place.y)

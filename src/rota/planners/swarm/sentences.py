"""What is said of robots that spread and hold, for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import MultiPolygon, Point, union_all
from shapely.geometry.base import BaseGeometry

from rota.cells.importance_cells import importance_in_range
from rota.geometry.free_space import free_ground, sight_walls
from rota.geometry.line_of_sight import visibility_polygon
from rota.model.plan import Plan
from rota.planning.plan_summary import range_at_the_end, range_from, round_off

SPOT = 0.1  # of the smallest sensor's radius: a disc of it is too little ground to be told of
HALVINGS = 20  # of a door's width
NARROWER, BEYOND = 0.98, 1.5  # of a door's width, and of what bodies that pass are smaller by: looking for its place
FIT = 1 - 1e-6  # of a body: what touches both sides of a door still passes
if TYPE_CHECKING:
    from rota.planning.planner import Report

TOLD = 5  # parts of the ground that cannot be reached


def holding_sentence(plan: Plan) -> str:
    """When robots that spread come to hold, how far they have gone by then, and whether they were cut off."""
    ways_m = [float(np.linalg.norm(np.diff(t.positions_m, axis=0), axis=1).sum()) for t in plan]
    n, last_s = len(plan.trajectories), max((trajectory.loop_start_s for trajectory in plan), default=0.0)
    robots = f"{n} robot" + ("s hold" if n != 1 else " holds")
    gone = f"{round_off(min(ways_m))} to {round_off(max(ways_m))} m" if n > 1 else f"{round_off(ways_m[0])} m"
    held = f"{robots} {round_off(last_s)} s after setting out, having gone {gone}"
    if plan.run_end is None or plan.run_end.at_rest:
        return f"{held}."
    return f"{held}: the run was {plan.run_end.text()}."


def loop_sentences(plan: Plan, report: Report) -> Iterator[str]:
    """Of robots that charge, from when on all repeats, how many are away at once, and what is in range meanwhile."""
    from rota.planning.charging_summary import charging_table

    first, n = plan.trajectories[0], len(plan.trajectories)
    begins_s = np.array([charge.from_s for one in plan for charge in one.charges])
    ends_s = np.array([charge.until_s for one in plan for charge in one.charges])
    most = int(((begins_s <= begins_s[:, None]) & (begins_s[:, None] < ends_s)).sum(axis=1).max())
    yield (
        f"From {round_off(first.loop_start_s)} s on all repeats every {round_off(first.loop_duration_s)} s:"
        f" {n} robot{'s leave' if n != 1 else ' leaves'} for a charger in turn and rejoin{'' if n != 1 else 's'},"
        f" and no more than {most} charge at once."
    )
    held = report.holding
    if held is not None and held.in_range_least_m2 is not None and held.in_range_mean_m2 is not None:
        least, mean = held.in_range_least_m2 / held.ground_m2, held.in_range_mean_m2 / held.ground_m2
        yield f"Of the area {mean:.1%} is then in range on average, and {least:.1%} at worst."
    yield charging_table(plan)


def covered_sentence(plan: Plan) -> str:
    """How much of the free space the holding robots have in range, and what footprints that share nothing would."""
    in_range, free, sum_m2 = range_at_the_end(plan)
    share, most = in_range.area / free.area, min(1.0, sum_m2 / free.area)
    seen = sight_at_the_end(plan)
    sight = "" if seen is None else f" and see {seen.intersection(free).area / free.area:.1%}, through no wall"
    told = f"They then have {share:.1%} of the area in range{sight}; footprints without overlap would have {most:.1%}."
    worth = importance_in_range(plan)
    return told if worth is None else f"{told} Of the ground's importance they have {worth:.1%} in range."


def reach_sentences(plan: Plan) -> Iterator[str]:
    """What of the ground no robot can come to, and which doors are too narrow."""
    whole_m2, body_m = free_ground(plan.mission).area, min(r.body_radius_m for r in plan.mission.fleet.robots or ())
    parts = unreached_ground(plan)
    for part in parts[:TOLD]:
        told = f"{round_off(part.area_m2)} m2, {part.area_m2 / whole_m2:.1%} of the ground, cannot be reached"
        if part.door_m is None or part.door_at_m is None:
            yield f"{told}: there is no door to it."
        else:
            x, y = part.door_at_m
            yield (
                f"{told}: the door at ({x:.2f}, {y:.2f}) is {part.door_m:.3g} m wide, and the smallest body"
                f" {2 * body_m:.3g} m."
            )
    if len(parts) > TOLD:
        rest_m2 = sum(part.area_m2 for part in parts[TOLD:])
        yield f"{len(parts) - TOLD} more parts, {round_off(rest_m2)} m2 together, cannot be reached."


def sight_at_the_end(plan: Plan) -> BaseGeometry | None:
    """What the robots see from their last places between what blocks sight, as a shape; None where nothing blocks."""
    walls_m, seen = sight_walls(plan.mission), []
    if not len(walls_m):
        return None
    for trajectory in plan:
        robot, place_m = plan.mission.fleet.robot(trajectory.robot), trajectory.positions_m[-1]
        footprint = range_from(robot.sensor, place_m)
        if robot.leaves_s is not None or footprint.is_empty:
            continue
        view = visibility_polygon(place_m[:2], walls_m, 1.5 * robot.sensor.reach_m)
        seen.append(view.intersection(footprint))
    return union_all(seen)


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

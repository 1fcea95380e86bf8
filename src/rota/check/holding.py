"""What robots of a swarm have in range, and see, where they hold or begin their loops, and ground that none can reach.

Only told, not judged: swarms are asked nothing of the ground unless it has a period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from rota.check.arrays import Floats
from rota.check.blocking import blocks_motion, blocks_sight
from rota.check.routes import lines_of, segments_of
from rota.check.standing import standing_area_of
from rota.check.tolerances import NO_LENGTH, SLIVER_M, TOUCH_M
from rota.model.mission import DiscSensor, ImportanceMap, Mission, Robot, Sensor
from rota.model.plan import Plan, Trajectory

PLACES = 2**19  # at which the ground is asked
STEPS = 64  # per quarter of a circle
SAME_AREA = math.sqrt(math.pi / (2 * STEPS * math.sin(math.pi / (2 * STEPS))))  # of a circle and a polygon round it
SHADOW_STEPS = 4  # of the far side of a wall's shadow, each of an eighth of a circle at most
MOMENTS = 240  # of a loop at which it is looked what is in range
SPOT = 0.1  # of the smallest sensor's reach: the radius of the least ground that is told of


@dataclass(frozen=True, kw_only=True)
class Holding:
    """Areas in square metres, of the ground that nothing keeps from being seen and of what robots have of it at last.

    seen_m2: of what they have in range, as far as no wall is between. ``unreached``: (x, y, area) of each part of the
    ground that no robot can come to from where it begins, the largest first; a place in it. importance_in_range: the
    share of the ground's importance in range; None where the mission states none. in_range_least_m2, in_range_mean_m2:
    of the longest loop, at MOMENTS of it; None where all robots stay. Robots at chargers have nothing in range.
    """

    ground_m2: float
    in_range_m2: float
    seen_m2: float
    unreached: tuple[tuple[float, float, float], ...]
    importance_in_range: float | None = None
    in_range_least_m2: float | None = None
    in_range_mean_m2: float | None = None


def holding_of(plan: Plan) -> Holding | None:
    """What robots hold in a plan by a planner that makes runs; None for other plans."""
    mission = plan.mission
    if not mission.planning.makes_runs:
        return None
    hidden = blocks_sight(mission.obstacles)
    ground = shapely.difference(mission.area, hidden)
    walls = segments_of(hidden)
    tree = shapely.STRtree(lines_of(walls))
    ranges, views = [], []
    for trajectory in plan:
        robot, place = mission.fleet.robot(trajectory.robot), trajectory.positions_m[-1]
        if robot.leaves_s is None and not _is_docked(trajectory, trajectory.times_s[-1]):
            ranges.append(in_range(robot, place))
            near = tree.query(ranges[-1])
            views.append(shapely.difference(ranges[-1], shadows(place[:2], walls[near], robot.sensor.reach_m)))
    least_m2, mean_m2 = _in_range_over_loop_m2(plan, ground)
    reached, seen = (shapely.intersection(shapely.union_all(shapes), ground) for shapes in (ranges, views))
    return Holding(
        ground_m2=ground.area,
        in_range_m2=reached.area,
        seen_m2=seen.area,
        unreached=tuple(_parts_out_of_reach(plan, mission)),
        importance_in_range=importance_in_range(mission, ground, reached),
        in_range_least_m2=least_m2,
        in_range_mean_m2=mean_m2,
    )


def _is_docked(trajectory: Trajectory, time_s: float) -> bool:
    """Whether a robot charges at a time of its way or of its first loop, the end of a charge included."""
    return any(charge.from_s <= time_s <= charge.until_s for charge in trajectory.charges)


def _in_range_over_loop_m2(plan: Plan, ground: Any) -> tuple[float | None, float | None]:
    """The least and the mean area in range of the ground over the longest loop."""
    if not any(trajectory.loop_duration_s for trajectory in plan):
        return None, None
    longest = max(plan, key=lambda one: one.loop_duration_s)
    areas_m2 = []
    for share in (np.arange(MOMENTS) + 0.5) / MOMENTS:
        time_s = longest.loop_start_s + share * longest.loop_duration_s
        shapes = [
            in_range(plan.mission.fleet.robot(one.robot), one.at(time_s))
            for one in plan
            if not _is_docked(one, _within_loop_s(one, time_s))
        ]
        areas_m2.append(shapely.intersection(shapely.union_all(shapes), ground).area)
    return float(np.min(areas_m2)), float(np.mean(areas_m2))


def _within_loop_s(trajectory: Trajectory, time_s: float) -> float:
    """The time of the trajectory at which the robot is as at a time of any loop."""
    late_s, lasts_s = time_s - trajectory.loop_start_s, trajectory.loop_duration_s
    return trajectory.loop_start_s + (late_s % lasts_s if lasts_s > 0 and late_s > 0 else min(late_s, 0.0))


def in_range(robot: Robot, place_m: Floats) -> Any:
    """What a robot at a place (2,) or (3,) has in range, walls aside; a disc as a polygon of the same area."""
    sensor, middle = robot.sensor, shapely.Point(place_m[:2])
    if not isinstance(sensor, DiscSensor):
        return shapely.buffer(middle, sensor.side_m / 2, cap_style="square")
    radius_m = sensor.radius_at_m(float(place_m[2]) if len(place_m) == 3 else 0.0)
    return shapely.buffer(middle, radius_m * SAME_AREA, quad_segs=STEPS)


def shadows(place_m: Floats, walls: Floats, reach_m: float) -> Any:
    """What walls (n, 4) hide from a place (2,) within a reach, as one shape.

    A wall that the place lies on hides nothing: what is behind it is hidden by the obstacle's other sides.
    """
    ends = walls.reshape(-1, 2, 2) - place_m
    angles, far_m = np.arctan2(ends[..., 1], ends[..., 0]), np.hypot(ends[..., 0], ends[..., 1])
    turn = np.remainder(angles[:, 0] - angles[:, 1] + math.pi, 2 * math.pi) - math.pi
    cross = np.abs(ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0])
    hides = (far_m.min(axis=1) > TOUCH_M) & (cross > max(NO_LENGTH, TOUCH_M**2)) & (np.abs(turn) < math.pi - 1e-9)
    if not hides.any():
        return shapely.Polygon()
    ends, angles, turn = ends[hides], angles[hides], turn[hides]
    beyond_m = 1.1 * np.maximum(reach_m, far_m[hides].max(axis=1)) / math.cos(math.pi / 8)
    way = angles[:, 1:] + turn[:, None] * np.linspace(0, 1, SHADOW_STEPS + 1)
    back = beyond_m[:, None, None] * np.stack([np.cos(way), np.sin(way)], axis=2)
    return shapely.union_all(shapely.polygons(np.concatenate([ends, back], axis=1) + place_m))


def _parts_out_of_reach(plan: Plan, mission: Mission) -> list[tuple[float, float, float]]:
    """The parts of the ground that no body covers from anywhere that it can come to: x, y of a place in it, area."""
    robots = [mission.fleet.robot(trajectory.robot) for trajectory in plan]
    if not robots:
        return []
    begins: dict[tuple[float, Sensor], tuple[Robot, list[Floats]]]
    begins = {(robot.body_radius_m, robot.sensor): (robot, []) for robot in robots}
    for robot, trajectory in zip(robots, plan, strict=True):
        begins[robot.body_radius_m, robot.sensor][1].append(trajectory.positions_m[0, :2])
    covered = []
    for (body_m, _), (robot, starts_m) in begins.items():
        rooms = shapely.get_parts(shapely.get_parts(np.atleast_1d(standing_area_of(mission, robot).shape)))
        own = rooms[shapely.dwithin(rooms, shapely.multipoints(np.array(starts_m)), 10 * TOUCH_M)]
        covered.append(shapely.buffer(shapely.union_all(own), body_m + SLIVER_M, join_style="mitre"))
    ground = shapely.difference(mission.area, blocks_motion(mission.obstacles))
    left = shapely.difference(ground, shapely.union_all(covered))
    parts = shapely.get_parts(shapely.buffer(shapely.buffer(left, -SLIVER_M), SLIVER_M, join_style="mitre"))
    least_m2 = math.pi * (SPOT * min(robot.sensor.reach_m for robot in robots)) ** 2
    told = [(shapely.point_on_surface(part), part.area) for part in parts if part.area > least_m2]
    return sorted(((place.x, place.y, area_m2) for place, area_m2 in told), key=lambda part: -part[2])


def importance_in_range(mission: Mission, ground: BaseGeometry, in_range: BaseGeometry) -> float | None:
    """The share of a ground's importance that lies in a shape, by places of a lattice; None where none is stated.

    A zone's importance replaces the ground's, a number or a map that goes straight between its places; of several
    zones the largest counts. 0 where nothing is worth anything.
    """
    zones = [(zone.importance, zone.shape) for zone in mission.zones if zone.importance is not None]
    if mission.importance is None and not zones:
        return None
    left, bottom, right, top = shapely.bounds(ground)
    step_m = max(np.sqrt((right - left) * (top - bottom) / PLACES), max(right - left, top - bottom) / PLACES)
    x, y = (
        part.ravel()
        for part in np.meshgrid(
            np.arange(left + step_m / 2, right, step_m), np.arange(bottom + step_m / 2, top, step_m)
        )
    )
    shapely.prepare([ground, in_range, *(shape for _, shape in zones)])
    there = shapely.contains_xy(ground, x, y)
    x, y = x[there], y[there]
    worth, told = np.ones(len(x)), mission.importance
    if isinstance(told, ImportanceMap):
        (x0, y0), (across, up), (rows, columns) = told.low_m, told.step_m, told.values.shape
        i, j = np.clip((x - x0) / across, 0, columns - 1), np.clip((y - y0) / up, 0, rows - 1)
        west, south = np.floor(i).astype(int), np.floor(j).astype(int)
        east, north = np.ceil(i).astype(int), np.ceil(j).astype(int)
        below = told.values[south, west] + (i - west) * (told.values[south, east] - told.values[south, west])
        above = told.values[north, west] + (i - west) * (told.values[north, east] - told.values[north, west])
        worth = below + (j - south) * (above - below)
    elif told is not None:
        worth *= told
    if zones:
        largest = np.max([np.where(shapely.contains_xy(shape, x, y), value, -1.0) for value, shape in zones], axis=0)
        worth = np.where(largest >= 0, largest, worth)
    whole = float(worth.sum())
    return float(worth[shapely.contains_xy(in_range, x, y)].sum()) / whole if whole > 0 else 0.0

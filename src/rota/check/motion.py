"""Whether every leg can be driven: the body inside the area and out of obstacles, the speed, the turns."""

from __future__ import annotations

import functools
import math
import threading
from typing import Any, NamedTuple

import numpy as np
import shapely

from rota.check.accelerations import acceleration_violations
from rota.check.arrays import Floats
from rota.check.blocking import blocks_motion
from rota.check.distances import point_distances, segment_distances
from rota.check.report import MOST_PER_ROBOT, Violation, few_of_each_kind, violation
from rota.check.routes import lines_of, segments_of
from rota.check.timing_kernels import time_along
from rota.check.tolerances import FLOAT_EPS, SPEED_TOLERANCE, TOUCH_M
from rota.check.turning import turn_radius_violations, turn_violations
from rota.model.mission import Mission, Robot
from rota.model.plan import Plan, Trajectory
from rota.model.violation_kinds import ViolationKind

_ONE_AT_A_TIME = threading.Lock()
MOST_PAIRS = 2_000_000  # of legs and sides that are looked at together


def motion_violations(plan: Plan) -> list[Violation]:
    """Everything wrong with the motion of each robot by itself, at most 20 of a kind for each robot."""
    mission = plan.mission
    area, blocked = _border_of(mission.area), _border_of(blocks_motion(mission.obstacles))
    violations: list[Violation] = []
    under_way = () if plan.seam is None else {driven.robot for driven in plan.seam.driven}
    out_of_area, into_obstacles = _deepest_of_all(plan, area, False), _deepest_of_all(plan, blocked, True)
    for k, trajectory in enumerate(plan):
        robot = mission.fleet.robot(trajectory.robot)
        violations += _place_violations(trajectory, robot, out_of_area[k], "outside area")
        violations += _place_violations(trajectory, robot, into_obstacles[k], "obstacle")
        violations += speed_violations(trajectory, robot)
        violations += few_of_each_kind(turn_violations(trajectory, robot))
        if trajectory.robot not in under_way:  # of those that were, seam_violations tells with what they drove before
            violations += few_of_each_kind(acceleration_violations(trajectory, robot))
            violations += few_of_each_kind(turn_radius_violations(trajectory, robot))
        violations += altitude_violations(trajectory, robot, mission)
    return violations


def altitude_violations(trajectory: Trajectory, robot: Robot, mission: Mission) -> list[Violation]:
    """Timed points more than 1e-6 m out of the altitudes that a swarm's mission allows, or without a height.

    Of several bands a robot keeps to the one that it begins in, or nearest to. Straight legs between points in a band
    stay in it; bands that touch are one.
    """
    if mission.planning.altitudes_m is None:
        return []
    places = trajectory.positions_m
    z = places[:, 2] if places.shape[1] == 3 else np.zeros(len(places))
    low, high = _band_round(float(z[0]), mission.planning.altitudes_m)
    violations = []
    kinds: tuple[ViolationKind, ViolationKind] = ("below altitudes", "above altitudes")
    for kind, out, limit in zip(kinds, (z < low - TOUCH_M, z > high + TOUCH_M), (low, high), strict=True):
        for m in np.flatnonzero(out)[:MOST_PER_ROBOT]:
            x, y = places[m, :2]
            violations.append(
                violation(kind, robot.name, (x, y), float(trajectory.times_s[m]), float(z[m]), limit, "m")
            )
    return violations


def _band_round(height_m: float, altitudes_m: tuple[float, ...]) -> tuple[float, float]:
    """The band of altitudes, bands that touch as one, that a height lies in or nearest to."""
    bands: list[tuple[float, float]] = []
    for low, high in zip(altitudes_m[::2], altitudes_m[1::2], strict=True):
        if bands and low <= bands[-1][1]:
            bands[-1] = (bands[-1][0], high)
        else:
            bands.append((low, high))
    return min(bands, key=lambda band: max(band[0] - height_m, height_m - band[1]))


class _Border(NamedTuple):
    """A shape, its sides (s, 4), and a tree of them."""

    shape: Any
    sides: Floats
    tree: Any


def _border_of(shape: Any) -> _Border:
    """The border of the area, or of what blocks motion, made ready for all robots and for the next plans."""
    with _ONE_AT_A_TIME:
        return _ready_border(shape)


@functools.lru_cache(maxsize=4)
def _ready_border(shape: Any) -> _Border:
    """The same, made anew.

    A prepared shape builds an index when it is first asked about a point. Several threads must not do that at once.
    """
    sides = segments_of(shape)
    shapely.prepare(shape)
    shapely.contains(shape, shapely.centroid(shapely.envelope(shape)))
    return _Border(shape, sides, shapely.STRtree(lines_of(sides)))


class _Deepest(NamedTuple):
    """Depth (m,) in metres to which a body enters the wrong side of a border on each leg, and where, (m,) in 0..1."""

    depth_m: Floats
    place: Floats


def _legs_of(trajectory: Trajectory) -> Floats:
    """The legs (m, 4) of a trajectory; one of no length for a robot that stays."""
    xy = trajectory.positions_m[:, :2]
    return np.hstack([xy[:-1], xy[1:]]) if len(xy) > 1 else np.hstack([xy, xy])


def _deepest_of_all(plan: Plan, border: _Border, wrong_inside: bool) -> list[_Deepest]:
    """How deep the bodies go on the legs of each trajectory; a leg that several drive is looked at once."""
    found: list[_Deepest] = [_Deepest(np.zeros(0), np.zeros(0))] * len(plan.trajectories)
    if not len(border.sides):
        return found
    bodies_m = [plan.mission.fleet.robot(trajectory.robot).body_radius_m for trajectory in plan]
    at_once = max(1, MOST_PAIRS // len(border.sides))
    for body_m in dict.fromkeys(bodies_m):
        own = [k for k, other_m in enumerate(bodies_m) if other_m == body_m]
        legs = [_legs_of(plan.trajectories[k]) for k in own]
        rows, which = np.unique(np.vstack(legs), axis=0, return_inverse=True)
        judged = [_deepest(rows[k : k + at_once], border, wrong_inside, body_m) for k in range(0, len(rows), at_once)]
        depth, place = (np.concatenate(values)[which.ravel()] for values in zip(*judged, strict=True))
        ends = np.cumsum([len(some) for some in legs])[:-1]
        for k, deep, at in zip(own, np.split(depth, ends), np.split(place, ends), strict=True):
            found[k] = _Deepest(deep, at)
    return found


def _place_violations(trajectory: Trajectory, robot: Robot, deepest: _Deepest, kind: ViolationKind) -> list[Violation]:
    """Legs on which the body reaches more than 1e-6 m out of the area (kind "outside area") or into an obstacle.

    Each leg has one violation: its deepest place, when and how deep. Where the centre itself is on the wrong side, the
    deepest of 65 places along the stretch counts, refined three times.
    """
    legs, times, bends, violations = _legs_of(trajectory), trajectory.times_s, trajectory.bends, []
    for m in np.flatnonzero(deepest.depth_m > TOUCH_M)[:MOST_PER_ROBOT]:
        at = deepest.place[m]
        x, y = legs[m, :2] + at * (legs[m, 2:] - legs[m, :2])
        time = time_along(times[m], times[min(m + 1, len(times) - 1)], bends[m] if len(bends) else 0.0, at)
        violations.append(violation(kind, robot.name, (x, y), time, float(deepest.depth_m[m]), TOUCH_M, "m"))
    return violations


def _deepest(legs: Floats, border: _Border, wrong_inside: bool, body_m: float) -> tuple[Floats, Floats]:
    """Depth (m,) in metres to which the body enters the wrong side of the border on each leg, and where, (m,) in 0..1.

    legs: (m, 4). wrong_inside: whether the shape is the wrong side.
    """
    shape, sides, tree = border
    leg, side = tree.query(lines_of(legs), predicate="dwithin", distance=body_m + 2 * TOUCH_M)
    depth, place = np.full(len(legs), -math.inf), np.zeros(len(legs))
    distance, along = segment_distances(legs[leg], sides[side])
    order = np.argsort(distance, kind="stable")[::-1]
    depth[leg[order]] = body_m - distance[order]
    place[leg[order]] = along[order]
    starts = shapely.points(legs[:, :2])
    inside = shapely.contains(shape, starts) if wrong_inside else shapely.covers(shape, starts)
    suspect = (inside == wrong_inside) | (np.bincount(leg[distance <= TOUCH_M], minlength=len(legs)) > 0)
    for m in np.flatnonzero(suspect):
        deep, at = _centre_depth(legs[m], sides[side[leg == m]], border, wrong_inside, TOUCH_M - body_m)
        if deep > 0 and body_m + deep > depth[m]:
            depth[m], place[m] = body_m + deep, at
    return depth, place


def _centre_depth(
    leg: Floats, near: Floats, border: _Border, wrong_inside: bool, allowed_m: float
) -> tuple[float, float]:
    """Largest depth in metres of the centre on the wrong side along a leg (4,), and where in 0..1; 0: never there.

    near: (s, 4) sides of the border near the leg. Stretches surely no deeper than ``allowed_m`` are not looked at.
    """
    start, along = leg[:2], leg[2:] - leg[:2]
    stops = [0.0, 1.0]
    if len(near) and along.any():
        across, offset = near[:, 2:] - near[:, :2], near[:, :2] - start
        turn = along[0] * across[:, 1] - along[1] * across[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (offset[:, 0] * across[:, 1] - offset[:, 1] * across[:, 0]) / turn
        ends = np.concatenate([((near[:, k : k + 2] - start) @ along) / (along @ along) for k in (0, 2)])
        crossings = np.concatenate([u[turn != 0], ends])
        stops += list(crossings[(crossings > 0) & (crossings < 1)])
    knots = np.unique(stops)
    middles = shapely.points(start + ((knots[1:] + knots[:-1]) / 2)[:, None] * along)
    inside = shapely.contains(border.shape, middles) if wrong_inside else shapely.covers(border.shape, middles)
    best, where = 0.0, 0.0
    wrong = np.flatnonzero(inside == wrong_inside)
    if allowed_m > 0 and len(near) and len(wrong):
        wrong = wrong[_least_sag(start + knots[:, None] * along, near)[wrong] > allowed_m / 2]
    for k in wrong:
        low, high = knots[k], knots[k + 1]
        for _ in range(4):
            spots = np.linspace(low, high, 65)
            points = shapely.points(start + spots[:, None] * along)
            _, distance = border.tree.query_nearest(points, return_distance=True, all_matches=False)
            deepest = int(np.argmax(distance))
            low, high = spots[max(deepest - 1, 0)], spots[min(deepest + 1, 64)]
            if distance[deepest] > best:
                best, where = float(distance[deepest]), float(spots[deepest])
    return best, where


def _least_sag(places: Floats, sides: Floats) -> Floats:
    """For each stretch between neighbouring places (n + 1, 2) how far off the sides (s, 4) any of it can be: (n,).

    Distance from one side is a convex function of the place, so that it is greatest at an end of the stretch; of all
    sides the nearest one counts.
    """
    count = len(sides)
    each = np.repeat(places, count, axis=0), np.tile(sides[:, :2], (len(places), 1))
    away = point_distances(*each, np.tile(sides[:, 2:] - sides[:, :2], (len(places), 1)))[0].reshape(-1, count)
    least: Floats = np.maximum(away[:-1], away[1:]).min(axis=1)
    return least


def speed_violations(trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Legs faster than the robot by more than 1e-9 of its speed and what float64 times and places can express.

    Of a leg with an acceleration the faster end counts. What the wind leaves of an airspeed, no robot's speed exceeds.
    What a leg may be too short in time does not add up: no row of legs, however many, is farther ahead of the robot's
    speed than 1e-6 m or than the rounding of its two ends in time, whichever is more. Of several rows one is told.
    """
    top_m_s = robot.speed_m_s
    steps = np.diff(trajectory.positions_m, axis=0)
    length, time = np.sqrt((steps**2).sum(axis=1)), np.diff(trajectory.times_s)
    fastest_m = length * (1 + np.abs(trajectory.bends))  # what a leg's time is enough for at its fastest speed
    noise_m = 4 * FLOAT_EPS * np.abs(trajectory.positions_m).max()
    with np.errstate(over="ignore", invalid="ignore"):  # the fastest robots may go anywhere at once
        most = top_m_s * time * (1 + SPEED_TOLERANCE) + noise_m
        grain_m = top_m_s * 2 * FLOAT_EPS * trajectory.times_s[1:]
        rows = [(m, m + 1) for m in np.flatnonzero(fastest_m > most + grain_m)[:MOST_PER_ROBOT]]
        rows = rows or row_ahead(length - most, np.maximum(grain_m, TOUCH_M))
    violations = []
    for m, end in rows:
        x, y = trajectory.positions_m[m, :2]
        value = float((fastest_m if end == m + 1 else length)[m:end].sum() / time[m:end].sum())
        when = float(trajectory.times_s[m])
        violations.append(violation("speed", robot.name, (x, y), when, value, top_m_s, "m/s"))
    return violations


def row_ahead(ahead_m: Floats, allowed_m: Floats) -> list[tuple[int, int]]:
    """The first row of legs, (from, to), that is farther ahead than allowed at its end; none: no row is.

    ahead_m, allowed_m: (m,) by how much each leg is longer than its time allows, and how much a row that ends with it
    may be. A leg that falls behind by more than any row may be ahead ends all rows; the sums stay small and exact.
    """
    if not len(ahead_m):
        return []
    ahead_m = np.maximum(ahead_m, -2 * allowed_m.max())
    sums = np.concatenate([[0.0], np.cumsum(ahead_m)])
    too_far = np.flatnonzero(sums[1:] - np.minimum.accumulate(sums)[:-1] > allowed_m)
    if not len(too_far):
        return []
    end = int(too_far[0]) + 1
    return [(int(np.argmin(sums[:end])), end)]

"""Robots on a ring, so that what a change comes to is known, and what time sampling says of a plan that takes over."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from rota import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, Plan, Robot, SquareSensor, Trajectory

Floats = NDArray[np.float64]

ROUND_S = 40.0  # a ring of 10 m x 10 m at 1 m/s
CORNERS_M = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], float)


def ring_mission(period_s: float, names: tuple[str, ...], **of_fleet: object) -> Mission:
    """A corridor 0.6 m wide round a block."""
    told: dict[str, object] = {"speed_m_s": 1, "sensor": DiscSensor(radius_m=1.2), **of_fleet}
    fleet = Fleet(robots=[Robot(name=name) for name in names], **told)  # type: ignore[arg-type]
    block = Obstacle(shape=shapely.MultiPolygon([shapely.box(0.3, 0.3, 9.7, 9.7)]))
    area = shapely.MultiPolygon([shapely.box(-0.3, -0.3, 10.3, 10.3)])
    settings = PatrolSettings(effort="quick")
    return Mission(name="ring", area=area, obstacles=(block,), period_s=period_s, fleet=fleet, planning=settings)


def on_the_ring(name: str, ahead_m: float) -> Trajectory:
    """A robot that is so far round the ring when the plan begins."""
    stops = np.unique(np.append((np.arange(0, 50, 10.0) - ahead_m) % 40, [0.0, 40.0]))
    places = np.column_stack([np.interp((stops + ahead_m) % 40, np.arange(0, 50, 10.0), axis) for axis in CORNERS_M.T])
    places[-1] = places[0]
    return Trajectory(robot=name, times_s=stops, positions_m=places)


def ring_plan(period_s: float, ahead_m: dict[str, float], **of_fleet: object) -> Plan:
    """Robots that go round the ring in one direction, each so far ahead."""
    robots = tuple(on_the_ring(name, metres) for name, metres in ahead_m.items())
    return Plan(mission=ring_mission(period_s, tuple(ahead_m), **of_fleet), trajectories=robots)


class Sampled:
    """What looking at all robots every so often says: by how much places are late, until when, how near bodies come.

    more_m: sensors see so much farther, so that a sight of a moment, as at the very end of their reach, is not missed.
    """

    def __init__(self, plan: Plan, points_m: Floats, step_s: float, until_s: float, *, more_m: float = 0.0) -> None:
        assert plan.seam is not None
        self.until_s = until_s
        periods_s = np.array([period_at(plan.mission, point) for point in points_m])
        walls = [one.shape for one in plan.mission.obstacles if one.blocks_sight]
        solid = shapely.union_all(walls) if walls else None
        since_s = plan.seam.since_s
        covered = np.full(len(points_m), since_s)
        self.worst_s, self.last_s, self.nearest_m = 0.0, 0.0, np.inf
        for now in np.arange(since_s, until_s, step_s):
            if now < 0:
                seen = [
                    (one.sensor, driven_place(one, float(now))) for one in plan.seam.driven if now >= one.times_s[0]
                ]
            else:
                places = [trajectory_place(one, float(now)) for one in plan]
                seen = [(plan.mission.fleet.robot(one.robot).sensor, at) for one, at in zip(plan, places, strict=True)]
                gaps = [np.hypot(*(a - b)) for k, a in enumerate(places) for b in places[:k]]
                self.nearest_m = min([self.nearest_m, *gaps])
            for sensor, at in seen:
                covered[in_sight(points_m, sensor, at, solid, more_m)] = now
            over_s = now - covered - periods_s
            if now >= 0 and over_s.max(initial=0.0) > step_s:
                self.worst_s = max(self.worst_s, float(over_s.max()))
                self.last_s = float(now)


def in_sight(
    points_m: Floats, sensor: DiscSensor | SquareSensor, at: Floats, solid: object, more_m: float
) -> NDArray[np.int64]:
    """The points that a robot sees from a place."""
    away = points_m - at
    if isinstance(sensor, DiscSensor):
        near = np.flatnonzero(np.hypot(*away.T) <= sensor.radius_m + more_m)
    else:
        near = np.flatnonzero(np.abs(away).max(axis=1) <= sensor.side_m / 2 + more_m)
    if solid is None or not len(near):
        return near
    lines = shapely.linestrings(np.stack([np.broadcast_to(at, (len(near), 2)), points_m[near]], axis=1))
    hidden = shapely.length(shapely.intersection(lines, solid)) > 1e-6
    return near[~hidden]


def period_at(mission: Mission, point: Floats) -> float:
    """The period that holds at a point: the least of the zones there, else the area's."""
    here = [zone.period_s for zone in mission.zones if shapely.intersects_xy(zone.shape, *point)]
    if not here:
        return mission.period_s or np.inf
    return min(period for period in here if period is not None)


def driven_place(driven: object, now_s: float) -> Floats:
    return np.array([np.interp(now_s, driven.times_s, driven.positions_m[:, axis]) for axis in (0, 1)])  # type: ignore[attr-defined]


def trajectory_place(one: Trajectory, now_s: float) -> Floats:
    if one.times_s[-1] > one.loop_start_s and now_s > one.loop_start_s:
        now_s = one.loop_start_s + (now_s - one.loop_start_s) % (one.times_s[-1] - one.loop_start_s)
    return np.array([np.interp(now_s, one.times_s, one.positions_m[:, axis]) for axis in (0, 1)])


def points_in(mission: Mission, spacing_m: float) -> Floats:
    """A lattice over the ground that is asked for, borders included."""
    walls = [one.shape for one in mission.obstacles if one.blocks_sight]
    ground = mission.area.difference(shapely.union_all(walls)) if walls else mission.area
    x0, y0, x1, y1 = ground.bounds
    axes = [np.linspace(low, high, round((high - low) / spacing_m) + 1) for low, high in ((x0, x1), (y0, y1))]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return np.asarray(points[shapely.intersects_xy(ground, *points.T)])

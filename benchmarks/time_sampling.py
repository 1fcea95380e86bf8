"""What looking at all robots every so often says of a plan that takes over: no intervals, none of the check's code."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.model.mission import DiscSensor, Mission, Sensor
from rota.model.plan import Driven, Plan, Trajectory

Floats = NDArray[np.float64]

HIDDEN_M = 1e-6  # of a line of sight in what blocks it


class Sampled:
    """By how much points (n, 2) are late from the change on, until when, and how near the middles of bodies come.

    more_m: sensors see so much farther, so that a sight of a moment, as at the very end of their reach, is not missed.
    periods_s: (n,) of the points; None: those that hold there. late_s: (n,) of each point.
    """

    def __init__(
        self,
        plan: Plan,
        points_m: Floats,
        step_s: float,
        until_s: float,
        *,
        more_m: float = 0.0,
        periods_s: Floats | None = None,
    ) -> None:
        assert plan.seam is not None
        since_s = plan.seam.since_s
        before, after = np.arange(since_s, 0.0, step_s), np.arange(0.0, until_s, step_s)
        times_s = np.concatenate([before, after])
        seen = np.zeros((len(times_s), len(points_m)), np.bool_)
        for driven in plan.seam.driven:
            own = np.flatnonzero(before >= driven.times_s[0])
            own = own[[not any(one.from_s <= now_s < one.until_s for one in driven.charges) for now_s in before[own]]]
            at_m = places_driven(driven, before[own])
            seen[own] |= sights(points_m, driven.sensor, at_m, plan.mission, more_m)
        ways = [places_along(line, after) for line in plan]
        for line, at_m in zip(plan, ways, strict=True):
            sensor = plan.mission.fleet.robot(line.robot).sensor
            away = np.flatnonzero(~docked_along(line, after))
            seen[len(before) + away] |= sights(points_m, sensor, at_m[away], plan.mission, more_m)
        last_seen_s = np.maximum.accumulate(np.where(seen, times_s[:, None], since_s), axis=0)
        if periods_s is None:
            periods_s = np.array([period_at(plan.mission, point) for point in points_m])
        over_s = (times_s[:, None] - last_seen_s - periods_s)[len(before) :]
        self.late_s = np.maximum(0.0, over_s.max(axis=0, initial=0.0))
        self.worst_s = float(self.late_s.max(initial=0.0))
        late = np.flatnonzero((over_s > step_s).any(axis=1)) if len(points_m) else np.zeros(0, np.int64)
        self.last_s = float(after[late[-1]]) if len(late) else 0.0
        if self.worst_s <= step_s:
            self.worst_s = 0.0
        gaps_m = [np.hypot(*(a - b).T).min() for k, a in enumerate(ways) for b in ways[:k]]
        self.nearest_m = float(min(gaps_m, default=np.inf))


def sights(points_m: Floats, sensor: Sensor, at_m: Floats, mission: Mission, more_m: float) -> NDArray[np.bool_]:
    """Which of the points (n, 2) a robot sees from each of its places (t, 2): (t, n)."""
    away = points_m[None] - at_m[:, None]
    if isinstance(sensor, DiscSensor):
        near = np.hypot(away[..., 0], away[..., 1]) <= sensor.radius_m + more_m
    else:
        near = np.abs(away).max(axis=-1) <= sensor.side_m / 2 + more_m
    walls = [one.shape for one in mission.obstacles if one.blocks_sight]
    if walls and near.any():
        when, which = np.nonzero(near)
        lines = shapely.linestrings(np.stack([at_m[when], points_m[which]], axis=1))
        solid = shapely.union_all(walls)
        shapely.prepare(solid)
        doubt = np.flatnonzero(shapely.intersects(solid, lines))
        hidden = shapely.length(shapely.intersection(lines[doubt], solid)) > HIDDEN_M
        near[when[doubt[hidden]], which[doubt[hidden]]] = False
    return near


def period_at(mission: Mission, point: Floats) -> float:
    """The period that holds at a point: the least of the zones there that ask for every point, else the area's.

    Points on the border of a zone are not in it.
    """
    here = [zone for zone in mission.zones if shapely.contains_xy(zone.shape, *point)]
    asked = [zone.period_s for zone in here if zone.period_s is not None and zone.demand == "every_point"]
    if asked or here:
        return min(asked, default=np.inf)
    return mission.period_s or np.inf


def places_driven(driven: Driven, times_s: Floats) -> Floats:
    """Where a robot was (t, 2); it drove at constant speeds."""
    return np.column_stack([np.interp(times_s, driven.times_s, driven.positions_m[:, axis]) for axis in (0, 1)])


def first_round(line: Trajectory, times_s: Floats) -> Floats:
    """The times (t,) in its first round at which a robot does what it does at these."""
    begins_s, lasts_s = line.loop_start_s, float(line.times_s[-1]) - line.loop_start_s
    return np.where((times_s > begins_s) & (lasts_s > 0), begins_s + (times_s - begins_s) % (lasts_s or 1.0), times_s)


def docked_along(line: Trajectory, times_s: Floats) -> NDArray[np.bool_]:
    """Whether a robot is on a charger (t,), where it sees nothing; at its end it stays there for ever."""
    asked_s = np.minimum(first_round(line, times_s), np.nextafter(line.times_s[-1], 0))
    return np.array([any(one.from_s <= now_s < one.until_s for one in line.charges) for now_s in asked_s], np.bool_)


def places_along(line: Trajectory, times_s: Floats) -> Floats:
    """Where a robot is (t, 2); it drives at constant speeds."""
    asked_s = first_round(line, times_s)
    return np.column_stack([np.interp(asked_s, line.times_s, line.positions_m[:, axis]) for axis in (0, 1)])


def lattice(mission: Mission, spacing_m: float) -> Floats:
    """Points (n, 2) over the ground that is asked for, so far apart, borders included."""
    walls = [one.shape for one in mission.obstacles if one.blocks_sight or one.asks == "nothing"]
    ground = mission.area.difference(shapely.union_all(walls)) if walls else mission.area
    x0, y0, x1, y1 = ground.bounds
    axes = [np.linspace(low, high, max(1, round((high - low) / spacing_m)) + 1) for low, high in ((x0, x1), (y0, y1))]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return np.asarray(points[shapely.intersects_xy(ground, *points.T)])

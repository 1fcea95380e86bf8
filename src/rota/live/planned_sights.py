"""When robots see places by plan, in closed form as the check has it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.check.counting import Names, counts
from rota.check.demands import DemandedGround, visits
from rota.check.revisits import Sights, sights_of
from rota.check.routes import HOLD, LOOP
from rota.check.timing_kernels import time_along
from rota.live import kernels
from rota.live.kernels import PlannedSights
from rota.model.arrays import Floats, Ints
from rota.model.mission import Sensor
from rota.model.plan import Plan

Sight = tuple[int, float, float, bool]


def sights_of_plan(plan: Plan, points_m: Floats, demand: Ints, demands: Sequence[DemandedGround]) -> PlannedSights:
    """When robots that count for it see each place by plan, and are inside each of the demands to visit.

    points_m: (m, 2); demand: (n,) index of the demand of each, and then of those to visit, one each.
    """
    regions = [each.region for each in demands if each.demand == "visit"]
    sights = sights_by_plan(sights_of(plan, plan.mission.area.bounds), points_m, regions)
    sensors = [plan.mission.fleet.robot(way.robot).sensor for way in plan]
    return counting_sights(sights, sensors, demand, [each.sensors for each in demands])


def counting_sights(
    sights: PlannedSights, sensors: Sequence[Sensor], demand: Ints, names: Sequence[Names]
) -> PlannedSights:
    """The sights of n places without those by robots that do not count for them.

    sensors: of the robots. demand: (n,) of each place; names: of the sensors that count for each demand.
    """
    if not any(names):
        return sights
    count = np.array([[counts(sensor, own) for sensor in sensors] for own in names], np.bool_)
    kept = count[np.repeat(demand, np.diff(sights.offsets)), sights.robots]
    before = np.concatenate([[0], np.cumsum(kept)])
    columns = (sights.robots[kept], sights.starts_s[kept], sights.ends_s[kept], sights.again[kept])
    return PlannedSights(before[sights.offsets], *columns)


def sights_by_plan(sights: Sights, points_m: Floats, regions: Sequence[Any] = ()) -> PlannedSights:
    """When each of ``points_m`` (n, 2) is seen, then when robots are inside each of the ``regions`` to visit."""
    points = np.ascontiguousarray(points_m - sights.origin_m)
    arrays = kernels.planned_sights(points, sights.slack_m, sights.grid, sights.legs, sights.team, sights.walls)
    rows = [_visits(sights, region) for region in regions]
    offsets, *columns = arrays
    ends = offsets[-1] + np.cumsum([len(row) for row in rows], dtype=np.int64)
    flat = [sight for row in rows for sight in row]
    kinds = (np.int64, np.float64, np.float64, np.bool_)
    added: list[NDArray[Any]] = [np.array([sight[k] for sight in flat], kind) for k, kind in enumerate(kinds)]
    joined = [np.concatenate(pair) for pair in zip(columns, added, strict=True)]
    return PlannedSights(np.concatenate([offsets, ends]), *joined)


def _visits(sights: Sights, region: object) -> list[Sight]:
    """When robots are in a region by plan: robot, start, end and whether it repeats."""
    routes = sights.routes
    found: list[Sight] = []
    for leg, lo, hi in visits(routes.legs_m, region, sights.slack_m):
        start, end = (float(time_along(*routes.times_s[leg], routes.bends[leg], share)) for share in (lo, hi))
        end = math.inf if routes.kinds[leg] == HOLD else end
        row = (int(routes.robots[leg]), start, end, bool(routes.kinds[leg] == LOOP))
        before = found[-1] if found else None
        if before and before[0] == row[0] and before[3] == row[3] and row[1] <= before[2] + kernels.SAME_S:
            found[-1] = (row[0], before[1], max(before[2], row[2]), row[3])
        else:
            found.append(row)
    return found

"""Ages of places as one writes them down first: from a playback's arrays, and by looking every few milliseconds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.model.mission import DiscSensor
from rota.model.plan import Plan

Floats = NDArray[np.float64]
Json = dict[str, Any]


def ages_s(
    header: Json, arrays: dict[str, NDArray[Any]], time_s: float, stops_s: dict[int, float] | None = None
) -> Floats:
    """(n,) time since each entry was last seen; inf: not yet. stops_s: when a robot of that number stops to see."""
    found = time_s - arrays.get("cell_before_s", np.full(len(arrays["cell_index"]), -math.inf))
    for entry in range(len(found)):
        for i in range(arrays["sight_offsets"][entry], arrays["sight_offsets"][entry + 1]):
            robot = header["robots"][arrays["sight_robot"][i]]
            until_s = min(
                time_s, (stops_s or {}).get(int(arrays["sight_robot"][i]), math.inf), robot["leaves_s"] or math.inf
            )
            start_s, end_s = float(arrays["sight_start_s"][i]), float(arrays["sight_end_s"][i])
            if until_s < start_s:
                continue
            if arrays["sight_loops"][i]:
                loop_s = robot["end_s"] - robot["loop_start_s"]
                rounds = math.floor((until_s - start_s) / loop_s)
                start_s, end_s = start_s + rounds * loop_s, end_s + rounds * loop_s
            found[entry] = min(found[entry], time_s - min(end_s, until_s))
    return found


def centres_m(header: Json, index: NDArray[Any]) -> Floats:
    """(n, 2) centres of cells."""
    grid = header["grid"]
    row, column = np.divmod(index.astype(np.int64), grid["columns"])
    return np.column_stack(
        [grid["x0_m"] + (column + 0.5) * grid["cell_m"], grid["y0_m"] + (row + 0.5) * grid["cell_m"]]
    )


def ages_looked_up_s(plan: Plan, points_m: Floats, time_s: float, step_s: float) -> Floats:
    """(n,) ages from looking at every ``step_s``: at most a step too old."""
    walls = shapely.union_all([obstacle.shape for obstacle in plan.mission.obstacles if obstacle.blocks_sight])
    shapely.prepare(walls)
    found = np.full(len(points_m), math.inf)
    for moment in np.arange(time_s, -step_s / 2, -step_s):
        for trajectory in plan:
            robot = plan.mission.fleet.robot(trajectory.robot)
            if not robot.joins_s <= moment <= (math.inf if robot.leaves_s is None else robot.leaves_s):
                continue
            place = trajectory.at([max(moment, 0.0)])[0]
            off = np.abs(points_m - place)
            disc = isinstance(robot.sensor, DiscSensor)
            near = np.hypot(*off.T) <= robot.sensor.radius_m if disc else off.max(axis=1) <= robot.sensor.side_m / 2
            fresh = np.flatnonzero(near & np.isinf(found))
            ends = np.broadcast_to(place, (len(fresh), 2))
            lines = shapely.linestrings(np.stack([ends, points_m[fresh]], axis=1))
            found[fresh[~shapely.crosses(walls, lines)]] = time_s - max(moment, 0.0)
        if np.isfinite(found).all():
            break
    return found

"""Plan -> CSV: a row for every timed point of every robot."""

from __future__ import annotations

import csv
import io

import numpy as np

from rota.files.geodesy import Projection
from rota.files.spreadsheet_cells import as_cell
from rota.model.plan import Plan, Trajectory


def csv_text(plan: Plan) -> str:
    """Columns robot, t_s, x_m, y_m, z_m, lat, lon, speed_m_s, acceleration_m_s2, in_loop; all digits, as they were.

    z_m is there when any robot has heights, and empty for robots without; lat and lon when the mission has an origin.
    speed_m_s and acceleration_m_s2 are there when any robot's legs have accelerations: those with which it leaves the
    point, and at its last one those with which it comes there.
    A robot's name that a spreadsheet would compute has an apostrophe before it.
    in_loop is 1 from ``loop_start_s`` on: those rows are repeated for ever, and the last of them is where the first one
    is. A robot that stays has one row with in_loop 1, its last.
    """
    has_heights = any(trajectory.positions_m.shape[1] == 3 for trajectory in plan)
    projection = Projection(plan.mission.origin) if plan.mission.origin is not None else None
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    speeds_change = plan.heeds_motion
    heights, degrees = ["z_m"] if has_heights else [], ["lat", "lon"] if projection else []
    motion = ["speed_m_s", "acceleration_m_s2"] if speeds_change else []
    writer.writerow(["robot", "t_s", "x_m", "y_m", *heights, *degrees, *motion, "in_loop"])
    for trajectory in plan:
        columns = [*_columns(trajectory, has_heights, projection), *(_motion(trajectory) if speeds_change else [])]
        columns.append((np.arange(len(trajectory.times_s)) >= trajectory.loop_index).astype(int).tolist())
        robot = as_cell(trajectory.robot)
        writer.writerows([robot, *row] for row in zip(*columns, strict=True))
    return text.getvalue()


def _columns(trajectory: Trajectory, has_heights: bool, projection: Projection | None) -> list[list[object]]:
    places_m, count = trajectory.positions_m, len(trajectory.times_s)
    columns = [trajectory.times_s.tolist(), *places_m.T.tolist()]
    if has_heights and places_m.shape[1] == 2:
        columns.append([""] * count)
    if projection:
        lon, lat = projection.to_degrees(places_m[:, 0], places_m[:, 1])
        columns += [lat.tolist(), lon.tolist()]
    return columns


def _motion(trajectory: Trajectory) -> list[list[object]]:
    """The speed and the acceleration with which each point is left; the last is come to."""
    durations_s = np.diff(trajectory.times_s)
    if not len(durations_s):
        return [[0.0], [0.0]]
    given = trajectory.accelerations_m_s2
    accelerations = np.zeros(len(durations_s)) if given is None else given
    means = np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1) / durations_s
    changes = accelerations * durations_s / 2
    speeds = np.maximum(np.append(means - changes, means[-1] + changes[-1]), 0.0)
    return [speeds.tolist(), np.append(accelerations, accelerations[-1]).tolist()]

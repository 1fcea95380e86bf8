"""Plan -> CSV: a row for every timed point of every robot."""

from __future__ import annotations

import csv
import io

import numpy as np

from rota.files.geodesy import Projection
from rota.files.spreadsheet_cells import as_cell
from rota.plan import Plan, Trajectory


def csv_text(plan: Plan) -> str:
    """Columns robot, t_s, x_m, y_m, z_m, lat, lon, in_loop; numbers with all digits, so that they read back equal.

    z_m is there when any robot has heights, and empty for robots without; lat and lon when the mission has an origin.
    A robot's name that a spreadsheet would compute has an apostrophe before it.
    in_loop is 1 from ``loop_start_s`` on: those rows are repeated for ever, and the last of them is where the first one
    is. A robot that stays has one row with in_loop 1, its last.
    """
    has_heights = any(trajectory.positions_m.shape[1] == 3 for trajectory in plan)
    projection = Projection(plan.mission.origin) if plan.mission.origin is not None else None
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    heights, degrees = ["z_m"] if has_heights else [], ["lat", "lon"] if projection else []
    writer.writerow(["robot", "t_s", "x_m", "y_m", *heights, *degrees, "in_loop"])
    for trajectory in plan:
        columns = _columns(trajectory, has_heights, projection)
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
    return [*columns, (np.arange(count) >= trajectory.loop_index).astype(int).tolist()]

"""Plan -> QGC WPL 110 text files, one per robot, which ArduPilot's ground stations and MAVProxy load.

Format: MAVLink developer guide, "File formats", plain-text mission files: a line of twelve numbers for each item.
"""

from __future__ import annotations

import os
from pathlib import Path

from rota.files.geodesy import projection_of
from rota.files.mission_items import WAYPOINT, Item, mission_items
from rota.files.robot_files import write_robot_files
from rota.model.plan import Plan, Trajectory

FIRST_LINE = "QGC WPL 110"
FRAME_GLOBAL = 0


def write_waypoint_lists(plan: Plan, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write one ``ROBOT.waypoints`` per robot into ``folder`` (made if missing); returns their paths.

    Raises PlanError for a mission without an origin, for routes of more items than MAVLink counts and for robots whose
    names give the same file name, RotaError when the folder cannot be written to. Nothing is written on errors of the
    plan.
    """
    return write_robot_files(plan, folder, ".waypoints", lambda trajectory: waypoint_list_text(plan, trajectory))


def waypoint_list_text(plan: Plan, trajectory: Trajectory) -> str:
    """One robot's file: home at the take-off point as item 0, then the ``mission_items`` for ArduPilot.

    A line holds, with tabs between: sequence number, whether it is the current item, frame, command, four parameters,
    latitude, longitude, altitude, and 1 for going on by itself. A heading that the items leave open is 0, since the
    format has no word for it; ArduPilot ignores it.
    """
    items = mission_items(plan, trajectory, projection_of(plan.mission, "a list of waypoints"))
    home = Item(WAYPOINT, FRAME_GLOBAL, [0, 0, 0, 0, *items[0].params[4:6], 0])
    lines = [_line(number, item) for number, item in enumerate([home, *items])]
    return "\n".join([FIRST_LINE, *lines]) + "\n"


def _line(number: int, item: Item) -> str:
    params = ["0" if value is None else repr(value) for value in item.params]
    return "\t".join([str(number), str(int(number == 0)), str(item.frame), str(item.command), *params, "1"])

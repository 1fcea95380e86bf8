"""Plan -> QGroundControl ``.plan`` files, one per robot: take off, fly to the loop, fly it for ever.

Format: QGroundControl developer guide, "Plan File Format" (file version 1, mission version 2, fence version 2).
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from rota.files.geodesy import Projection, projection_of
from rota.files.mission_items import DEGREE_DIGITS, Autopilot, Item, cruise_speed_m_s, mission_items
from rota.files.robot_files import write_robot_files
from rota.model.field_values import Json
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.routes.fence import FENCE_MARGIN_M, fence_of
from rota.routes.flights import ends_on_charger
from rota.routes.route import Ring

FIRMWARE = {"ardupilot": 3, "px4": 12}  # MAV_AUTOPILOT
QUADROTOR = 2


def write_qgroundcontrol(
    plan: Plan, folder: str | os.PathLike[str], *, autopilot: Autopilot = "ardupilot"
) -> tuple[Path, ...]:
    """Write one ``ROBOT.plan`` per robot into ``folder`` (made if missing); returns their paths.

    Raises PlanError for a mission without an origin or robots whose names give the same file name, RotaError when the
    folder cannot be written to. Nothing is written unless every file could be made.
    """

    def text_of(trajectory: Trajectory) -> str:
        document = trajectory_to_qgroundcontrol(plan, trajectory, autopilot=autopilot)
        return json.dumps(document, indent=1, allow_nan=False) + "\n"

    return write_robot_files(plan, folder, ".plan", text_of)


def trajectory_to_qgroundcontrol(plan: Plan, trajectory: Trajectory, *, autopilot: Autopilot = "ardupilot") -> Json:
    """One robot's ``.plan`` document: takeoff to the fleet's altitude, the approach, the loop, a jump back for ever.

    The items are those of ``mission_items``. The jump names its target by doJumpId; QGroundControl turns that into the
    sequence number of each autopilot. Raises PlanError without an origin.
    """
    mission = plan.mission
    projection = projection_of(mission, "QGroundControl")
    items = mission_items(plan, trajectory, projection, autopilot=autopilot)
    speed_m_s = cruise_speed_m_s(trajectory) or mission.fleet.robot(trajectory.robot).speed_m_s
    fence, fence_note = _fence(mission, trajectory, projection)
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "description": f"{_description(plan, trajectory)} {fence_note}",
        "geoFence": fence,
        "rallyPoints": {"version": 2, "points": []},
        "mission": {
            "version": 2,
            "firmwareType": FIRMWARE[autopilot],
            "vehicleType": QUADROTOR,
            "cruiseSpeed": speed_m_s,
            "hoverSpeed": speed_m_s,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [*items[0].params[4:6], 0],
            "items": [_item_to_json(number, item) for number, item in enumerate(items, start=1)],
        },
    }


def _item_to_json(number: int, item: Item) -> Json:
    head = {"type": "SimpleItem", "command": item.command, "frame": item.frame, "autoContinue": True}
    return {**head, "doJumpId": number, "params": item.params}


def _description(plan: Plan, trajectory: Trajectory) -> str:
    """What the mission file says of itself: whose it is, how long its loop or flight takes, who starts with it."""
    if ends_on_charger(trajectory):
        landing = trajectory.charges[-1]
        return (
            f"{plan.mission.name}, flight {trajectory.robot}: it lands on {landing.charger} {landing.from_s:.1f} s"
            " after its start, wind, braking, climb and descent aside. flights.csv says when it starts."
        )
    others = ", ".join(t.robot for t in plan.trajectories if t is not trajectory)
    company = f" Planned together with {others}, all starting at the same instant." if others else ""
    loop = (
        f"its loop starts {trajectory.loop_start_s:.1f} s after the start and takes {trajectory.loop_duration_s:.1f} s"
    )
    stay = f"it stays at its last place from {trajectory.loop_start_s:.1f} s after the start on"
    return (
        f"{plan.mission.name}, robot {trajectory.robot}: {loop if trajectory.loop_duration_s else stay}, wind and"
        f" braking aside.{company} Autopilots share no clock: phases between vehicles are the operator's to keep."
    )


def _fence(mission: Mission, trajectory: Trajectory, projection: Projection) -> tuple[Json, str]:
    """The robot's fence as the format has it, and a sentence about it."""
    fence = fence_of(mission, trajectory)
    if fence is None:
        told = f"No fence: the route comes closer than {FENCE_MARGIN_M:g} m to the border or an obstacle."
        return {"version": 2, "circles": [], "polygons": []}, told

    def corners_of(ring: Ring) -> Any:
        lon, lat = projection.to_degrees(*zip(*ring, strict=True))
        return np.round(np.column_stack([lat, lon]), DEGREE_DIGITS).tolist()

    rings = [(fence.inside_m, True), *((ring, False) for ring in fence.outside_m)]
    polygons = [{"version": 1, "inclusion": inside, "polygon": corners_of(ring)} for ring, inside in rings]
    circles = [
        {"version": 1, "inclusion": False, "circle": {"center": corners_of(((x, y),))[0], "radius": radius_m}}
        for x, y, radius_m in fence.circles_m
    ]
    told = "The fence is the mission's area less its obstacles."
    return {"version": 2, "circles": circles, "polygons": polygons}, told

"""Plan -> QGroundControl ``.plan`` files, one per robot: take off, fly to the loop, fly it for ever.

Format: QGroundControl developer guide, "Plan File Format" (file version 1, mission version 2, fence version 2).
"""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from shapely import LineString, MultiPolygon, Point, Polygon

from rota.errors import PlanError, RotaError
from rota.files.atomic_write import require_short_names, require_writable_folder, write_atomically
from rota.files.geodesy import Projection
from rota.mission import Mission
from rota.plan import Floats, Plan, Trajectory

Json = dict[str, Any]
Autopilot = Literal["ardupilot", "px4"]

WAYPOINT, LOITER_UNLIMITED, TAKEOFF, DO_JUMP, DO_CHANGE_SPEED = 16, 17, 22, 177, 178
FRAME_MISSION, FRAME_RELATIVE_ALTITUDE = 2, 3
FIRMWARE = {"ardupilot": 3, "px4": 12}  # MAV_AUTOPILOT
ENDLESS_REPEATS = {"ardupilot": -1, "px4": 65535}
QUADROTOR = 2
DEGREE_DIGITS = 9
SAME_SPEED = 1e-3  # share by which two legs' speeds may differ before the vehicle is told
FENCE_MARGIN_M = 3.0  # a satellite fix is no better; a fence any closer to the route would end the patrol by itself


@dataclass(frozen=True, kw_only=True)
class _Stop:
    """A place the vehicle flies to at ``speed_m_s`` (None: it is there already) and waits at for ``hold_s``."""

    position_m: Floats
    speed_m_s: float | None
    hold_s: float = 0.0


def write_qgroundcontrol(
    plan: Plan, folder: str | os.PathLike[str], *, autopilot: Autopilot = "ardupilot"
) -> tuple[Path, ...]:
    """Write one ``ROBOT.plan`` per robot into ``folder`` (made if missing); returns their paths.

    Raises PlanError for a mission without an origin or robots whose names give the same file name, RotaError when the
    folder cannot be written to. Nothing is written unless every file could be made.
    """
    require_writable_folder(folder)
    texts: dict[str, str] = {}
    for trajectory in plan.trajectories:
        name = re.sub(r"[^\w.-]+", "_", trajectory.robot).lstrip(".") or "robot"
        if name.casefold() in (known.casefold() for known in texts):
            raise PlanError(f"robot {trajectory.robot}: another robot's file is called {name}.plan; rename one of them")
        document = trajectory_to_qgroundcontrol(plan, trajectory, autopilot=autopilot)
        texts[name] = json.dumps(document, indent=1, allow_nan=False) + "\n"
    require_short_names(f"{name}.plan" for name in texts)
    try:
        Path(folder).mkdir(exist_ok=True)
    except OSError as error:
        raise RotaError(f"{folder}: cannot be made: {error.strerror or error}") from error
    paths = tuple(Path(folder) / f"{name}.plan" for name in texts)
    for path, text in zip(paths, texts.values(), strict=True):
        write_atomically(path, text)
    return paths


def trajectory_to_qgroundcontrol(plan: Plan, trajectory: Trajectory, *, autopilot: Autopilot = "ardupilot") -> Json:
    """One robot's ``.plan`` document: takeoff to the fleet's altitude, the approach, the loop, a jump back for ever.

    A robot that stays loiters at its last position. Pauses become the hold time of a waypoint. A third coordinate of
    positions is taken as the altitude over the take-off point. The jump names its target by doJumpId; QGroundControl
    turns that into the sequence number of each autopilot. ArduPilot takes -1 repeats as for ever; PX4 counts them in 16
    bits without a sign and may take -1 as none, so a PX4 plan repeats 65,535 times. Raises PlanError without an origin.
    """
    mission = plan.mission
    if mission.origin is None:
        raise PlanError(
            f"mission {mission.name}: without an origin it has no place on the globe, which QGroundControl needs;"
            " add origin: {lat: ..., lon: ...} to the mission file and plan again"
        )
    projection = Projection(mission.origin)
    items = _Items(projection, mission.fleet.altitude_m)
    items.add_place(TAKEOFF, trajectory.positions_m[0, :2], [0, 0, 0, None])
    approach, loop, closing = _stops(trajectory)
    for stop in approach:
        items.add_stop(stop)
    if closing is None:
        items.add_endless_stay(loop[0])
    else:
        items.add_endless_loop(loop, closing, ENDLESS_REPEATS[autopilot])
    speed_m_s = _cruise_speed_m_s(trajectory) or mission.fleet.robot(trajectory.robot).speed_m_s
    fence, fence_note = _fence(mission, trajectory, projection)
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "description": f"{_description(plan, trajectory)} {fence_note}",
        "geoFence": {"version": 2, "circles": [], "polygons": fence},
        "rallyPoints": {"version": 2, "points": []},
        "mission": {
            "version": 2,
            "firmwareType": FIRMWARE[autopilot],
            "vehicleType": QUADROTOR,
            "cruiseSpeed": speed_m_s,
            "hoverSpeed": speed_m_s,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [*items.degrees(trajectory.positions_m[0]), 0],
            "items": items.items,
        },
    }


def _description(plan: Plan, trajectory: Trajectory) -> str:
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


def _cruise_speed_m_s(trajectory: Trajectory) -> float | None:
    """The loop's highest speed, or the approach's when the robot stays; None when it never moves."""
    steps_m = np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1)
    speeds_m_s = steps_m / np.diff(trajectory.times_s)
    moving = speeds_m_s[trajectory.loop_index :]
    for part in (moving, speeds_m_s):
        if len(part) and part.max() > 0:
            return float(part.max())
    return None


def _stops(trajectory: Trajectory) -> tuple[list[_Stop], list[_Stop], _Stop | None]:
    """The approach's stops, the loop's stops from its first waypoint on, and the stop that closes the loop.

    The closing stop is where the loop began; None when the robot stays. Stops without a pause are left out where
    another item stands for the same place: the take-off at the start, the loop's first waypoint at the approach's end.
    """
    k = trajectory.loop_index
    approach = _visit(trajectory, 0, k) if k > 0 else []
    loop = _visit(trajectory, k, len(trajectory.times_s) - 1)
    if approach:
        loop[0] = replace(loop[0], speed_m_s=approach[-1].speed_m_s)
        if approach[-1].hold_s == 0 or len(loop) == 1:
            approach.pop()
    if approach and approach[0].speed_m_s is None and approach[0].hold_s == 0:
        approach.pop(0)
    return (approach, loop[:-1], loop[-1]) if len(loop) > 1 else (approach, loop, None)


def _visit(trajectory: Trajectory, first: int, last: int) -> list[_Stop]:
    times_s, positions_m = trajectory.times_s, trajectory.positions_m
    stops = [_Stop(position_m=positions_m[first], speed_m_s=None)]
    for i in range(first, last):
        duration_s = float(times_s[i + 1] - times_s[i])
        length_m = float(np.linalg.norm(positions_m[i + 1] - positions_m[i]))
        if length_m == 0:
            stops[-1] = replace(stops[-1], hold_s=stops[-1].hold_s + duration_s)
        else:
            stops.append(_Stop(position_m=positions_m[i + 1], speed_m_s=length_m / duration_s))
    return stops


class _Items:
    """The list of mission items being made; remembers the speed last commanded."""

    def __init__(self, projection: Projection, altitude_m: float) -> None:
        self.items: list[Json] = []
        self._projection = projection
        self._altitude_m = altitude_m
        self._speed_m_s: float | None = None

    def degrees(self, position_m: Floats) -> list[float]:
        """[latitude, longitude] of a position in local metres."""
        lon, lat = self._projection.to_degrees(position_m[:1], position_m[1:2])
        return [round(float(np.ravel(lat)[0]), DEGREE_DIGITS), round(float(np.ravel(lon)[0]), DEGREE_DIGITS)]

    def add(self, command: int, frame: int, params: list[float | None]) -> int:
        """Add an item with its seven parameters; returns its doJumpId."""
        number = len(self.items) + 1
        item = {"type": "SimpleItem", "command": command, "frame": frame, "autoContinue": True, "doJumpId": number}
        self.items.append({**item, "params": params})
        return number

    def add_place(self, command: int, position_m: Floats, params: list[float | None]) -> int:
        """Add an item that has a place; ``params`` are its first four parameters."""
        altitude_m = float(position_m[2]) if len(position_m) == 3 else self._altitude_m
        return self.add(command, FRAME_RELATIVE_ALTITUDE, [*params, *self.degrees(position_m), altitude_m])

    def add_speed(self, speed_m_s: float | None) -> None:
        """Command a ground speed, unless it is the one commanded last."""
        if speed_m_s is not None and not self._flies_at(speed_m_s):
            self.add(DO_CHANGE_SPEED, FRAME_MISSION, [1, speed_m_s, -1, 0, 0, 0, 0])
            self._speed_m_s = speed_m_s

    def _flies_at(self, speed_m_s: float) -> bool:
        return self._speed_m_s is not None and math.isclose(speed_m_s, self._speed_m_s, rel_tol=SAME_SPEED)

    def add_stop(self, stop: _Stop) -> int:
        """Add a waypoint, after the speed to reach it with."""
        self.add_speed(stop.speed_m_s)
        return self.add_place(WAYPOINT, stop.position_m, [stop.hold_s, 0, 0, None])

    def add_endless_stay(self, stop: _Stop) -> None:
        """Add loitering without end."""
        self.add_speed(stop.speed_m_s)
        self.add_place(LOITER_UNLIMITED, stop.position_m, [0, 0, 0, None])

    def add_endless_loop(self, loop: list[_Stop], closing: _Stop, repeats: int) -> None:
        """Add the loop's waypoints and the jump back to its first one."""
        first_leg = loop[1] if len(loop) > 1 else closing
        self.add_speed(loop[0].speed_m_s or first_leg.speed_m_s)
        start = self.add_stop(loop[0])
        # reached from the approach once and from the loop's end ever after: the speed there may be either
        if closing.speed_m_s is not None and not self._flies_at(closing.speed_m_s):
            self._speed_m_s = None
        for stop in loop[1:]:
            self.add_stop(stop)
        self.add_speed(closing.speed_m_s)
        if closing.hold_s > 0:
            self.add_stop(closing)
        self.add(DO_JUMP, FRAME_MISSION, [start, repeats, 0, 0, 0, 0, 0])


def _fence(mission: Mission, trajectory: Trajectory, projection: Projection) -> tuple[list[Json], str]:
    """The polygon of the area that the robot is in, less holes and obstacles; none when the route runs close to them.

    Only one polygon includes, since autopilots differ on whether several mean all of them or any.
    """
    points_m = trajectory.positions_m[:, :2]
    route = LineString(points_m) if len(points_m) > 1 else Point(points_m[0])
    home = min(mission.area.geoms, key=lambda polygon: polygon.distance(route))
    outer = Polygon(home.exterior)
    blocked = [Polygon(hole) for hole in home.interiors]
    blocked += [Polygon(p.exterior) for o in mission.obstacles if o.blocks_motion for p in o.shape.geoms]
    blocked = [polygon for polygon in blocked if polygon.intersects(outer)]
    inside = outer.contains(route) and route.distance(outer.exterior) >= FENCE_MARGIN_M
    if not inside or route.distance(MultiPolygon(blocked)) < FENCE_MARGIN_M:
        return [], f"No fence: the route comes closer than {FENCE_MARGIN_M:g} m to the border or an obstacle."

    def polygon_to_json(polygon: Polygon, inclusion: bool) -> Json:
        xy = np.asarray(polygon.exterior.coords)[:-1, :2]
        lon, lat = projection.to_degrees(xy[:, 0], xy[:, 1])
        corners = np.round(np.column_stack([lat, lon]), DEGREE_DIGITS).tolist()
        return {"version": 1, "inclusion": inclusion, "polygon": corners}

    fence = [polygon_to_json(outer, True), *(polygon_to_json(polygon, False) for polygon in blocked)]
    return fence, "The fence is the mission's area less its obstacles."

"""Plan -> the mission items of one MAVLink vehicle: take off, fly to the loop, fly it for ever.

Each file format of ground stations writes these same items in its own way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.files.geodesy import Projection
from rota.model.plan import Plan, Trajectory
from rota.routes.driven_route import route_with_whole_waits
from rota.routes.route import Route, RouteStop, route_of

Autopilot = Literal["ardupilot", "px4"]

WAYPOINT, LOITER_UNLIMITED, LAND, TAKEOFF, DO_JUMP, DO_CHANGE_SPEED = 16, 17, 21, 22, 177, 178
FRAME_MISSION, FRAME_RELATIVE_ALTITUDE = 2, 3
ENDLESS_REPEATS = {"ardupilot": -1, "px4": 65535}
DEGREE_DIGITS = 9
SAME_SPEED = 1e-6  # share by which two legs' speeds may differ before the vehicle is told; 4 ms in an hour
MOST_HEIGHT_M = 83_000.0  # LOCATION_ALT_MAX_M: what ArduPilot's 24 bits hold of centimetres
MOST_HOLD_S = 65_535.0  # ArduPilot keeps a hold time in 16 bits
MOST_ITEMS = 65534  # MAVLink counts items in 16 bits, and item 0 is home


class Item(NamedTuple):
    """A mission item (MISSION_ITEM_INT of MAVLink): its command, frame and seven parameters; None: left open."""

    command: int
    frame: int
    params: list[float | None]


class _Stop(NamedTuple):
    """A stop of the route with its ``place`` on the globe: degrees of latitude and longitude, metres of height."""

    place: list[float]
    speed_m_s: float | None
    hold_s: float


def mission_items(
    plan: Plan, trajectory: Trajectory, projection: Projection, *, autopilot: Autopilot = "ardupilot"
) -> list[Item]:
    """One robot's items, numbered from 1: takeoff to the fleet's altitude, approach, loop, a jump back for ever.

    A robot that stays loiters at its last position; one that ends on a charger lands there.

    Pauses become the hold time of a waypoint. A third coordinate of
    positions is taken as the altitude over the take-off point. The jump names its target by the number of the item,
    which is ``doJumpId`` in QGroundControl's plans and the sequence number where home is item 0. ArduPilot takes -1
    repeats as for ever; PX4 counts them in 16 bits without a sign and may take -1 as none, so it repeats 65,535 times.
    A wait of more than 65,535 s becomes several waypoints at one place.

    Raises PlanError for more than 65,534 items, which MAVLink cannot count, and for heights above 83,000 m, which
    ArduPilot cannot keep.
    """
    return route_items(route_of(trajectory, plan.mission.fleet.altitude_m), projection, autopilot=autopilot)


def route_items(route: Route, projection: Projection, *, autopilot: Autopilot) -> list[Item]:
    """The same of a route. ArduPilot keeps whole seconds of waits: what is left of one makes a leg slower."""
    if autopilot == "ardupilot":
        _require_height(route)
        route = route_with_whole_waits(route)
    items = _Items()
    start = _on_globe([RouteStop(place_m=route.start_m, speed_m_s=None)], projection)[0].place
    items.add(TAKEOFF, FRAME_RELATIVE_ALTITUDE, [0, 0, 0, None, *start])
    for stop in _on_globe(route.approach, projection):
        items.add_stop(stop)
    loop = _on_globe(route.loop, projection)
    if route.lands:
        items.add_landing(loop[0])
    elif route.closing is None:
        items.add_endless_stay(loop[0])
    else:
        (closing,) = _on_globe([route.closing], projection)
        items.add_endless_loop(loop, closing, ENDLESS_REPEATS[autopilot])
    if len(items.items) > MOST_ITEMS:
        raise PlanError(
            f"robot {route.robot}: its route makes {len(items.items)} mission items; MAVLink counts at most"
            f" {MOST_ITEMS} beside home"
        )
    return items.items


def _require_height(route: Route) -> None:
    height_m = max(
        place_m[2] for place_m in (route.start_m, *(stop.place_m for stop in (*route.approach, *route.loop)))
    )
    if height_m > MOST_HEIGHT_M:
        raise PlanError(
            f"robot {route.robot}: a place {height_m:.6g} m over the take-off point; ArduPilot keeps at most"
            f" {MOST_HEIGHT_M:g} m"
        )


def cruise_speed_m_s(trajectory: Trajectory) -> float | None:
    """The loop's highest speed, or the approach's when the robot stays; None when it never moves."""
    steps_m = np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1)
    durations_s = np.diff(trajectory.times_s)
    speeds_m_s = steps_m / durations_s
    if trajectory.accelerations_m_s2 is not None:
        speeds_m_s += np.abs(trajectory.accelerations_m_s2) * durations_s / 2
    moving = speeds_m_s[trajectory.loop_index :]
    for part in (moving, speeds_m_s):
        if len(part) and part.max() > 0:
            return float(part.max())
    return None


def _on_globe(stops: Sequence[RouteStop], projection: Projection) -> list[_Stop]:
    """Stops with their places in degrees, rounded as MAVLink carries them."""
    if not stops:
        return []
    x, y, heights_m = zip(*(stop.place_m for stop in stops), strict=True)
    lon, lat = projection.to_degrees(x, y)
    columns = zip(stops, lat.tolist(), lon.tolist(), heights_m, strict=True)
    return [
        _Stop([round(north, DEGREE_DIGITS), round(east, DEGREE_DIGITS), height_m], stop.speed_m_s, stop.hold_s)
        for stop, north, east, height_m in columns
    ]


class _Items:
    """The list of mission items being made; remembers the speed last commanded."""

    def __init__(self) -> None:
        self.items: list[Item] = []
        self._speed_m_s: float | None = None

    def add(self, command: int, frame: int, params: list[float | None]) -> int:
        """Add an item with its seven parameters; returns its number, from 1."""
        self.items.append(Item(command, frame, params))
        return len(self.items)

    def add_speed(self, speed_m_s: float | None) -> None:
        """Command a ground speed, unless it is the one commanded last."""
        if speed_m_s is not None and not self._flies_at(speed_m_s):
            self.add(DO_CHANGE_SPEED, FRAME_MISSION, [1, speed_m_s, -1, 0, 0, 0, 0])
            self._speed_m_s = speed_m_s

    def _flies_at(self, speed_m_s: float) -> bool:
        return self._speed_m_s is not None and math.isclose(speed_m_s, self._speed_m_s, rel_tol=SAME_SPEED)

    def add_stop(self, stop: _Stop) -> int:
        """Add a waypoint, after the speed to reach it with, and more at its place for a long wait; its number."""
        self.add_speed(stop.speed_m_s)
        left_s = stop.hold_s
        number = self.add(WAYPOINT, FRAME_RELATIVE_ALTITUDE, [min(left_s, MOST_HOLD_S), 0, 0, None, *stop.place])
        while (left_s := left_s - MOST_HOLD_S) > 0 and len(self.items) <= MOST_ITEMS:
            self.add(WAYPOINT, FRAME_RELATIVE_ALTITUDE, [min(left_s, MOST_HOLD_S), 0, 0, None, *stop.place])
        return number

    def add_landing(self, stop: _Stop) -> None:
        """Add the last waypoint and a landing below it."""
        self.add_stop(stop)
        self.add(LAND, FRAME_RELATIVE_ALTITUDE, [0, 0, 0, None, *stop.place[:2], 0])

    def add_endless_stay(self, stop: _Stop) -> None:
        """Add loitering without end."""
        self.add_speed(stop.speed_m_s)
        self.add(LOITER_UNLIMITED, FRAME_RELATIVE_ALTITUDE, [0, 0, 0, None, *stop.place])

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

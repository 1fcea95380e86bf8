"""Plan -> the mission items of one MAVLink vehicle: take off, fly to the loop, fly it for ever.

Each file format of ground stations writes these same items in its own way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.files.geodesy import Projection
from rota.plan import Floats, Plan, Trajectory

Autopilot = Literal["ardupilot", "px4"]

WAYPOINT, LOITER_UNLIMITED, TAKEOFF, DO_JUMP, DO_CHANGE_SPEED = 16, 17, 22, 177, 178
FRAME_MISSION, FRAME_RELATIVE_ALTITUDE = 2, 3
ENDLESS_REPEATS = {"ardupilot": -1, "px4": 65535}
DEGREE_DIGITS = 9
SAME_SPEED = 1e-3  # share by which two legs' speeds may differ before the vehicle is told
MOST_ITEMS = 65534  # MAVLink counts items in 16 bits, and item 0 is home


class Item(NamedTuple):
    """A mission item (MISSION_ITEM_INT of MAVLink): its command, frame and seven parameters; None: left open."""

    command: int
    frame: int
    params: list[float | None]


@dataclass(frozen=True, kw_only=True)
class _Stop:
    """A ``place`` (degrees of latitude and longitude, metres of height) to fly to at ``speed_m_s`` and wait at.

    ``speed_m_s`` is None where the vehicle is there already; ``hold_s``: how long it waits.
    """

    place: list[float]
    speed_m_s: float | None
    hold_s: float = 0.0


def mission_items(
    plan: Plan, trajectory: Trajectory, projection: Projection, *, autopilot: Autopilot = "ardupilot"
) -> list[Item]:
    """One robot's items, numbered from 1: takeoff to the fleet's altitude, approach, loop, a jump back for ever.

    A robot that stays loiters at its last position. Pauses become the hold time of a waypoint. A third coordinate of
    positions is taken as the altitude over the take-off point. The jump names its target by the number of the item,
    which is ``doJumpId`` in QGroundControl's plans and the sequence number where home is item 0. ArduPilot takes -1
    repeats as for ever; PX4 counts them in 16 bits without a sign and may take -1 as none, so it repeats 65,535 times.

    Raises PlanError for more than 65,534 items, which MAVLink cannot count.
    """
    altitude_m = plan.mission.fleet.altitude_m
    items = _Items()
    takeoff, approach, loop, closing = _stops(trajectory, projection, altitude_m)
    items.add(TAKEOFF, FRAME_RELATIVE_ALTITUDE, [0, 0, 0, None, *takeoff[:2], altitude_m])
    for stop in approach:
        items.add_stop(stop)
    if closing is None:
        items.add_endless_stay(loop[0])
    else:
        items.add_endless_loop(loop, closing, ENDLESS_REPEATS[autopilot])
    if len(items.items) > MOST_ITEMS:
        raise PlanError(
            f"robot {trajectory.robot}: its route makes {len(items.items)} mission items; MAVLink counts at most"
            f" {MOST_ITEMS} beside home"
        )
    return items.items


def cruise_speed_m_s(trajectory: Trajectory) -> float | None:
    """The loop's highest speed, or the approach's when the robot stays; None when it never moves."""
    steps_m = np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1)
    speeds_m_s = steps_m / np.diff(trajectory.times_s)
    moving = speeds_m_s[trajectory.loop_index :]
    for part in (moving, speeds_m_s):
        if len(part) and part.max() > 0:
            return float(part.max())
    return None


def _stops(
    trajectory: Trajectory, projection: Projection, altitude_m: float
) -> tuple[list[float], list[_Stop], list[_Stop], _Stop | None]:
    """The first place, the approach's stops, the loop's from its first waypoint on, and the one that closes the loop.

    The closing stop is where the loop began; None when the robot stays. Stops without a pause are left out where
    another item stands for the same place: the take-off at the start, the loop's first waypoint at the approach's end.
    """
    k = trajectory.loop_index
    places = _places(trajectory, projection, altitude_m)
    approach = _visit(trajectory, places, 0, k) if k > 0 else []
    loop = _visit(trajectory, places, k, len(trajectory.times_s) - 1)
    if approach:
        loop[0] = replace(loop[0], speed_m_s=approach[-1].speed_m_s)
        if approach[-1].hold_s == 0 or len(loop) == 1:
            approach.pop()
    if approach and approach[0].speed_m_s is None and approach[0].hold_s == 0:
        approach.pop(0)
    return (places[0], approach, loop[:-1], loop[-1]) if len(loop) > 1 else (places[0], approach, loop, None)


def _places(trajectory: Trajectory, projection: Projection, altitude_m: float) -> list[list[float]]:
    """Latitude, longitude and height of each position."""
    positions_m = trajectory.positions_m
    lon, lat = projection.to_degrees(positions_m[:, 0], positions_m[:, 1])
    heights_m = positions_m[:, 2] if positions_m.shape[1] == 3 else np.full(len(lat), altitude_m)
    columns = zip(lat.tolist(), lon.tolist(), heights_m.tolist(), strict=True)
    return [[round(north, DEGREE_DIGITS), round(east, DEGREE_DIGITS), height_m] for north, east, height_m in columns]


def _visit(trajectory: Trajectory, places: list[list[float]], first: int, last: int) -> list[_Stop]:
    durations_s = np.diff(trajectory.times_s[first : last + 1]).tolist()
    lengths_m = _lengths_m(trajectory.positions_m[first : last + 1])
    stops = [_Stop(place=places[first], speed_m_s=None)]
    for place, duration_s, length_m in zip(places[first + 1 : last + 1], durations_s, lengths_m, strict=True):
        if length_m == 0:
            stops[-1] = replace(stops[-1], hold_s=stops[-1].hold_s + duration_s)
        else:
            stops.append(_Stop(place=place, speed_m_s=length_m / duration_s))
    return stops


def _lengths_m(positions_m: Floats) -> list[float]:
    return [float(np.linalg.norm(step_m)) for step_m in np.diff(positions_m, axis=0)]


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
        """Add a waypoint, after the speed to reach it with."""
        self.add_speed(stop.speed_m_s)
        return self.add(WAYPOINT, FRAME_RELATIVE_ALTITUDE, [stop.hold_s, 0, 0, None, *stop.place])

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

"""Mission items as autopilots keep and fly them.

ArduPilot, AP_Mission.cpp, ``mavlink_int_to_mission_cmd``: a waypoint's hold time is ``cmd.p1``, 16 bits without a sign,
so that fractions of a second are lost (planes keep the acceptance radius there and do not wait at all); heights are
whole centimetres. PX4, ``mavlink_mission.cpp``: hold times and heights stay floats of 32 bits. Both take latitude and
longitude from MISSION_ITEM_INT, in 1e-7 degrees.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.files.executed.time_lost import drive_by_file
from rota.files.geodesy import Projection, projection_of
from rota.files.mission_items import (
    DO_CHANGE_SPEED,
    DO_JUMP,
    LAND,
    LOITER_UNLIMITED,
    MOST_HOLD_S,
    TAKEOFF,
    WAYPOINT,
    Autopilot,
    Item,
)
from rota.files.qgroundcontrol import trajectory_to_qgroundcontrol
from rota.files.waypoint_list import waypoint_list_text
from rota.model.plan import Plan, Trajectory
from rota.routes.route import RouteStop

DEGREE = 1e-7  # of MISSION_ITEM_INT
CENTIMETRES = 100.0
HERE_M = 0.02  # a take-off nearer than this to where the vehicle stands is that place, rounded


class Told(NamedTuple):
    """What a file tells a vehicle: stops once, and then others for ever; none where it stays."""

    once: list[RouteStop]
    every_round: list[RouteStop]


def as_waypoints(plan: Plan, trajectory: Trajectory) -> Trajectory:
    """One robot as ArduPilot flies its list of waypoints."""
    return exactly(trajectory, read_waypoints(plan, trajectory))


def read_waypoints(plan: Plan, trajectory: Trajectory) -> Told:
    """What a list of waypoints tells ArduPilot."""
    lines = waypoint_list_text(plan, trajectory).splitlines()[2:]  # without the first line and home
    rows = [[float(word) for word in line.split("\t")] for line in lines]
    items = [Item(int(row[3]), int(row[2]), list(row[4:11])) for row in rows]
    return read_items(plan, trajectory, items, "ardupilot")


def as_qgroundcontrol(plan: Plan, trajectory: Trajectory, autopilot: Autopilot) -> Trajectory:
    """One robot as an autopilot flies its plan of QGroundControl."""
    return exactly(trajectory, read_qgroundcontrol(plan, trajectory, autopilot))


def read_qgroundcontrol(plan: Plan, trajectory: Trajectory, autopilot: Autopilot) -> Told:
    """What a plan of QGroundControl tells an autopilot."""
    document = json.loads(json.dumps(trajectory_to_qgroundcontrol(plan, trajectory, autopilot=autopilot)))
    items = [Item(item["command"], item["frame"], item["params"]) for item in document["mission"]["items"]]
    return read_items(plan, trajectory, items, autopilot)


def read_items(plan: Plan, trajectory: Trajectory, items: list[Item], autopilot: Autopilot) -> Told:
    """What items tell, numbered from 1, which begin with a take-off and end with a jump, loitering or a landing.

    The loop is what is flown between the second time and the third time that the jump comes: speeds of the first round
    may be the approach's. The vehicle flies at its own speed where none was commanded, and never faster. It takes off
    from where it stands, and waits there first, whatever the digits of that place. Raises PlanError for other items.
    """
    stops, first_jump, second_jump = _stops(plan, trajectory.robot, items, autopilot)
    x, y = trajectory.positions_m[0, :2].tolist()
    taken_off = stops[0].place_m[:2]
    if math.dist(taken_off, (x, y)) <= HERE_M:
        for number, stop in enumerate(itertools.takewhile(lambda stop: stop.place_m[:2] == taken_off, tuple(stops))):
            stops[number] = replace(stop, place_m=(x, y, stop.place_m[2]))
    return Told(stops[:first_jump], stops[first_jump:second_jump])


def exactly(trajectory: Trajectory, told: Told) -> Trajectory:
    """The trajectory of a vehicle that does all that it is told, and speeds up and brakes as the plan has it."""
    return drive_by_file(trajectory, told.once, told.every_round)


def _stops(plan: Plan, robot: str, items: list[Item], autopilot: Autopilot) -> tuple[list[RouteStop], int, int]:
    """The stops until the jump came twice, and how many were before each time; all of them where none comes."""
    projection = projection_of(plan.mission, "MAVLink")
    most_m_s = plan.mission.fleet.robot(robot).speed_m_s
    places = _places_m(items, projection, autopilot)
    stops: list[RouteStop] = []
    jumps: list[int] = []
    speed_m_s, at = most_m_s, 0
    while len(jumps) < 2:
        command, _, params = items[at]
        value = params[0] or 0.0
        at += 1
        if command == DO_CHANGE_SPEED:
            speed_m_s = min(float(np.float32(params[1] or 0.0)), most_m_s)
        elif command == DO_JUMP:
            jumps.append(len(stops))
            at = int(value) - 1
        elif command in (TAKEOFF, WAYPOINT, LOITER_UNLIMITED, LAND):
            hold_s = _hold_s(value, autopilot) if command == WAYPOINT else 0.0
            stops.append(RouteStop(place_m=places[at - 1], speed_m_s=speed_m_s if stops else None, hold_s=hold_s))
            if command in (LOITER_UNLIMITED, LAND):
                return stops, len(stops), len(stops)
        else:
            raise PlanError(f"robot {robot}: command {command} is none that a route is made of")
    return stops, jumps[0], jumps[1]


def _hold_s(written: float, autopilot: Autopilot) -> float:
    if autopilot == "ardupilot":
        return float(min(math.floor(written), MOST_HOLD_S))
    return float(np.float32(written))


def _places_m(items: Iterable[Item], projection: Projection, autopilot: Autopilot) -> list[tuple[float, float, float]]:
    """Where each item is, as the vehicle keeps it; nonsense for those that are nowhere."""
    written = np.array([[value or 0.0 for value in item.params[4:]] for item in items])
    degrees = np.round(written[:, :2] / DEGREE) * DEGREE
    heights_m = written[:, 2].astype(np.float32).astype(np.float64)
    if autopilot == "ardupilot":
        heights_m = np.trunc(heights_m * CENTIMETRES) / CENTIMETRES
    x, y = projection.to_metres(degrees[:, 1], degrees[:, 0])
    return [
        (east, north, height) for east, north, height in zip(x.tolist(), y.tolist(), heights_m.tolist(), strict=True)
    ]

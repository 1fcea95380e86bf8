"""Routes without a clock as the other formats hold them, and as who heeds all of it drives them."""

from __future__ import annotations

import io
import json
import re
import zipfile
from xml.etree import ElementTree

import numpy as np

from rota.files.dji_waylines import (
    KML_NAMESPACE,
    WAYLINES,
    WPML_NAMESPACE,
    WaylineSettings,
    kmz_of,
)
from rota.files.executed.time_lost import drive_by_file
from rota.files.executed.timed_files import metres_read
from rota.files.geodesy import projection_of
from rota.files.nav2_waypoints import APPROACH, LOOP, nav2_texts
from rota.files.timed_places import START
from rota.files.vda5050_files import OrderSettings, orders_text
from rota.model.field_values import Json
from rota.model.plan import Plan, Trajectory
from rota.routes.driven_route import from_start
from rota.routes.route import RouteStop, route_of, start_height_m

NAMES = {"k": KML_NAMESPACE, "w": WPML_NAMESPACE}
PANEL_ENTRY = re.compile(
    r"pose: \[(.*), (.*), (.*)\]\n    orientation: .*\n(?:    speed_m_s: (.*)\n)?    wait_s: (.*)\n"
)


def as_dji_waylines(plan: Plan, trajectory: Trajectory) -> Trajectory:
    """One robot as DJI's aircraft fly its wayline, were it to go on with the second round for ever.

    It passes where it turns: a turn within 0.2 m of a waypoint is taken to go through it.
    """
    projection = projection_of(plan.mission, "DJI WPML")
    settings = WaylineSettings(duration_s=_two_rounds_s(trajectory))
    with zipfile.ZipFile(io.BytesIO(kmz_of(plan, trajectory, projection, settings))) as archive:
        document = ElementTree.fromstring(archive.read(WAYLINES))  # of our own making
    marks = document.findall("k:Document/k:Folder/k:Placemark", NAMES)
    degrees = np.array([_text(mark, "k:Point/k:coordinates").split(",") for mark in marks], dtype=np.float64)
    stops: list[RouteStop] = []
    speed_m_s = None
    for mark, east, north in zip(marks, *metres_read(degrees, projection).T.tolist(), strict=True):
        hold = mark.find("w:actionGroup/w:action/w:actionActuatorFuncParam/w:hoverTime", NAMES)
        place_m = (east, north, float(_text(mark, "w:executeHeight")))
        stops.append(
            RouteStop(place_m=place_m, speed_m_s=speed_m_s, hold_s=float(hold.text or 0) if hold is not None else 0.0)
        )
        speed_m_s = float(_text(mark, "w:waypointSpeed"))
    return _in_rounds(trajectory, stops, plan.mission.fleet.altitude_m)


def as_nav2_waypoints(plan: Plan, trajectory: Trajectory) -> Trajectory:
    """One robot as a client of Nav2 drives its waypoints that heeds their speeds and waits, and turns by itself."""
    robot = plan.mission.fleet.robot(trajectory.robot)
    texts = nav2_texts(trajectory, robot)
    parts = []
    for name in (APPROACH, LOOP):
        found = PANEL_ENTRY.findall(texts[name])
        parts.append(
            [
                RouteStop(
                    place_m=(float(x), float(y), float(z)),
                    speed_m_s=float(speed) if speed else None,
                    hold_s=float(wait),
                )
                for x, y, z, speed, wait in found
            ]
        )
    once, every_round = parts
    if trajectory.loop_duration_s == 0:
        every_round = []
    return drive_by_file(trajectory, once, every_round, robot.turn_rate_rad_s)


def as_vda5050_orders(plan: Plan, trajectory: Trajectory) -> Trajectory:
    """One robot as a vehicle drives its orders that is as fast as they allow, knows how to wait and turns by itself."""
    settings = OrderSettings(duration_s=_two_rounds_s(trajectory))
    robot = plan.mission.fleet.robot(trajectory.robot)
    nodes: dict[int, Json] = {}
    edges: dict[int, Json] = {}
    for line in orders_text(trajectory, settings, START, robot).splitlines():
        message = json.loads(line)
        nodes |= {node["sequenceId"]: node for node in message["nodes"] if node["released"]}
        edges |= {edge["sequenceId"]: edge for edge in message["edges"] if edge["released"]}
    stops = []
    for number in sorted(nodes):
        node, edge = nodes[number], edges.get(number - 1)
        waits = [action for action in node["actions"] if action["actionType"] == settings.wait.name]
        place = node["nodePosition"]
        stops.append(
            RouteStop(
                place_m=(place["x"], place["y"], 0.0),
                speed_m_s=edge["maxSpeed"] if edge is not None else None,
                hold_s=sum(parameter["value"] for wait in waits for parameter in wait["actionParameters"]),
            )
        )
    return _in_rounds(trajectory, stops, 0.0, robot.turn_rate_rad_s)


def _text(element: ElementTree.Element, path: str) -> str:
    return element.findtext(path, "", NAMES)


def _two_rounds_s(trajectory: Trajectory) -> float:
    """A time within which the robot drives two rounds, and not three."""
    return max(trajectory.loop_start_s + 2.5 * trajectory.loop_duration_s, 1.0)


def _in_rounds(
    trajectory: Trajectory, stops: list[RouteStop], altitude_m: float, turn_rate_rad_s: float | None = None
) -> Trajectory:
    """The trajectory of stops that hold an approach and two rounds: the second goes on for ever.

    turn_rate_rad_s: of a robot that turns at each stop by itself, beyond what it is told.
    """
    route = route_of(trajectory, start_height_m(trajectory, altitude_m))
    first, a_round = len(from_start(route)), len(route.every_round)
    if not a_round:
        return drive_by_file(trajectory, stops, [], turn_rate_rad_s)
    once, every_round = stops[: first + a_round], stops[first + a_round : first + 2 * a_round]
    return drive_by_file(trajectory, once, every_round, turn_rate_rad_s)

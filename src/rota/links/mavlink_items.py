"""A route -> the mission items and the fence that a MAVLink vehicle takes, and how what it holds differs from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.files.mission_items import DO_JUMP, WAYPOINT, Autopilot, Item, route_items
from rota.routes.route import Fence, Ring, Route
from rota.vehicles.facts import Fact
from rota.vehicles.presets import ARDUCOPTER

DEGREES = 1e7  # MAVLink's whole numbers in a degree
FRAME_GLOBAL = 0
MOST_ITEMS = 1306  # (2422 + 2132 + 5204 + 9842 - 4) bytes / 15: ArduPilot 4.6, StorageManager.cpp, Copter, 32 KiB
CENTIMETRE_M = 0.01 + 1e-4  # with what float32 loses at heights of some hundred metres
MOST_RALLY = 10  # 150 bytes / 15: ArduPilot 4.6, StorageManager.cpp, a Copter's areas on boards with 16 KiB
RALLY_POINT, FRAME_RELATIVE = 5100, 3
RELATIVE_ALTITUDE = frozenset({3, 6})  # one frame by two names
WITH_PLACE = frozenset({WAYPOINT, 17, 21, 22, RALLY_POINT})
NAMES = {
    16: "waypoint",
    17: "loiter",
    21: "landing",
    22: "take-off",
    177: "jump",
    178: "speed",
    RALLY_POINT: "rally point",
}

Corners = tuple[tuple[int, int], ...]  # 1e-7 degrees of latitude and longitude


class WireItem(NamedTuple):
    """MISSION_ITEM_INT: x, y in 1e-7 degrees of latitude and longitude, the rest as float32; NaN: left open."""

    seq: int
    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float


class WireShape(NamedTuple):
    """A polygon of a fence; with a radius in metres (float32) a circle round its only corner."""

    keeps_in: bool
    corners: Corners
    radius_m: float = 0.0


def wire_items(route: Route, projection: Projection, autopilot: Autopilot) -> list[WireItem]:
    """The items that are sent: those of ``route_items``, numbered from 0.

    On ArduPilot item 0 is home, here the take-off point. It keeps holds as whole seconds, so they are rounded, each
    with what was left over before: ``cmd.p1 = packet.param1`` into 16 bits, in AP_Mission::mavlink_int_to_mission_cmd
    (libraries/AP_Mission/AP_Mission.cpp). AP_Mission::sanity_check_params there refuses a parameter that is NaN,
    such as an open heading, in loitering; what is open is sent as 0, which ArduPilot does not use there.
    """
    items = route_items(route, projection, autopilot=autopilot)
    if autopilot == "px4":
        return [_wired(number, item, 1) for number, item in enumerate(items)]
    home = Item(WAYPOINT, FRAME_GLOBAL, [0, 0, 0, 0, *items[0].params[4:6], 0])
    closed = [item._replace(params=[value or 0.0 for value in item.params]) for item in _whole_holds(items)]
    return [_wired(number, item, 0) for number, item in enumerate([home, *closed])]


def _whole_holds(items: Sequence[Item]) -> list[Item]:
    """The items with whole seconds of holding; what rounding leaves over goes to the next hold."""
    left_s, rounded = 0.0, []
    for item in items:
        if item.command == WAYPOINT:
            wanted_s = (item.params[0] or 0.0) + left_s
            hold_s = max(0, math.floor(wanted_s + 0.5))
            left_s = wanted_s - hold_s
            item = item._replace(params=[hold_s, *item.params[1:]])
        rounded.append(item)
    return rounded


def _wired(number: int, item: Item, first: int) -> WireItem:
    """An item under its number; ``first``: what items count from in its jumps."""
    values = [math.nan if value is None else float(value) for value in item.params]
    if item.command == DO_JUMP:
        values[0] -= first
    a, b, c, d = (float(np.float32(value)) for value in values[:4])
    x, y = (round(value * DEGREES) for value in values[4:6])
    return WireItem(number, item.command, item.frame, (a, b, c, d), x, y, float(np.float32(values[6])))


def wire_fence(fence: Fence | None, projection: Projection) -> list[WireShape]:
    """The fence's polygons, the one that keeps in first, and then its circles; none without a fence."""
    if fence is None:
        return []
    rings = [(True, fence.inside_m), *((False, ring) for ring in fence.outside_m)]
    polygons = [WireShape(keeps_in, _corners(ring, projection)) for keeps_in, ring in rings]
    return polygons + [
        WireShape(False, _corners(((x, y),), projection), float(np.float32(radius_m)))
        for x, y, radius_m in fence.circles_m
    ]


def wire_rally(route: Route, projection: Projection) -> list[WireItem]:
    """The route's rally points as items of their own kind of mission, numbered from 0."""
    if not route.rally_m:
        return []
    places = _corners(tuple((x, y) for x, y, _ in route.rally_m), projection)
    return [
        WireItem(number, RALLY_POINT, FRAME_RELATIVE, (0.0, 0.0, 0.0, 0.0), *place, height_m)
        for number, (place, (_, _, height_m)) in enumerate(zip(places, route.rally_m, strict=True))
    ]


def require_room(
    robot: str, items: Sequence[WireItem], shapes: Sequence[WireShape], rally: Sequence[WireItem] = ()
) -> None:
    """Raise LinkError for what no ArduCopter has room for; those with little room say so for missions."""
    points, most_points = sum(len(shape.corners) for shape in shapes), _most(ARDUCOPTER.most_fence_points)
    if len(items) > MOST_ITEMS:
        raise LinkError(
            f"robot {robot}: its mission has {len(items)} items; an ArduCopter holds at most {MOST_ITEMS}, or"
            f" {_most(ARDUCOPTER.most_items)} with less storage: plan with fewer points or shorter loops"
        )
    if points > most_points:
        raise LinkError(
            f"robot {robot}: its fence has {points} points; an ArduCopter holds at most {most_points}: draw area and"
            " obstacles with fewer corners, or obstacles as circles, which are one point each"
        )
    if len(rally) > MOST_RALLY:
        raise LinkError(
            f"robot {robot}: there are {len(rally)} rally points (fleet.rally_points); an ArduCopter holds at most"
            f" {MOST_RALLY}"
        )


def _most(fact: Fact | None) -> int:
    assert fact is not None
    return int(fact.value)


def _corners(ring: Ring, projection: Projection) -> Corners:
    lon, lat = projection.to_degrees(*zip(*ring, strict=True))
    places = np.round(np.column_stack([lat, lon]) * DEGREES).astype(np.int64).tolist()
    return tuple((north, east) for north, east in places)


def item_of(read: Any) -> WireItem:
    """An item that MAVSDK has read back."""
    params = (float(read.param1), float(read.param2), float(read.param3), float(read.param4))
    return WireItem(int(read.seq), int(read.command), int(read.frame), params, int(read.x), int(read.y), float(read.z))


def item_differences(sent: Sequence[WireItem], held: Sequence[WireItem], autopilot: Autopilot) -> list[str]:
    """A sentence for each item that differs. Of items without a place only the parameters count.

    ArduPilot keeps a home of its own as item 0, and heights as whole centimetres, cut off (AP_Mission.cpp, ``alt =
    packet.z * 100``). What was left open (NaN) may come back as anything.
    """
    if len(sent) != len(held):
        return [f"it holds {len(held)} items of {len(sent)}"]
    first, height_m = (1, CENTIMETRE_M) if autopilot == "ardupilot" else (0, 0.0)
    pairs = zip(sent[first:], held[first:], strict=True)
    return [f"item {was.seq}: {told}" for was, have in pairs if (told := _item_difference(was, have, height_m))]


def rally_differences(sent: Sequence[WireItem], held: Sequence[WireItem]) -> list[str]:
    """A sentence for each rally point that differs; ArduPilot keeps their heights as whole metres."""
    if len(sent) != len(held):
        return [f"it holds {len(held)} rally points of {len(sent)}"]
    pairs = zip(sent, held, strict=True)
    return [told for was, have in pairs if (told := _item_difference(was, have, 1.0))]


def _item_difference(was: WireItem, have: WireItem, height_m: float) -> str:
    """How an item that a vehicle holds differs from the one sent, in words; empty where it does not."""
    if (was.seq, was.command) != (have.seq, have.command):
        return f"it holds command {have.command} as item {have.seq}; {was.command} ({NAMES[was.command]}) was sent"
    name = NAMES[was.command]
    for number, (value, kept) in enumerate(zip(was.params, have.params, strict=True), start=1):
        if not math.isnan(value) and value != kept:
            return f"{name}, parameter {number}: it holds {kept:g}; {value:g} was sent"
    if was.command not in WITH_PLACE:
        return ""
    if was.frame != have.frame and not {was.frame, have.frame} <= RELATIVE_ALTITUDE:
        return f"{name}: it holds frame {have.frame}; {was.frame} was sent"
    # not the other way round: a height that is NaN differs
    if (was.x, was.y) != (have.x, have.y) or not abs(was.z - have.z) <= height_m:
        return f"{name}: it holds {_place(have)}; {_place(was)} was sent"
    return ""


def _place(item: WireItem) -> str:
    return f"{item.x / DEGREES:.7f}, {item.y / DEGREES:.7f} at {item.z:g} m"


def fence_differences(sent: Sequence[WireShape], held: Sequence[WireShape]) -> list[str]:
    """A sentence for each polygon or circle that differs."""
    if len(sent) != len(held):
        return [f"its fence has {len(held)} polygons and circles of {len(sent)}"]
    pairs = enumerate(zip(sent, held, strict=True), start=1)
    names = ("polygon", "circle")
    return [
        f"{names[was.radius_m > 0]} {number} of its fence is another one"
        for number, (was, have) in pairs
        if was != have
    ]


POLYGON_KEEPS_IN = {5001: True, 5002: False}  # commands of a fence's corners, each with the polygon's count as param1
CIRCLE_KEEPS_IN = {5003: True, 5004: False}  # commands of its circles, each with the radius as param1


def shapes_of(items: Sequence[Any]) -> list[WireShape]:
    """The shapes of a fence as MAVSDK has read its items back; what is none counts as one without corners."""
    found: list[WireShape] = []
    rest = list(items)
    while rest:
        if rest[0].command in CIRCLE_KEEPS_IN:
            circle = rest.pop(0)
            place = (int(circle.x), int(circle.y))
            found.append(WireShape(CIRCLE_KEEPS_IN[circle.command], (place,), float(circle.param1)))
            continue
        keeps_in, count = POLYGON_KEEPS_IN.get(rest[0].command), rest[0].param1
        size = int(count) if keeps_in is not None and 3 <= count <= len(rest) else 1
        whole = size > 1 and all(item.command == rest[0].command for item in rest[:size])
        corners = tuple((int(item.x), int(item.y)) for item in rest[:size]) if whole else ()
        found.append(WireShape(bool(keeps_in), corners))
        rest = rest[size:]
    return found

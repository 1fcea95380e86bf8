"""What a MAVLink vehicle is to hold, in the forms in which MAVSDK sends it, and its rally points read and cleared."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from rota.errors import LinkError
from rota.links.mavlink_items import DEGREES, WireItem, WireShape, item_of
from rota.links.mavlink_vehicle import TRIES, MavlinkVehicle

MISSION, RALLY = 0, 2  # MAV_MISSION_TYPE


def as_sent(items: Sequence[WireItem], kind: int) -> list[Any]:
    """The items of a mission of some kind."""
    from mavsdk.plugins.mission_raw import MissionItem

    return [
        MissionItem(
            item.seq, item.frame, item.command, int(item.seq == 0), 1, *item.params, item.x, item.y, item.z, kind
        )
        for item in items
    ]


def fence_as_sent(shapes: Sequence[WireShape]) -> Any:
    """The polygons and circles of a fence."""
    from mavsdk.plugins.geofence import Circle, FenceType, GeofenceData, Point, Polygon

    def points(shape: WireShape) -> list[Any]:
        return [Point(lat / DEGREES, lon / DEGREES) for lat, lon in shape.corners]

    kinds = {True: FenceType.INCLUSION, False: FenceType.EXCLUSION}
    polygons = [Polygon(points(shape), kinds[shape.keeps_in]) for shape in shapes if not shape.radius_m]
    circles = [Circle(points(shape)[0], shape.radius_m, kinds[shape.keeps_in]) for shape in shapes if shape.radius_m]
    return GeofenceData(polygons, circles)


async def read_rally_points(vehicle: MavlinkVehicle) -> list[WireItem]:
    """Those that it holds."""
    raw = vehicle.plugin("mission_raw", "MissionRaw")
    (points,) = await vehicle.ask("reading the rally points", raw.download_rallypoints_async)
    return [item_of(point) for point in points]


async def clear_rally_points(vehicle: MavlinkVehicle) -> None:
    """Take them away; LinkError where it holds some all the same. MAVSDK has no call for that."""
    from mavsdk.plugins.mavlink_direct import MavlinkMessage

    system = vehicle.system.get_system_id()
    fields = {"target_system": system, "target_component": 1, "mission_type": RALLY}
    clear = MavlinkMessage("MISSION_CLEAR_ALL", 0, 0, system, 1, json.dumps(fields))
    for _ in range(TRIES):
        if not await read_rally_points(vehicle):
            return
        vehicle.plugin("mavlink_direct", "MavlinkDirect").send_message(clear)
    if await read_rally_points(vehicle):
        raise LinkError(f"robot {vehicle.robot}: clearing the rally points: it still holds some")

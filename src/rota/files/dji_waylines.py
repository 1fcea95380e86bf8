"""Plan -> DJI WPML: a KMZ for each robot with template.kml and waylines.wpml, which DJI's ground stations fly.

Format: DJI Cloud API, "DJI WPML" (overview, template.kml, waylines.wpml, common elements), version 1.0.2. A wayline
ends, since it cannot jump back: it holds a number of whole rounds.
"""

from __future__ import annotations

import io
import math
import os
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.files.geodesy import Projection, projection_of
from rota.files.robot_files import write_contents
from rota.files.timed_places import START
from rota.files.xml_text import decimal_text
from rota.model.plan import Plan, Trajectory
from rota.model.planner_settings import Settings, setting
from rota.routes.driven_route import DURATION_S, from_start, rounds_within, with_whole_waits
from rota.routes.flights import ends_on_charger
from rota.routes.route import RouteStop, route_of, start_height_m

TEMPLATE, WAYLINES = "wpmz/template.kml", "wpmz/waylines.wpml"
KML_NAMESPACE, WPML_NAMESPACE = "http://www.opengis.net/kml/2.2", "http://www.dji.com/wpmz/1.0.2"
MOST_WAYPOINTS = 65536  # wpml:index is 0 to 65535
MOST_SPEED_M_S = 15.0  # wpml:globalTransitionalSpeed is at most 15, as is the speed of waylines in DJI Pilot 2
LEAST_TAKEOFF_M, MOST_TAKEOFF_M = 2.0, 1500.0  # wpml:takeOffSecurityHeight
SHARE_OF_LEG = 0.4  # both turns of a leg take less than the leg
TURN_M = 0.2  # how far from a waypoint a turn may begin; the least that DJI Pilot 2 offers
ZIPPED_AT = (1980, 1, 1, 0, 0, 0)  # fixed, so that the same plan gives the same file

HEAD = f'<kml xmlns="{KML_NAMESPACE}" xmlns:wpml="{WPML_NAMESPACE}"><Document>\n'
HEADING = (
    "<wpml:waypointHeadingMode>followWayline</wpml:waypointHeadingMode>"
    "<wpml:waypointHeadingPathMode>followBadArc</wpml:waypointHeadingPathMode>"
)
PASSING, STOPPING = "coordinateTurn", "toPointAndStopWithDiscontinuityCurvature"

# wpml:droneEnumValue and wpml:droneSubEnumValue
DRONES = {
    "M300": (60, 0), "M350": (89, 0), "M30": (67, 0), "M30T": (67, 1), "M3E": (77, 0), "M3T": (77, 1), "M3M": (77, 2),
    "M3D": (91, 0), "M3TD": (91, 1), "M4E": (99, 0), "M4T": (99, 1),
}  # fmt: skip
# the longest flights that DJI tells of each model
MOST_MINUTES = {
    "M300": 55, "M350": 55, "M30": 41, "M30T": 41, "M3E": 45, "M3T": 45, "M3M": 43, "M3D": 50, "M3TD": 50, "M4E": 49,
    "M4T": 49,
}  # fmt: skip
DroneName = Literal["M300", "M350", "M30", "M30T", "M3E", "M3T", "M3M", "M3D", "M3TD", "M4E", "M4T"]


@dataclass(frozen=True, kw_only=True)
class WaylineSettings(Settings):
    """Settings of the export."""

    place: ClassVar[str] = "--set"
    duration_s: float = setting(DURATION_S, "how long aircraft go on: whole rounds that end within it", above=0)
    drone: DroneName = setting("M3E", "the model of the aircraft, which DJI's ground stations compare")


class Waypoint(NamedTuple):
    """Degrees, metres over the take-off point, the speed from here on in m/s, the wait here in whole seconds.

    turn_m: within so many metres of it the aircraft may turn, passing by; 0: it stops at the very point.
    """

    lon: float
    lat: float
    height_m: float
    speed_m_s: float
    hold_s: int
    turn_m: float


def write_dji_waylines(
    plan: Plan, folder: str | os.PathLike[str], settings: WaylineSettings | None = None
) -> tuple[Path, ...]:
    """Write one ``ROBOT.kmz`` per robot into ``folder`` (made if missing); returns their paths.

    Raises PlanError for a mission without an origin, for speeds, heights and numbers of waypoints beyond DJI's, and for
    robots whose names give the same file name; RotaError when the folder cannot be written to. Nothing is written on
    errors of the plan.
    """
    settings = settings or WaylineSettings()
    projection = projection_of(plan.mission, "DJI WPML")
    return write_contents(plan, folder, lambda trajectory: {".kmz": kmz_of(plan, trajectory, projection, settings)})


def waypoints_of(plan: Plan, trajectory: Trajectory, projection: Projection, duration_s: float) -> list[Waypoint]:
    """One robot's waypoints: the approach from its start, then whole rounds; for one that stays the last is its place.

    A waypoint's speed is that of the leg after it, as in WPML. DJI's aircraft wait whole seconds only: what is left of
    a wait makes the leg before it slower. Where the robot does not wait it turns within 0.2 m of the point, or where
    its curve past a planned corner begins, or less where legs are short: stopping at every point would take more time
    than planned. A robot that never moves has two waypoints, the first a metre higher; a wayline has two at least.
    """
    route = route_of(trajectory, start_height_m(trajectory, plan.mission.fleet.altitude_m))
    once, every_round = from_start(route), route.every_round
    rounds = rounds_within(route, duration_s)
    if len(once) + len(every_round) > MOST_WAYPOINTS:
        raise PlanError(
            f"robot {trajectory.robot}: its approach and one round have {len(once) + len(every_round)} waypoints; a DJI"
            f" wayline has at most {MOST_WAYPOINTS}"
        )
    if every_round:
        rounds = min(rounds, (MOST_WAYPOINTS - len(once)) // len(every_round))
    stops = with_whole_waits([*once, *(every_round * rounds)])
    if len(stops) == 1:
        x, y, height_m = stops[0].place_m
        stops = [RouteStop(place_m=(x, y, height_m + 1), speed_m_s=None), replace(stops[0], speed_m_s=1.0)]
    return _on_globe(trajectory.robot, stops, projection)


def _on_globe(robot: str, stops: Sequence[RouteStop], projection: Projection) -> list[Waypoint]:
    """The stops as waypoints in degrees, with speeds, waits and how early turns begin."""
    places_m = np.array([stop.place_m for stop in stops])
    lon, lat = projection.to_degrees(places_m[:, 0], places_m[:, 1])
    legs_m = np.linalg.norm(np.diff(places_m, axis=0), axis=1)
    # what is driven at the most that DJI takes is above it by rounding
    speeds_m_s = [
        MOST_SPEED_M_S if math.isclose(speed, MOST_SPEED_M_S, rel_tol=1e-9) else speed
        for speed in (stop.speed_m_s or 0.0 for stop in stops[1:])
    ]
    _require_flyable(robot, max(speeds_m_s), float(places_m[:, 2].max()))
    begin_m = np.maximum(TURN_M, [stop.curve_m for stop in stops[1:-1]])
    turns_m = np.minimum(begin_m, SHARE_OF_LEG * np.minimum(legs_m[:-1], legs_m[1:])).tolist()
    passing = [turn_m if stop.hold_s == 0 else 0.0 for stop, turn_m in zip(stops[1:-1], turns_m, strict=True)]
    columns = (
        lon.tolist(),
        lat.tolist(),
        places_m[:, 2].tolist(),
        [*speeds_m_s, speeds_m_s[-1]],
        [int(stop.hold_s) for stop in stops],
        [0.0, *passing, 0.0],
    )
    return [Waypoint(*row) for row in zip(*columns, strict=True)]


def _require_short(robot: str, lasts_s: float, drone: str) -> None:
    """Raise PlanError for a flight of so many seconds that is longer than an aircraft of the model flies."""
    most_s = 60.0 * MOST_MINUTES[drone]
    if lasts_s > most_s:
        raise PlanError(
            f"robot {robot}: its flight takes {lasts_s / 60:.1f} min; an {drone} flies for {MOST_MINUTES[drone]} min at"
            " most: plan with a lower fleet.endurance_s"
        )


def _require_flyable(robot: str, speed_m_s: float, height_m: float) -> None:
    """Raise PlanError for a highest speed or height beyond DJI's."""
    if speed_m_s > MOST_SPEED_M_S:
        raise PlanError(
            f"robot {robot}: a leg at {speed_m_s:.6g} m/s; DJI waylines take at most {MOST_SPEED_M_S:g} m/s: plan with"
            " a lower fleet.speed_m_s"
        )
    if height_m > MOST_TAKEOFF_M:
        raise PlanError(
            f"robot {robot}: a place {height_m:.6g} m over the take-off point; DJI waylines take at most"
            f" {MOST_TAKEOFF_M:g} m"
        )


# ---------------------------------------------------------------- files


def kmz_of(plan: Plan, trajectory: Trajectory, projection: Projection, settings: WaylineSettings) -> bytes:
    """The archive with both documents."""
    waypoints = waypoints_of(plan, trajectory, projection, settings.duration_s)
    finish = "noAction" if trajectory.loop_duration_s == 0 else "goHome"
    if ends_on_charger(trajectory):
        _require_short(trajectory.robot, trajectory.charges[-1].from_s, settings.drone)
        finish = "autoLand"
    config = _mission_config(waypoints, settings.drone, finish)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, parts in (
            (TEMPLATE, _template(waypoints, config, plan.mission.fleet.altitude_m)),
            (WAYLINES, _waylines(waypoints, config)),
        ):
            text = f'<?xml version="1.0" encoding="UTF-8"?>\n{HEAD}{"".join(parts)}</Document></kml>\n'
            archive.writestr(zipfile.ZipInfo(name, ZIPPED_AT), text, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _mission_config(waypoints: list[Waypoint], drone: str, finish: str) -> str:
    """The block that tells the drone, its take-off height and what it does at the end."""
    kind, subkind = DRONES[drone]
    safe_m = min(max(waypoints[0].height_m, LEAST_TAKEOFF_M), MOST_TAKEOFF_M)
    speed_m_s = max(waypoint.speed_m_s for waypoint in waypoints)
    # who patrols flies home when all rounds are flown; who watches one place stays there; who charges lands to do so
    return (
        "<wpml:missionConfig>\n<wpml:flyToWaylineMode>safely</wpml:flyToWaylineMode>\n"
        f"<wpml:finishAction>{finish}</wpml:finishAction>\n"
        "<wpml:exitOnRCLost>executeLostAction</wpml:exitOnRCLost>\n"
        "<wpml:executeRCLostAction>goBack</wpml:executeRCLostAction>\n"
        f"<wpml:takeOffSecurityHeight>{safe_m!r}</wpml:takeOffSecurityHeight>\n"
        f"<wpml:globalTransitionalSpeed>{speed_m_s!r}</wpml:globalTransitionalSpeed>\n"
        f"<wpml:droneInfo><wpml:droneEnumValue>{kind}</wpml:droneEnumValue>"
        f"<wpml:droneSubEnumValue>{subkind}</wpml:droneSubEnumValue></wpml:droneInfo>\n"
        "</wpml:missionConfig>\n"
    )


def _template(waypoints: list[Waypoint], config: str, altitude_m: float) -> Iterator[str]:
    """What DJI's ground stations show and edit, and make the waylines of again."""
    made_ms = int(START.timestamp() * 1000)
    yield f"<wpml:author>Rota</wpml:author>\n<wpml:createTime>{made_ms}</wpml:createTime>\n"
    yield f"<wpml:updateTime>{made_ms}</wpml:updateTime>\n{config}<Folder>\n"
    yield "<wpml:templateType>waypoint</wpml:templateType>\n<wpml:templateId>0</wpml:templateId>\n"
    yield (
        "<wpml:waylineCoordinateSysParam><wpml:coordinateMode>WGS84</wpml:coordinateMode>"
        "<wpml:heightMode>relativeToStartPoint</wpml:heightMode></wpml:waylineCoordinateSysParam>\n"
    )
    yield f"<wpml:autoFlightSpeed>{waypoints[0].speed_m_s!r}</wpml:autoFlightSpeed>\n"
    yield "<wpml:gimbalPitchMode>manual</wpml:gimbalPitchMode>\n"
    yield f"<wpml:globalHeight>{altitude_m!r}</wpml:globalHeight>\n"
    yield f"<wpml:globalWaypointHeadingParam>{HEADING}</wpml:globalWaypointHeadingParam>\n"
    yield f"<wpml:globalWaypointTurnMode>{STOPPING}</wpml:globalWaypointTurnMode>\n"
    yield "<wpml:globalUseStraightLine>1</wpml:globalUseStraightLine>\n"
    groups = iter(range(len(waypoints)))
    for index, waypoint in enumerate(waypoints):
        yield (
            f"<Placemark><Point><coordinates>{_coordinates(waypoint)}</coordinates></Point>\n"
            f"<wpml:index>{index}</wpml:index>"
            f"<wpml:ellipsoidHeight>{waypoint.height_m!r}</wpml:ellipsoidHeight>"
            f"<wpml:height>{waypoint.height_m!r}</wpml:height>"
            "<wpml:useGlobalHeight>0</wpml:useGlobalHeight><wpml:useGlobalSpeed>0</wpml:useGlobalSpeed>"
            f"<wpml:waypointSpeed>{waypoint.speed_m_s!r}</wpml:waypointSpeed>"
            "<wpml:useGlobalHeadingParam>1</wpml:useGlobalHeadingParam>"
            f"<wpml:useGlobalTurnParam>0</wpml:useGlobalTurnParam>{_turn(waypoint)}"
            f"<wpml:useStraightLine>1</wpml:useStraightLine>{_wait(waypoint, index, groups)}</Placemark>\n"
        )
    yield "</Folder>\n"


def _waylines(waypoints: list[Waypoint], config: str) -> Iterator[str]:
    """What the aircraft flies."""
    yield f"{config}<Folder>\n<wpml:templateId>0</wpml:templateId>\n"
    yield "<wpml:executeHeightMode>relativeToStartPoint</wpml:executeHeightMode>\n"
    yield "<wpml:waylineId>0</wpml:waylineId>\n"
    yield f"<wpml:autoFlightSpeed>{waypoints[0].speed_m_s!r}</wpml:autoFlightSpeed>\n"
    groups = iter(range(len(waypoints)))
    for index, waypoint in enumerate(waypoints):
        yield (
            f"<Placemark><Point><coordinates>{_coordinates(waypoint)}</coordinates></Point>\n"
            f"<wpml:index>{index}</wpml:index><wpml:executeHeight>{waypoint.height_m!r}</wpml:executeHeight>"
            f"<wpml:waypointSpeed>{waypoint.speed_m_s!r}</wpml:waypointSpeed>"
            f"<wpml:waypointHeadingParam>{HEADING}</wpml:waypointHeadingParam>{_turn(waypoint)}"
            f"<wpml:useStraightLine>1</wpml:useStraightLine>{_wait(waypoint, index, groups)}</Placemark>\n"
        )
    yield "</Folder>\n"


def _coordinates(waypoint: Waypoint) -> str:
    return f"{decimal_text(waypoint.lon)},{decimal_text(waypoint.lat)}"


def _turn(waypoint: Waypoint) -> str:
    """How a waypoint is passed: by a curve, or with a stop."""
    mode = PASSING if waypoint.turn_m else STOPPING
    return (
        f"<wpml:waypointTurnParam><wpml:waypointTurnMode>{mode}</wpml:waypointTurnMode>"
        + (
            f"<wpml:waypointTurnDampingDist>{waypoint.turn_m!r}</wpml:waypointTurnDampingDist>"
            if waypoint.turn_m
            else ""
        )
        + "</wpml:waypointTurnParam>"
    )


def _wait(waypoint: Waypoint, index: int, groups: Iterator[int]) -> str:
    """A group of one action that hovers; nothing where there is no wait."""
    if not waypoint.hold_s:
        return ""
    return (
        f"\n<wpml:actionGroup><wpml:actionGroupId>{next(groups)}</wpml:actionGroupId>"
        f"<wpml:actionGroupStartIndex>{index}</wpml:actionGroupStartIndex>"
        f"<wpml:actionGroupEndIndex>{index}</wpml:actionGroupEndIndex>"
        "<wpml:actionGroupMode>sequence</wpml:actionGroupMode>"
        "<wpml:actionTrigger><wpml:actionTriggerType>reachPoint</wpml:actionTriggerType></wpml:actionTrigger>"
        "<wpml:action><wpml:actionId>0</wpml:actionId><wpml:actionActuatorFunc>hover</wpml:actionActuatorFunc>"
        f"<wpml:actionActuatorFuncParam><wpml:hoverTime>{waypoint.hold_s}</wpml:hoverTime>"
        "</wpml:actionActuatorFuncParam></wpml:action></wpml:actionGroup>"
    )

"""Where robots start, come in, and moving obstacles go: to local metres, with starts dealt to the robots."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

from shapely import MultiPolygon

from rota.errors import MissionError
from rota.files.blocks import Fault
from rota.files.geodesy import Projection
from rota.files.map_entrances import entrances_on_map
from rota.files.mission_fleet import Values, listed_robots
from rota.files.mission_ground import Ground
from rota.files.yaml_text import Place
from rota.model.mission import (
    Charger,
    Fleet,
    Mission,
    StartBox,
    StartPoints,
    charger_faults,
    corner_faults,
    sensor_faults,
    start_faults,
)
from rota.model.planner_registry import DEFAULT
from rota.model.refusals import path_of
from rota.planning.planner import planner_named

START: Place = ("fleet", "start")
ENTRANCES: Place = ("fleet", "entrances")
RALLY_POINTS: Place = ("fleet", "rally_points")
Made = TypeVar("Made")


class _Written(NamedTuple):
    """A start as the file has it, and where it stands there."""

    place: Place
    point: tuple[float, float]


def fleet_at_its_starts(fleet: Fleet, file: Values, ground: Ground) -> tuple[Fleet, list[Fault]]:
    """The fleet with its starts and entrances in local metres, and what is wrong with them.

    Named robots without a start of their own take the points in their order, one each. A fleet with faults is returned
    without starts and entrances.
    """
    block = file["fleet"]
    to_metres = _Metres(ground, in_degrees=file.get("coordinates") == "wgs84")
    try:
        if fleet.robots is None:
            placed, where = _placed_fewest(fleet, block, to_metres)
        else:
            placed, where = _placed_robots(fleet, block, to_metres)
        rally_points = _places(block, RALLY_POINTS, to_metres) or ()
        placed = replace(placed, entrances=_places(block, ENTRANCES, to_metres), rally_points=rally_points)
        if (inside := _inside(file)) is not None:
            placed = replace(placed, entrances=entrances_on_map(inside, placed, ground.area, _blocking(ground)))
    except _Misplaced as error:
        return fleet, error.faults
    faults = start_faults(ground.area, _blocking(ground), placed) + corner_faults(
        ground.area, _blocking(ground), placed
    )
    faults += charger_faults(ground.area, _blocking(ground), placed, in_metres(Charger, "chargers", "at", file, ground))
    faults += sensor_faults(ground.zones, placed)
    if faults:
        where |= {f"fleet.entrances[{k}]": (*ENTRANCES, k) for k in range(len(placed.entrances or ()))}
        where |= {f"fleet.rally_points[{k}]": (*RALLY_POINTS, k) for k in range(len(placed.rally_points))}
        where |= _corner_places(block) | {"chargers": ("chargers",), "fleet.recharge_s": ("fleet", "recharge_s")}
        where |= {f"zones[{k}].sensors": ("zones", k, "sensors") for k in range(len(ground.zones))}
        for k in range(len(file.get("chargers", ()))):
            where |= {f"chargers[{k}].{name}": ("chargers", k, name) for name in ("name", "at")}
        return fleet, [
            Fault(where[field], f"its corner_m of {message}" if where[field][-1] == "vehicle" else message)
            for field, message in faults
        ]
    return placed, []


def entrance_warnings(mission: Mission, file: Values) -> list[Fault]:
    """A warning where no body fits at the point inside a map, so that robots come in elsewhere."""
    inside, entrances = _inside(file), mission.fleet.entrances
    if inside is None or entrances is None or entrances[0] == inside:
        return []
    (x, y), away_m = entrances[0], math.dist(inside, entrances[0])
    return [Fault(("area", "inside"), f"no body fits there; robots come in at [{x:.6g}, {y:.6g}], {away_m:.3g} m away")]


def in_metres(kind: type[Made], key: str, place: str, file: Values, ground: Ground) -> tuple[Made, ...]:
    """What a list of the file makes, each with its ``place``, one or several, in local metres.

    Raises MissionError for places that no projection holds, and as what is made does, each with its number in the list.
    """
    to_metres = _Metres(ground, in_degrees=file.get("coordinates") == "wgs84")
    made = []
    for k, block in enumerate(file.get(key, ())):
        at: Any = block[place]
        try:
            if isinstance(at[0], tuple):
                at = tuple(to_metres(_Written((key, k, place, j), one)) for j, one in enumerate(at))
            else:
                at = to_metres(_Written((key, k, place), at))
            made.append(kind(**{**block, place: at}))
        except _Misplaced as error:
            raise MissionError(*(f"{key}[{k}]: {fault.message}" for fault in error.faults)) from None
        except MissionError as error:
            raise MissionError(*(f"{key}[{k}]: {fault}" for fault in error.faults)) from None
    return tuple(made)


def _inside(file: Values) -> tuple[float, float] | None:
    """The point in a map at which robots come in; None where there is no map, or the fleet says where they may be."""
    if "entrances" in file["fleet"] or not isinstance(file["area"], dict):
        return None
    heeded = planner_named(file.get("planner", DEFAULT)).settings.heeds_entrances
    return file["area"].get("inside") if heeded else None


def _blocking(ground: Ground) -> list[MultiPolygon]:
    """The shapes of what blocks motion."""
    return [obstacle.shape for obstacle in ground.obstacles if obstacle.blocks_motion]


class _Misplaced(Exception):  # noqa: N818 (the reader of the starts catches it)
    def __init__(self, *faults: Fault) -> None:
        self.faults = list(faults)


class _Metres:
    """From coordinates as written to local metres."""

    def __init__(self, ground: Ground, *, in_degrees: bool) -> None:
        self._projection = Projection(ground.origin) if in_degrees and ground.origin is not None else None

    def __call__(self, written: _Written) -> tuple[float, float]:
        x, y = written.point
        if self._projection is None:
            return x, y
        try:
            east, north = self._projection.to_metres([x], [y])
        except MissionError as error:
            raise _Misplaced(*(Fault(written.place, fault) for fault in error.faults)) from None
        return float(east[0]), float(north[0])


def _corner_places(block: Values) -> dict[str, Place]:
    """Where corners that are cut stand: where they are given, else with the vehicle that presets them."""
    blocks: list[tuple[Place, Values]] = [(("fleet",), block)]
    blocks += [(("fleet", "robots", k), robot) for k, robot in enumerate(listed_robots(block))]
    return {
        f"{path_of(place)}.corner_m": (*place, "corner_m" if each.get("corner_m") is not None else "vehicle")
        for place, each in blocks
    }


def _box(block: Values, to_metres: _Metres) -> StartBox | None:
    box = (block.get("start") or {}).get("box")
    if box is None:
        return None
    low, high = (to_metres(_Written((*START, "box"), point)) for point in box)
    return StartBox(low_m=low, high_m=high)


def _places(block: Values, place: Place, to_metres: _Metres) -> tuple[tuple[float, float], ...] | None:
    given = block.get(str(place[-1]))
    if given is None:
        return None
    return tuple(to_metres(_Written((*place, k), point)) for k, point in enumerate(given))


def _points(block: Values) -> list[_Written]:
    points = (block.get("start") or {}).get("points")
    return [_Written((*START, "points", k), point) for k, point in enumerate(points or [])]


def _placed_fewest(fleet: Fleet, block: Values, to_metres: _Metres) -> tuple[Fleet, dict[str, Place]]:
    where: dict[str, Place] = {"fleet.start.box": (*START, "box")}
    points = _points(block)
    if not points:
        return replace(fleet, start=_box(block, to_metres)), where
    where |= {f"fleet.start.points[{k}]": written.place for k, written in enumerate(points)}
    return replace(fleet, start=StartPoints(points_m=tuple(map(to_metres, points)))), where


def _placed_robots(fleet: Fleet, block: Values, to_metres: _Metres) -> tuple[Fleet, dict[str, Place]]:
    """Listed robots at their own starts, or at the points in their order, and where each start stands."""
    assert fleet.robots is not None
    written: list[_Written | None] = [None] * len(fleet.robots)
    for k, robot in enumerate(listed_robots(block)):
        if robot.get("start") is not None:
            written[k] = _Written(("fleet", "robots", k, "start"), robot["start"])
    points = _points(block)
    waiting = [k for k, start in enumerate(written) if start is None]
    if points and len(points) != len(waiting):
        message = (
            f"{len(points)} points for {len(waiting)} robots without a start of their own; as many points as robots"
            " are needed"
        )
        raise _Misplaced(Fault((*START, "points"), message))
    for k, point in zip(waiting, points, strict=False):
        written[k] = point
    box = _box(block, to_metres)
    if box is not None and not waiting:
        raise _Misplaced(Fault(START, "every robot has a start of its own: remove it"))
    robots = [
        robot if start is None else replace(robot, start=to_metres(start))
        for robot, start in zip(fleet.robots, written, strict=True)
    ]
    where: dict[str, Place] = {"fleet.start.box": (*START, "box")}
    where |= {f"fleet.robots[{k}].start": start.place for k, start in enumerate(written) if start is not None}
    return replace(fleet, robots=tuple(robots), start=box), where

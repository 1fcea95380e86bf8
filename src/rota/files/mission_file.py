"""Mission files, YAML 1.2 or JSON, to missions; every fault at once, with file, line, column and field."""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from shapely import MultiPolygon, unary_union

from rota.errors import MissionError
from rota.files.blocks import Fault, lines_of_faults, read_block
from rota.files.json_schema import file_schema
from rota.files.local_file import read_text
from rota.files.mission_fleet import fleet_faults, fleet_of, fleet_warnings, listed_robots
from rota.files.mission_ground import Ground, read_ground
from rota.files.mission_schema import mission_block
from rota.files.mission_starts import entrance_warnings, fleet_at_its_starts, in_metres
from rota.files.yaml_text import Document, Place, parse_text
from rota.model.fields import fields_of
from rota.model.mission import (
    NO_PERIOD,
    NOTHING_MATTERS,
    Charger,
    DiscSensor,
    Lane,
    Mission,
    MovingObstacle,
    PlannerSettings,
    Sensor,
    inner_reach_m,
)
from rota.model.planner_registry import DEFAULT
from rota.planning.planner import planner_named

Values = dict[str, Any]  # of a block of the file, those that are given, by their names

MOST_CELLS = 50e6
CELLS_PER_REACH = 4  # a lattice coarser than a quarter of the sensor's reach plans badly


class JudgedDocument(NamedTuple):
    """What a document comes to: its mission, or what is wrong with it; the ground, where that can be read all the same.

    ``contradictions``: what the mission as a whole was refused for, each with its field in words.
    """

    mission: Mission | None
    ground: Ground | None
    faults: list[Fault]
    contradictions: tuple[str, ...]
    warnings: list[Fault]


class ReadMission(NamedTuple):
    """A mission, and what its author should know about the way it was read (``file:line:column: field: ...``)."""

    mission: Mission
    warnings: tuple[str, ...]


def read_mission(path: str | Path, *, overrides: Mapping[str, Any] | None = None, confine: bool = False) -> ReadMission:
    """Read a mission file (.yaml, .yml, or .json), with the GeoJSON files and maps that it names.

    overrides: values that replace the file's, by field path, such as ``{"patrol.effort": "quick", "fleet.robots": 4}``;
    items of lists go by their number from 0 or their name (``zones.gate.period_s``).
    confine: refuse paths that leave the mission file's folder, for missions that came over the network.

    Raises MissionError with one line per fault, all at once: ``file:line:column: path.to.field: what is wrong, what is
    allowed``. A value from ``overrides`` is at fault under the name ``override`` in place of file, line and column.
    """
    return mission_of(mission_document(path), Path(path).parent, overrides=overrides, confine=confine)


def mission_document(path: str | Path) -> Document:
    """The text of a mission file parsed, as yet without a look at what it says; MissionError where it is no YAML."""
    what = "a mission file"
    return parse_text(read_text(Path(path), what), str(path), what + " ('rota new' writes an example)")


def mission_of(
    document: Document, folder: Path, *, overrides: Mapping[str, Any] | None = None, confine: bool = False
) -> ReadMission:
    """The mission of a parsed file whose paths begin at ``folder``; for the rest as ``read_mission``."""
    document = _override(document, overrides or {})
    judged = judge_document(document, folder, confine=confine)
    if judged.mission is None:
        faults = lines_of_faults(document, judged.faults)
        raise MissionError(
            *(faults or (f"{document.name}: {contradiction}" for contradiction in judged.contradictions))
        )
    return ReadMission(judged.mission, tuple(lines_of_faults(document, judged.warnings)))


def judge_document(document: Document, folder: Path, *, confine: bool) -> JudgedDocument:
    """The mission of a parsed document whose paths begin at ``folder``, or all its faults, each with its place.

    confine: refuse paths that leave the folder.
    """
    file, faults = read_block(mission_block(document.value), document.value)
    file = None if faults else file
    ground, ground_faults, warnings = read_ground(document.value, folder, confine=confine)
    faults += ground_faults
    if file is not None:
        faults += _period_faults(file, ground)
        if file.get("importance") == 0 and ground is not None and not any(zone.importance for zone in ground.zones):
            faults.append(Fault(("importance",), NOTHING_MATTERS))
        wrong = fleet_faults(file["fleet"])
        faults += wrong
        if ground is not None:
            faults += _sensor_faults(file, ground)
            if not wrong:
                faults += fleet_at_its_starts(fleet_of(file["fleet"]), file, ground)[1]
    if faults or file is None or ground is None:
        return JudgedDocument(None, ground, faults, (), warnings)
    try:
        mission = _mission(file, ground)
    except MissionError as error:
        return JudgedDocument(None, ground, [], error.faults, warnings)
    warnings += [*fleet_warnings(file["fleet"]), *_blind(mission), *entrance_warnings(mission, file)]
    return JudgedDocument(mission, ground, [], (), warnings)


def _blind(mission: Mission) -> list[Fault]:
    """A warning of sensors that reach no farther than the bodies that carry them."""
    fleet = mission.fleet
    robots = fleet.unlike_robots
    blind = [robot for robot in robots if inner_reach_m(robot.sensor) <= robot.body_radius_m]
    if not blind:
        return []
    reach_m, body_m = inner_reach_m(blind[0].sensor), blind[0].body_radius_m
    first = f"the sensor of robot {blind[0].name} reaches {reach_m:.6g} m, no farther than its body of {body_m:.6g} m"
    others = f", and so do those of {len(blind) - 1} more" if len(blind) > 1 else ""
    return [Fault(("fleet",), f"{first}{others}: it sees no ground but what it stands on")]


def mission_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a mission file."""
    return file_schema(mission_block(), "Rota mission")


def _override(document: Document, overrides: Mapping[str, Any]) -> Document:
    if not overrides or not isinstance(document.value, dict):
        return document
    value = deepcopy(document.value)
    places = {_put(value, field, replacement) for field, replacement in overrides.items()}
    return replace(document, value=value, overridden=frozenset(places))


def _put(value: dict[str, Any], field: str, replacement: Any) -> Place:
    """Give a field of a document a value; returns the field's place. MissionError for an item that a list has not."""
    steps = field.split(".")
    block: Any = value
    place: Place = ()
    for k, step in enumerate(steps):
        key: Any = _item(block, step, field) if isinstance(block, list) else step
        place = (*place, key)
        if k == len(steps) - 1:
            block[key] = replacement
        elif isinstance(block, list):
            block = block[key]
            if not isinstance(block, dict | list):
                raise MissionError(f"override: {field}: {'.'.join(steps[: k + 1])} holds no fields")
        else:
            if not isinstance(block.get(key), dict | list):
                block[key] = {}
            block = block[key]
    return place


def _item(items: list[Any], step: str, field: str) -> int:
    """The place in a list of the item of this number, counted from 0, or of this name."""
    if step.isdecimal() and int(step) < len(items):
        return int(step)
    named = [k for k, item in enumerate(items) if isinstance(item, dict) and item.get("name") == step]
    if not named:
        raise MissionError(f"override: {field}: there is no {step!r} among its {len(items)} items")
    return named[0]


def _period_faults(file: Values, ground: Ground | None) -> list[Fault]:
    zones = ground.zones if ground is not None else ()
    periods_s = [zone.get("period_s") for zone in (file, *file.get("zones", ()))] + [zone.period_s for zone in zones]
    asked = any(period_s is not None for period_s in periods_s)
    if asked or ground is None or not _planning(file).asks_periods:
        return []
    return [Fault(("period_s",), NO_PERIOD)]


def _sensor_faults(file: Values, ground: Ground) -> list[Fault]:
    """Sensors so small that the demanded area would need more cells than memory and patience hold."""
    demanded_m2 = _demanded_ground(file, ground).area
    least_m = CELLS_PER_REACH * math.sqrt(demanded_m2 / MOST_CELLS)
    sensors: list[tuple[Place, Sensor]] = [(("fleet", "sensor"), file["fleet"]["sensor"])]
    for k, robot in enumerate(listed_robots(file["fleet"])):
        if robot.get("sensor") is not None:
            sensors.append((("fleet", "robots", k, "sensor"), robot["sensor"]))
    faults = []
    for place, sensor in sensors:
        if sensor.reach_m >= least_m:
            continue
        is_disc = isinstance(sensor, DiscSensor)
        size, least = ("radius_m", least_m) if is_disc else ("side_m", least_m * math.sqrt(2))
        # divided twice, since the square of the smallest numbers is 0
        cells = demanded_m2 * CELLS_PER_REACH**2 / sensor.reach_m / sensor.reach_m
        message = (
            f"too small for {demanded_m2:.4g} m2 to watch: about {cells / 1e6:.3g} million cells would be needed, at "
            f"most {MOST_CELLS / 1e6:.0f} million are possible; give {size} of at least {_round_up(least):.4g}, "
            "or watch less"
        )
        faults.append(Fault(place, message))
    return faults


def _demanded_ground(file: Values, ground: Ground) -> MultiPolygon:
    """Where something is asked: the smallest period rules where zones overlap, null asks nothing."""
    timed = unary_union([zone.shape for zone in ground.zones if zone.period_s is not None])
    if file.get("period_s") is not None:
        idle = unary_union([zone.shape for zone in ground.zones if zone.period_s is None])
        timed = ground.area.difference(idle).union(timed)
    return timed.difference(unary_union([obstacle.shape for obstacle in ground.obstacles if obstacle.hides_demand]))


def _round_up(value: float) -> float:
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.ceil(value / unit) * unit


def _mission(file: Values, ground: Ground) -> Mission:
    """The mission: its values as they stand, but what lies on the ground in metres, and the fleet on it."""
    values = {item.name: file[item.name] for item in fields_of(Mission) if item.name in file}
    values |= {name: getattr(ground, name) for name in ("area", "obstacles", "zones", "importance", "origin")}
    values["fleet"] = fleet_at_its_starts(fleet_of(file["fleet"]), file, ground)[0]
    values["moving_obstacles"] = in_metres(MovingObstacle, "moving_obstacles", "positions_m", file, ground)
    values["lanes"] = (*ground.lanes, *in_metres(Lane, "lanes", "line_m", file, ground))
    values["chargers"] = in_metres(Charger, "chargers", "at", file, ground)
    if ground.lanes:
        values["period_s"] = None  # it is that of the graph's places
    return Mission(**values, planning=_planning(file))


def _planning(file: Values) -> PlannerSettings:
    """The settings of the mission's planner."""
    typed_cell_m = file["area"].get("cell_m") if isinstance(file["area"], dict) else None
    planner = file.get("planner", DEFAULT)
    return planner_named(planner).settings.from_file(file.get(planner) or {}, typed_cell_m)

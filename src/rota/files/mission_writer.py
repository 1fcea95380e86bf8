"""Mission -> mission file: YAML that people can read on and that reads back as the same mission."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from shapely import MultiPolygon

from rota.errors import MissionError
from rota.files.atomic_write import write_atomically
from rota.files.mission_file import mission_of
from rota.files.mission_json import block_to_json, mission_to_json, polygons_to_json
from rota.files.mission_schema import DRIVING
from rota.files.mission_text import mission_text
from rota.files.rings import open_ring, wkt_of
from rota.files.yaml_text import parse_text
from rota.model.field_values import Json
from rota.model.fields import REQUIRED, fields_of, flat_fields_of
from rota.model.fleet import Abilities, Fleet, Kind, Robot
from rota.model.mission import Mission, Obstacle, Zone
from rota.model.planner_settings import Settings
from rota.vehicles.presets import NONE


def write_mission(mission: Mission, path: str | os.PathLike[str]) -> None:
    """Write ``mission`` to ``path`` (.yaml, .yml): whole or not at all, in local metres, without defaults.

    ``read_mission`` makes the same mission of it, all digits of its numbers included; heights of shapes' corners are
    left out. Raises MissionError where a mission file cannot say what the mission does, as of a zone that sticks out of
    the area or a period of a microsecond, and RotaError when the path cannot be written.
    """
    text = mission_text(mission_to_document(mission))
    again = mission_of(parse_text(text, os.fspath(path), "a mission"), Path(path).parent).mission
    if mission_to_json(again) != mission_to_json(mission):
        before, after = mission_to_json(mission), mission_to_json(again)
        other = ", ".join(key for key in before if before[key] != after.get(key))
        raise MissionError(f"{other}: a mission file cannot say this; zones must lie in the area")
    write_atomically(path, text)


def mission_to_document(mission: Mission) -> Json:
    """The mission as the dicts, lists and values of a mission file."""
    told = _unlike_default(mission, "area", "obstacles", "zones", "fleet", "planning")
    obstacles, zones = [_obstacle(each) for each in mission.obstacles], [_zone(each) for each in mission.zones]
    placed = {"area": _shape(mission.area), "obstacles": obstacles, "zones": zones, "fleet": _fleet(mission.fleet)}
    planner, settings = mission.planning.planner, _settings(mission.planning)
    last = {"planner": planner, planner: settings}
    return {"rota": 1, **{name: value for name, value in {**told, **placed, **last}.items() if value not in ([], {})}}


def _unlike_default(block: Any, *without: str) -> Json:
    """The fields of a block that are not at their defaults, as files have them."""
    written = block_to_json(block)
    return {
        item.name: written[item.name]
        for item in fields_of(type(block))
        if item.name not in (*without, *DRIVING) and not item.flat and getattr(block, item.name) != item.default
    }


def _settings(block: Settings) -> Json:
    """Settings other than their defaults; blocks of methods likewise."""
    told: Json = {}
    written = block_to_json(block)
    for item in fields_of(type(block)):
        value = block.value_of(item.name)
        if value != item.default:
            told[item.key or item.name] = _settings(value) if isinstance(value, Settings) else written[item.name]
    return told


def _fleet(fleet: Fleet) -> Json:
    """A fleet: a number of equal robots, or what differs of each; all that a vehicle would preset is said."""
    told = _unlike_default(fleet, "robots", "kinds")
    robots = fleet.robots or ()
    if robots == tuple(fleet.equal_robot(f"robot-{k + 1}") for k in range(len(robots))):
        listed: Any = len(robots) or "fewest"
    else:
        listed = [_able(robot, fleet) for robot in robots]
    if fleet.kinds:
        told["kinds"] = [_able(kind, fleet) for kind in fleet.kinds]
    usual = {item.name: None if item.default is REQUIRED else item.default for item in flat_fields_of(Fleet)}
    driving = _driving(fleet)
    if fleet.motion.vehicle is None:
        driving = {name: value for name, value in driving.items() if value != usual[name]}
    return {"robots": listed, **driving, **told}


def _able(robot: Robot | Kind, fleet: Fleet) -> Json:
    """A robot or a kind: its name, what else it alone has, and what it can do unlike the fleet."""
    told = _unlike_default(robot)
    own, common = _driving(robot), _driving(fleet)
    if own["vehicle"] != common["vehicle"]:
        return {**told, **own, "vehicle": own["vehicle"] or NONE.name}
    return {**told, **{name: value for name, value in own.items() if value != common[name]}}


def _driving(block: Abilities) -> Json:
    """All that a fleet, a kind or a robot can do, also where that is no limit."""
    written, able = block_to_json(block), {**vars(block), **vars(block.motion), **vars(block.battery)}
    return {name: written.get(name, able[name]) for name in DRIVING}


def _zone(zone: Zone) -> Json:
    """A zone; null for a period says that nothing is asked there."""
    name = {"name": zone.name, "period_s": zone.period_s}
    return {**name, **_shape_keys(zone.shape), **_unlike_default(zone, "name", "period_s", "shape")}


def _obstacle(obstacle: Obstacle) -> Any:
    """An obstacle, as its shape alone where it says nothing else."""
    told = _unlike_default(obstacle, "shape")
    return {**_shape_keys(obstacle.shape), **told} if told else _shape(obstacle.shape)


def _shape_keys(shape: MultiPolygon) -> Json:
    """A shape as keys beside others."""
    written = _shape(shape)
    return written if isinstance(written, dict) else {"ring": written}


def _shape(shape: MultiPolygon) -> Any:
    """A ring, one with holes, or the well-known text of several polygons."""
    polygons = polygons_to_json(shape)
    outer, *holes = polygons[0]
    if len(polygons) > 1 or any([tuple(point) for point in ring] != open_ring(ring) for ring in polygons[0]):
        return {"wkt": wkt_of(polygons)}
    return {"outer": outer, "holes": holes} if holes else outer

"""The keys of a mission file and the values they take: the fields of the model, and what only files have.

The model says what a field means and takes. Here stand the shapes of places, and what keys say together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

from shapely import MultiPolygon

from rota.files.blocks import Block, block_of, field_in, fields_in
from rota.files.shape_schema import (
    AREA_NEEDED,
    AREA_SOURCES,
    SHAPE_NEEDED,
    SOURCES,
    TEXT,
    ZONE_SOURCES,
    Area,
    Ring,
    Shape,
    Spot,
    area_faults,
    keys_with_values,
    one_of,
    rings_of,
    shape_faults,
)
from rota.model.fields import REQUIRED, Field, field_of, fields_of, flat_fields_of
from rota.model.fleet import ROBOTS_NEEDED, Abilities, Fleet, Kind, Robot, Start
from rota.model.importance import IMPORTANCE, ImportanceMap
from rota.model.mission import Mission, MovingObstacle, Obstacle, Zone, all_refusals
from rota.model.planner_registry import DEFAULT, PLANNERS, planner_names
from rota.model.refusals import Where, fleet_blocks, inner
from rota.planning.planner import loadable_planners, planner_named
from rota.vehicles.battery_data import BatteryData, battery_rules, seconds_beside_watts
from rota.vehicles.battery_presets import BATTERIES
from rota.vehicles.presets import VEHICLES

MOST_ROBOTS = 100_000  # a plan file of as many is some 300 MB, and its check takes minutes
DRIVING = tuple(item.name for item in flat_fields_of(Abilities))
PRESETS = {name: each.preset(DRIVING) for name, each in VEHICLES.items()}
ON_THE_FLOOR = [each.name for each in VEHICLES.values() if not each.flies]
MAP_VALUES = tuple(item.name for item in fields_of(ImportanceMap))
MAP_SAYS = {
    "oneOf": [{"required": ["map"]}, {"required": list(MAP_VALUES)}],
    "dependentRequired": {"black": ["white"], "white": ["black"]},
}
WITH_SPEED: list[Any] = [each.name for each in VEHICLES.values() if each.speed_m_s is not None]


# ---------------------------------------------------------------- what only files have


@dataclass(frozen=True, kw_only=True)
class MissionFile:
    """A mission: an area to watch, obstacles, zones with revisit periods, and a fleet."""

    rota: Literal[1] = field_of(meaning="version of this format")
    coordinates: Literal["metres", "wgs84"] = field_of(
        "metres", "metres: x east, y north; wgs84: longitude first, then latitude, in degrees"
    )


@dataclass(frozen=True, kw_only=True)
class ImportanceFile:
    """A map of what a square metre of ground is worth to a swarm."""

    map: str | None = field_of(
        None, "path of a picture (PNG, PGM), spread over the area with north up, or of a GeoTIFF", count=TEXT
    )
    black: float | None = field_of(None, "what a square metre is worth where a picture is black", **IMPORTANCE)
    white: float | None = field_of(None, "and where it is white; a GeoTIFF holds importance without them", **IMPORTANCE)


@dataclass(frozen=True, kw_only=True)
class _Forms:
    """Of what the model has in one form and files in several."""

    area: Ring | Area = rings_of(REQUIRED, needs=AREA_NEEDED)
    obstacle: Ring | Obstacle = rings_of(needs=SHAPE_NEEDED)
    name: str | None = field_of(None, "for people", count=TEXT)
    robots: Literal["fewest"] | int | tuple[Robot, ...] = field_of(
        "fewest", "as few as possible, so many, or a list with what differs", least=1, most=MOST_ROBOTS,
        count=((1, MOST_ROBOTS),), needs=ROBOTS_NEEDED,
    )  # fmt: skip


# ---------------------------------------------------------------- what keys say together


def moving_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Times that do not rise, and positions that are not as many."""
    times, positions = data.get("times_s"), data.get("positions_m")
    if not (isinstance(times, list) and all(isinstance(time, int | float) for time in times)):
        return
    for k in range(1, len(times)):
        if times[k] <= times[k - 1]:
            yield ("times_s", k), f"{times[k]} does not come after {times[k - 1]}; times must rise"
    if isinstance(positions, list) and len(positions) != len(times):
        yield ("positions_m",), f"{len(positions)} positions for {len(times)} times; one for each is needed"


def robot_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """A robot that leaves before it joins, and a battery that is told twice."""
    yield from seconds_beside_watts(data)
    joins, leaves = data.get("joins_s", 0.0), data.get("leaves_s")
    if all(isinstance(time, int | float) for time in (joins, leaves)) and leaves <= joins:
        yield ("leaves_s",), f"{leaves} is not allowed; it must come after joins_s, {joins}"


def start_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Exactly one of box and points."""
    if len(keys_with_values(data, "box", "points")) != 1:
        yield (), "give exactly one of box and points"


def fleet_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """No speed, and no vehicle that has one; vehicles on the floor that land, or look down; a battery told twice."""
    yield from seconds_beside_watts(data)
    if data.get("speed_m_s") is None and data.get("vehicle") not in WITH_SPEED:
        yield ("speed_m_s",), "is missing; it is required"
    if data.get("rally_points") and data.get("vehicle") in ON_THE_FLOOR:
        yield ("rally_points",), f"{data['vehicle']} keeps to the floor, and lands nowhere: remove them"
    for where, block in fleet_blocks({"fleet": data}):
        vehicle, sensor = (inner(block, key) or data.get(key) for key in ("vehicle", "sensor"))
        told = any(inner(block, key) is not None for key in ("vehicle", "sensor"))
        if told and vehicle in ON_THE_FLOOR and inner(sensor, "half_angle_deg") is not None:
            place = (*where[1:], "vehicle" if inner(block, "vehicle") else "sensor")
            yield place, f"{vehicle} keeps to the floor, and this sensor looks down from above: give another one"


def importance_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Neither a map nor values, or both; values without their places, and one of black and white without the other."""
    if len(keys_with_values(data, "map", "values")) != 1:
        yield (), "give exactly one of map and values"
    for together in (("black", "white"), MAP_VALUES):
        given = keys_with_values(data, *together)
        for missing in together if given else ():
            if missing not in given:
                yield (missing,), f"is missing; it goes with {given[0]}"
    yield from row_faults(data)


def row_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Rows of values of different lengths."""
    rows = data.get("values")
    if len({len(row) for row in rows if isinstance(row, list)} if isinstance(rows, list) else ()) > 1:
        yield ("values",), "rows of different lengths; all must have as many numbers"


def zone_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """As of a shape; a zone that is no GeoJSON file needs a name, and a period or an importance."""
    yield from shape_faults(data, ZONE_SOURCES)
    if data.get("geojson") is None:
        if data.get("name") is None and data.get("place") is None:
            yield ("name",), "is missing; give the zone a name"
        if "period_s" not in data and data.get("importance") is None:
            yield ("period_s",), "is missing; give seconds, or null to ask nothing in this zone"


def mission_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """What the planner cannot use, settings of another planner, and an origin that is given twice."""
    planner = data.get("planner", DEFAULT)
    if planner in planner_names():
        for other in planner_names():
            if other != planner and data.get(other) is not None:
                yield (other,), f"settings of another planner; planner is {planner}: remove this block"
    yield from all_refusals(planner_named(planner).settings if planner in planner_names() else None, data)
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) and data.get("period_s") is not None else []):
        if inner(zone, "importance") is not None and not {"period_s", "geojson"} & set(zone):
            message = "is missing; the area has one: give seconds, or null to ask nothing in this zone"
            yield ("zones", k, "period_s"), message
    if data.get("lanes") and inner(data, "area", "graph") is not None:
        yield ("lanes",), "given beside area.graph, which has lanes: remove one of them"
    if data.get("coordinates") == "wgs84" and data.get("origin") is not None:
        yield ("origin",), "belongs to missions in metres; with wgs84 it is the centre of the area: remove it"


# ---------------------------------------------------------------- the blocks


def _blocks() -> dict[Any, Block | Field]:
    """The blocks and fields of the model's types that are not just so in mission files."""
    vehicle: dict[str, Any] = {"kind": "option", "options": tuple(VEHICLES), "count": None}
    vehicle["says"] = {"group": "motion", "presets": PRESETS}

    def placed_block(kind: type[Any], *free: Field, rules: Any, says: Any) -> Block:
        """What lies on the ground: a shape beside its other fields; those ``free`` need not be given."""
        given = {item.name: item for item in free}
        own = [given.pop(each.name, each) for each in fields_in(kind, "mission") if each.name != "shape"]
        fields = (*fields_in(Shape, "mission"), *given.values(), *own)
        return replace(block_of(kind, "mission", rules=rules, says=says), fields=fields)

    def driving_block(kind: type[Any], **more: Any) -> Block:
        """What drives: a fleet or a robot, with the vehicles that are known, and its battery by a data sheet."""
        block = block_of(kind, "mission", known, **more)
        fields = [replace(each, **vehicle) if each.name == "vehicle" else each for each in block.fields]
        battery = Field(
            name="battery", kind="block", block=_battery_block(), optional=True, default=None,
            meaning="as a data sheet tells it, in place of endurance_s and what follows it", as_fleet=kind is not Fleet,
        )  # fmt: skip
        at = next(k for k, each in enumerate(fields) if each.name == "endurance_s")
        return replace(block, fields=(*fields[:at], battery, *fields[at:]))

    forms = {item.name: item for item in fields_of(_Forms)}
    zone = {item.name: item for item in fields_in(Zone, "mission")}
    values = fields_in(ImportanceMap, "mission")
    enough = (("geojson",), ("name", "period_s"), ("name", "importance"), ("place", "period_s"))
    needs = ({"required": [*keys]} for keys in enough)
    known: dict[Any, Block | Field] = {
        Area: block_of(Area, "mission", rules=area_faults, says=one_of(AREA_SOURCES)),
        ImportanceMap: replace(
            block_of(ImportanceFile, "mission", rules=importance_faults, says=MAP_SAYS),
            fields=fields_in(ImportanceFile, "mission")
            + tuple(replace(each, needed=False, optional=True, default=None) for each in values),
        ),
        MovingObstacle: block_of(MovingObstacle, "mission", rules=moving_faults),
        Start: block_of(Start, "mission", rules=start_faults, says=one_of(("box", "points"))),
        Zone: placed_block(
            Zone,
            replace(zone["name"], needed=False, optional=True, default=None),
            replace(zone["period_s"], needed=False, default=None),
            *fields_in(Spot, "mission"),
            rules=zone_faults,
            says=one_of(ZONE_SOURCES, anyOf=list(needs)),
        ),
    }
    known[MultiPolygon] = field_in(forms["area"], "mission", known)
    obstacle = placed_block(Obstacle, field_in(forms["name"], "mission"), rules=shape_faults, says=one_of(SOURCES))
    known[Obstacle] = field_in(forms["obstacle"], "mission", {Obstacle: obstacle})
    known[Robot] = driving_block(Robot, rules=robot_faults)
    known[Kind] = driving_block(Kind, rules=seconds_beside_watts)
    known["robots"] = field_in(forms["robots"], "mission", known)
    with_speed = [
        {"required": ["speed_m_s"], "properties": {"speed_m_s": {"type": "number"}}},
        {"required": ["vehicle"], "properties": {"vehicle": {"enum": WITH_SPEED}}},
    ]
    known[Fleet] = driving_block(Fleet, rules=fleet_faults, says={"anyOf": with_speed})
    return known


def _battery_block() -> Block:
    """A battery by its data sheet, with the presets that are known."""
    says = {"oneOf": [{"required": ["preset"]}, {"required": ["capacity_wh", "moving_w"]}]}
    block = block_of(BatteryData, "mission", rules=battery_rules, says=says)
    preset: dict[str, Any] = {"kind": "option", "options": tuple(BATTERIES)}
    return replace(
        block, fields=tuple(replace(each, **preset) if each.name == "preset" else each for each in block.fields)
    )


SETTINGS = Field(name="settings", kind="block", optional=True, default=None)


@cache
def _known_blocks() -> dict[Any, Block | Field]:
    return _blocks()


def mission_block(data: object = None) -> Block:
    """The block of a mission file, with one for each planner of this package and each that ``data`` names.

    data: a file as it was read; None: all planners have their blocks.
    """
    named = (data.get("planner"), *data) if isinstance(data, dict) else loadable_planners() if data is None else ()
    known = planner_names()
    return _mission_block(tuple(name for name in known if name in PLANNERS or name in named), known)


@cache
def _mission_block(names: tuple[str, ...], known: tuple[str, ...]) -> Block:
    """The same, with a block for planners of these names, of all that are known."""
    fields = [item for item in fields_in(Mission, "mission", _known_blocks()) if item.name != "planning"]
    planner = Field(name="planner", kind="option", options=known, default=DEFAULT)
    settings = [
        Field(
            name=name,
            kind="block",
            block=block_of(planner_named(name).settings, "mission"),
            optional=True,
            default=None,
        )
        for name in names
    ]
    version, coordinates = fields_in(MissionFile, "mission")
    name, *others = fields
    block = block_of(MissionFile, "mission", rules=mission_faults)
    return replace(block, fields=(version, name, coordinates, *others, planner, *settings))


def mission_field(*path: str) -> Field:
    """A field of a mission file, by the names on the way to it; of lists, those of their entries."""
    block = mission_block({})
    for name in path:
        item = next(each for each in block.fields if each.name == name)
        item = item.item if item.kind == "list" and item.item is not None else item
        block = item.block
    return item

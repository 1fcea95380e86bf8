"""The keys of a mission file and the values they take: one pydantic schema for YAML and JSON."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag, create_model

from rota.files.motion_schema import ON_THE_FLOOR, WITH_SPEED, MotionBlock
from rota.files.schema_block import (
    Block,
    Duration,
    Importance,
    Length,
    LengthOrZero,
    Moment,
    Positive,
    Rate,
    Text,
    Where,
    given_of,
)
from rota.files.settings_schema import settings_field
from rota.files.shape_schema import Area, ObstacleEntry, Point, ZoneBlock, one_of
from rota.model.mission import all_refused
from rota.model.planner_registry import DEFAULT, PLANNERS, planner_names
from rota.model.refusals import fleet_blocks, inner
from rota.planning.planner import loadable_planners, planner_named

MOST_ROBOTS = 100_000  # a plan file of as many is some 300 MB, and its check takes minutes


class MovingObstacleBlock(Block):
    """A disc that moves along timed points."""

    radius_m: Length
    times_s: list[Moment] = Field(min_length=1)
    positions_m: list[Point] = Field(min_length=1)

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Times that do not rise, and positions that are not as many."""
        times, positions = data.get("times_s"), data.get("positions_m")
        if not (isinstance(times, list) and all(isinstance(time, int | float) for time in times)):
            return
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                yield ("times_s", k), f"{times[k]} does not come after {times[k - 1]}; times must rise"
        if isinstance(positions, list) and len(positions) != len(times):
            yield ("positions_m",), f"{len(positions)} positions for {len(times)} times; one for each is needed"


class SensorBlock(Block):
    """What a robot sees round itself."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [
                {"properties": {"shape": {"const": "disc"}}, "required": ["radius_m"]},
                {"properties": {"shape": {"const": "square"}}, "required": ["side_m"]},
            ]
        }
    )

    shape: Literal["disc", "square"]
    radius_m: Length | None = None
    side_m: Length | None = None
    half_angle_deg: Annotated[Positive, Field(lt=90)] | None = Field(
        None, description="of a swarm with altitudes_m: the disc grows with height, height x tan, up to radius_m"
    )

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """A disc has a radius, and perhaps an angle, and nothing else; a square has a side."""
        shape = data.get("shape")
        if shape not in ("disc", "square"):
            return
        needed, other = ("radius_m", "side_m") if shape == "disc" else ("side_m", "radius_m")
        if data.get(needed) is None:
            yield (needed,), f"is missing; a {shape} sensor needs it, in metres"
        if data.get(other) is not None:
            yield (other,), f"does not belong to a {shape} sensor; it has {needed}"
        if shape == "square" and data.get("half_angle_deg") is not None:
            yield ("half_angle_deg",), "does not belong to a square sensor; remove it"


class Start(Block):
    """Where robots start: anywhere in a box, or at given points."""

    model_config = ConfigDict(json_schema_extra=one_of("box", "points"))

    box: tuple[Point, Point] | None = Field(None, description="two opposite corners")
    points: list[Point] | None = Field(None, min_length=1)

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Exactly one of box and points."""
        if len(given_of(data, "box", "points")) != 1:
            yield (), "give exactly one of box and points"


class RobotBlock(MotionBlock):
    """One robot: what is not given is as in the fleet."""

    name: Text
    speed_m_s: Rate | None = None
    sensor: SensorBlock | None = None
    body_radius_m: LengthOrZero | None = None
    turn_rate_rad_s: Rate | None = None
    turn_radius_m: LengthOrZero | None = None
    start: Point | None = None
    joins_s: Moment = Field(0.0, description="of a swarm: it stands at its start until then, and sees nothing")
    leaves_s: Moment | None = Field(None, description="of a swarm: it stays where it is then, and sees nothing more")

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """A robot that leaves before it joins."""
        joins, leaves = data.get("joins_s", 0.0), data.get("leaves_s")
        if all(isinstance(time, int | float) for time in (joins, leaves)) and leaves <= joins:
            yield ("leaves_s",), f"{leaves} is not allowed; it must come after joins_s, {joins}"


def _robots_kind(value: Any) -> str | None:
    if value == "fewest":
        return "<word>"
    if isinstance(value, int) and not isinstance(value, bool):
        return "<number>"
    return "<list>" if isinstance(value, list) else None


Robots = Annotated[
    Annotated[Literal["fewest"], Tag("<word>")]
    | Annotated[Annotated[int, Field(strict=True, ge=1, le=MOST_ROBOTS)], Tag("<number>")]
    | Annotated[Annotated[list[RobotBlock], Field(min_length=1, max_length=MOST_ROBOTS)], Tag("<list>")],
    Discriminator(
        _robots_kind,
        custom_error_type="wrong_kind",
        custom_error_message="fewest, a whole number or a list of {name, ...} is needed",
    ),
]


class FleetBlock(MotionBlock):
    """The robots."""

    model_config = ConfigDict(
        json_schema_extra={
            "anyOf": [
                {"required": ["speed_m_s"], "properties": {"speed_m_s": {"type": "number"}}},
                {"required": ["vehicle"], "properties": {"vehicle": {"enum": WITH_SPEED}}},
            ]
        }
    )

    robots: Robots = "fewest"
    speed_m_s: Rate | None = Field(None, description="required where no vehicle has one")
    sensor: SensorBlock
    body_radius_m: LengthOrZero = 0.0
    turn_rate_rad_s: Rate | None = Field(None, description="null: turning takes no time")
    turn_radius_m: LengthOrZero = Field(0.0, description="robots turn on arcs of this radius or more; 0: on the spot")
    altitude_m: Length = Field(30.0, description="for exports")
    start: Start | None = None
    entrances: list[Point] | None = Field(
        None,
        min_length=1,
        description="robots are only where their bodies can come to from one of these; null: anywhere; absent:"
        " anywhere, and on a ROS map where they can come to from inside or from their starts",
    )
    rally_points: list[Point] = Field(
        [], description="where robots that fly may land instead of at home, when they return by themselves"
    )

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """No speed, and no vehicle that has one; vehicles on the floor that land, or whose sensors look down."""
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


class OriginBlock(Block):
    """Where on the globe the local (0, 0) lies, WGS84 degrees."""

    lat: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-90, le=90)]
    lon: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-180, le=180)]


class ImportanceBlock(Block):
    """A map of what a square metre of ground is worth to a swarm."""

    map: Text = Field(description="path of a picture (PNG, PGM), spread over the area with north up, or of a GeoTIFF")
    black: Importance | None = Field(None, description="what a square metre is worth where a picture is black")
    white: Importance | None = Field(None, description="and where it is white; a GeoTIFF holds importance without them")

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """One of black and white without the other."""
        given = given_of(data, "black", "white")
        if len(given) == 1:
            missing = "white" if given == ["black"] else "black"
            yield (missing,), f"is missing; it goes with {given[0]}"


def _number_or_block(value: Any) -> str | None:
    if isinstance(value, dict | ImportanceBlock):
        return "<block>"
    return "<number>" if isinstance(value, int | float) and not isinstance(value, bool) else None


GroundImportance = Annotated[
    Annotated[Importance, Tag("<number>")] | Annotated[ImportanceBlock, Tag("<block>")],
    Discriminator(
        _number_or_block,
        custom_error_type="wrong_kind",
        custom_error_message="a number from 0 on or {map: FILE, black: ..., white: ...} is needed",
    ),
]


class MissionFile(Block):
    """A mission: an area to watch, obstacles, zones with revisit periods, and a fleet."""

    rota: Literal[1] = Field(description="version of this format")
    name: Text
    coordinates: Literal["metres", "wgs84"] = "metres"
    origin: OriginBlock | None = None
    area: Area
    obstacles: list[ObstacleEntry] = Field(default=[])
    moving_obstacles: list[MovingObstacleBlock] = Field(default=[])
    period_s: Duration | None = Field(None, description="for the area outside zones; null: nothing is asked there")
    unseeable: Literal["exclude", "refuse"] = "exclude"
    holds_within_s: Moment | None = Field(
        None, description="robots are in their loops, from when on periods hold, within so many seconds; null: any time"
    )
    importance: GroundImportance | None = Field(
        None,
        description="of a swarm: what a square metre outside zones with an importance is worth, or a map; null: 1",
    )
    zones: list[ZoneBlock] = Field(default=[])
    fleet: FleetBlock
    planner: str = DEFAULT

    @property
    def settings(self) -> dict[str, Any]:
        """The values that the block of the mission's planner gives."""
        return getattr(self, self.planner) or {}

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """What the planner cannot use, settings of another planner, and an origin that is given twice."""
        planner = data.get("planner", DEFAULT)
        if planner in planner_names():
            for other in planner_names():
                if other != planner and data.get(other) is not None:
                    yield (other,), f"settings of another planner; planner is {planner}: remove this block"
        yield from all_refused(planner_named(planner).settings if planner in planner_names() else None, data)
        zones = data.get("zones")
        for k, zone in enumerate(zones if isinstance(zones, list) and data.get("period_s") is not None else []):
            if inner(zone, "importance") is not None and not {"period_s", "geojson"} & set(zone):
                message = "is missing; the area has one: give seconds, or null to ask nothing in this zone"
                yield ("zones", k, "period_s"), message
        if data.get("coordinates") == "wgs84" and data.get("origin") is not None:
            yield ("origin",), "belongs to missions in metres; with wgs84 it is the centre of the area: remove it"


def mission_file_type(data: object = None) -> type[MissionFile]:
    """The model of a mission file, with a block for each planner of this package and each that ``data`` names.

    data: a file as it was read; None: all planners have their blocks.
    """
    named = (data.get("planner"), *data) if isinstance(data, dict) else loadable_planners() if data is None else ()
    return _mission_file_type(tuple(name for name in planner_names() if name in PLANNERS or name in named))


@cache
def _mission_file_type(names: tuple[str, ...]) -> type[MissionFile]:
    blocks = {name: settings_field(planner_named(name).settings, in_mission_file=True) for name in names}
    fields: dict[str, Any] = {name: (block, None) for name, block in blocks.items()}
    chosen: Any = Literal[planner_names()]
    return create_model("MissionFile", __base__=MissionFile, planner=(chosen, DEFAULT), **fields)

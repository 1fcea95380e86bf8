"""The keys of a mission file and the values they take: one pydantic schema for YAML and JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
)
from pydantic_core import PydanticCustomError

from rota.files.planner_faults import (
    MOST_ROBOTS,
    growing_footprints,
    unused_by_bounce,
    unused_by_patrol,
    unused_by_swarm,
)
from rota.files.rings import ring_fault
from rota.files.schema_block import (
    FARTHEST_M,
    Block,
    Coordinate,
    Duration,
    Length,
    LengthOrZero,
    Moment,
    Positive,
    Rate,
    Where,
    given_of,
)
from rota.files.settings_schema import BounceBlock, PatrolBlock, SwarmBlock

PLANNERS = ("patrol", "swarm", "bounce")

Text = Annotated[str, Field(strict=True, min_length=1)]
Point = tuple[Coordinate, Coordinate]


def _checked_ring(points: list[Point]) -> list[Point]:
    fault = ring_fault(points)
    if fault is not None:
        raise PydanticCustomError("ring", "{fault}", {"fault": fault})
    return points


Ring = Annotated[list[Point], AfterValidator(_checked_ring)]


def _one_of(*keys: str, **more: Any) -> dict[str, Any]:
    """What the published schema says of blocks that take exactly one of several keys."""
    belongs = {"holes": ["outer"], "feature": ["geojson"], "map": ["inside"], "inside": ["map"], "unknown": ["map"]}
    belongs |= {"text": ["cell_m"], "cell_m": ["text"]}
    return {"oneOf": [{"required": [key]} for key in keys], "dependentRequired": belongs, **more}


def _list_or_block(value: Any) -> str | None:
    if isinstance(value, list):
        return "<list>"
    return "<block>" if isinstance(value, dict | BaseModel) else None


def _either(allowed: str) -> Discriminator:
    return Discriminator(
        _list_or_block,
        custom_error_type="wrong_kind",
        custom_error_message=f"{allowed} is needed",
    )


class Circle(Block):
    """A circle; planned as a 64-gon that contains it."""

    centre: Point = Field(description="[x, y] in metres, or [longitude, latitude] in a wgs84 mission")
    radius_m: Annotated[Positive, Field(le=FARTHEST_M)]


class Holed(Block):
    """A polygon with holes."""

    outer: Ring
    holes: list[Ring] = Field(default=[])


_RING_ALLOWED = "a ring [[x, y], [x, y], [x, y], ...] or {outer: ring, holes: [ring, ...]}"
Polygonal = Annotated[Annotated[Ring, Tag("<list>")] | Annotated[Holed, Tag("<block>")], _either(_RING_ALLOWED)]


class Shape(Block):
    """One of a ring, an outer ring with holes, a circle, or polygons of a GeoJSON file."""

    ring: Polygonal | None = None
    outer: Ring | None = None
    holes: list[Ring] | None = None
    circle: Circle | None = None
    geojson: Text | None = Field(None, description="path of a GeoJSON file (RFC 7946: longitude, latitude)")
    feature: Text | None = Field(None, description="only the feature whose property name, Name or id equals this")

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Exactly one source of the shape; holes need an outer ring, a feature needs a file."""
        yield from _source_faults(data, "ring", "outer", "circle", "geojson")


def _source_faults(data: dict[str, Any], *sources: str) -> Iterator[tuple[Where, str]]:
    given = given_of(data, *sources)
    listed = f"{', '.join(sources[:-1])} or {sources[-1]}"
    if not given:
        yield (), f"has no shape; give one of {listed}"
    for extra in given[1:]:
        yield (extra,), f"given beside {given[0]}; exactly one of {listed} is allowed"
    if data.get("holes") is not None and data.get("outer") is None:
        yield ("holes",), "given without outer; write {outer: ring, holes: [ring, ...]}"
    if data.get("feature") is not None and data.get("geojson") is None:
        yield ("feature",), "given without geojson, the file to find it in"


class AreaBlock(Shape):
    """Where robots may be and must look."""

    model_config = ConfigDict(json_schema_extra=_one_of("ring", "outer", "circle", "geojson", "map", "text"))

    map: Text | None = Field(None, description="path of a ROS map_server .yaml file")
    inside: Point | None = Field(None, description="a point [x, y] in the free part of the map that is meant")
    unknown: Literal["blocked", "free"] | None = Field(None, description="overrides how unknown cells are read")
    text: Text | None = Field(
        None, description="lines of . (free) and # (obstacle), the first is north; from (0, 0) on"
    )
    cell_m: Length | None = Field(None, description="side of a text map's character in metres")

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """As a shape; inside belongs to a map and a map needs it, and cell_m to a text."""
        yield from _source_faults(data, "ring", "outer", "circle", "geojson", "map", "text")
        if data.get("map") is not None and data.get("inside") is None:
            yield ("inside",), "is missing; a map needs a point [x, y] in the free part that is meant"
        for field in given_of(data, "inside", "unknown"):
            if data.get("map") is None:
                yield (field,), "belongs to a map; remove it, or give map"
        if data.get("text") is not None and data.get("cell_m") is None:
            yield ("cell_m",), "is missing; a text map needs the side of a character in metres"
        if data.get("cell_m") is not None and data.get("text") is None:
            yield ("cell_m",), "belongs to a text map; remove it, or give text"


class ObstacleBlock(Shape):
    """Neither entered nor seen through, unless ``blocks`` says otherwise."""

    model_config = ConfigDict(json_schema_extra=_one_of("ring", "outer", "circle", "geojson"))

    blocks: Literal["both", "motion", "sight"] = "both"


class ZoneBlock(Shape):
    """Part of the area with its own period."""

    model_config = ConfigDict(
        json_schema_extra=_one_of(
            "ring",
            "outer",
            "circle",
            "geojson",
            anyOf=[{"required": ["geojson"]}, {"required": ["name", "period_s"]}],
        )
    )

    name: Text | None = None
    period_s: Duration | None = Field(None, description="seconds; null: nothing is asked there")
    demand: Literal["every_point", "visit"] = "every_point"

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """As a shape; a zone that is no GeoJSON file needs a name and a period."""
        yield from super().faults(data)
        if data.get("geojson") is None:
            if data.get("name") is None:
                yield ("name",), "is missing; give the zone a name"
            if "period_s" not in data:
                yield ("period_s",), "is missing; give seconds, or null to ask nothing in this zone"


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

    model_config = ConfigDict(json_schema_extra=_one_of("box", "points"))

    box: tuple[Point, Point] | None = Field(None, description="two opposite corners")
    points: list[Point] | None = Field(None, min_length=1)

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Exactly one of box and points."""
        if len(given_of(data, "box", "points")) != 1:
            yield (), "give exactly one of box and points"


class RobotBlock(Block):
    """One robot: what is not given is as in the fleet."""

    name: Text
    speed_m_s: Rate | None = None
    sensor: SensorBlock | None = None
    body_radius_m: LengthOrZero | None = None
    turn_rate_rad_s: Rate | None = None
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


class FleetBlock(Block):
    """The robots."""

    robots: Robots = "fewest"
    speed_m_s: Rate
    sensor: SensorBlock
    body_radius_m: LengthOrZero = 0.0
    turn_rate_rad_s: Rate | None = Field(None, description="null: turning takes no time")
    altitude_m: Length = Field(30.0, description="for exports")
    start: Start | None = None


class OriginBlock(Block):
    """Where on the globe the local (0, 0) lies, WGS84 degrees."""

    lat: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-90, le=90)]
    lon: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-180, le=180)]


_AREA_ALLOWED = (
    "a ring [[x, y], ...] or one of {ring: ...}, {outer: ...}, {circle: ...}, {geojson: ...}, {map: ...}, {text: ...}"
)
_SHAPE_ALLOWED = "a ring [[x, y], ...] or one of {ring: ...}, {outer: ...}, {circle: ...}, {geojson: ...}"
Area = Annotated[Annotated[Ring, Tag("<list>")] | Annotated[AreaBlock, Tag("<block>")], _either(_AREA_ALLOWED)]
ObstacleEntry = Annotated[
    Annotated[Ring, Tag("<list>")] | Annotated[ObstacleBlock, Tag("<block>")], _either(_SHAPE_ALLOWED)
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
    zones: list[ZoneBlock] = Field(default=[])
    fleet: FleetBlock
    planner: Literal["patrol", "swarm", "bounce"] = "patrol"
    patrol: PatrolBlock | None = None
    swarm: SwarmBlock | None = None
    bounce: BounceBlock | None = None

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """What the planner cannot use, settings of another planner, and an origin that is given twice."""
        planner = data.get("planner", "patrol")
        for other in PLANNERS:
            if planner in PLANNERS and other != planner and data.get(other) is not None:
                yield (other,), f"settings of another planner; planner is {planner}: remove this block"
        if planner == "patrol":
            yield from unused_by_patrol(data)
        if planner == "swarm":
            yield from unused_by_swarm(data)
        swarm = data.get("swarm")
        if planner != "swarm" or not isinstance(swarm, dict) or swarm.get("altitudes_m") is None:
            yield from growing_footprints(data)
        if planner == "bounce":
            yield from unused_by_bounce(data)
        if data.get("coordinates") == "wgs84" and data.get("origin") is not None:
            yield ("origin",), "belongs to missions in metres; with wgs84 it is the centre of the area: remove it"

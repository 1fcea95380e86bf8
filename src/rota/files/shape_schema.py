"""Where things are in a mission file: rings, circles and polygons of other files, the area, obstacles and zones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from rota.files.rings import ring_fault
from rota.files.schema_block import (
    FARTHEST_M,
    Block,
    Coordinate,
    Duration,
    Importance,
    Length,
    Positive,
    Text,
    Where,
    given_of,
)

Point = tuple[Coordinate, Coordinate]


def _checked_ring(points: list[Point]) -> list[Point]:
    fault = ring_fault(points)
    if fault is not None:
        raise PydanticCustomError("ring", "{fault}", {"fault": fault})
    return points


Ring = Annotated[list[Point], AfterValidator(_checked_ring)]


def one_of(*keys: str, **more: Any) -> dict[str, Any]:
    """What the published schema says of blocks that take exactly one of several keys."""
    belongs = {"holes": ["outer"], "feature": ["geojson"], "map": ["inside"], "inside": ["map"], "unknown": ["map"]}
    belongs |= {"close_gaps_m": ["map"]}
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
    """What is wrong with where a shape comes from: nothing given, or more than one source."""
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

    model_config = ConfigDict(json_schema_extra=one_of("ring", "outer", "circle", "geojson", "map", "text"))

    map: Text | None = Field(None, description="path of a ROS map_server .yaml file")
    inside: Point | None = Field(None, description="a point [x, y] in the free part of the map that is meant")
    unknown: Literal["blocked", "free"] | None = Field(None, description="overrides how unknown cells are read")
    close_gaps_m: Length | None = Field(None, description="gaps and nooks of the map that are narrower count as wall")
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
        for field in given_of(data, "inside", "unknown", "close_gaps_m"):
            if data.get("map") is None:
                yield (field,), "belongs to a map; remove it, or give map"
        if data.get("text") is not None and data.get("cell_m") is None:
            yield ("cell_m",), "is missing; a text map needs the side of a character in metres"
        if data.get("cell_m") is not None and data.get("text") is None:
            yield ("cell_m",), "belongs to a text map; remove it, or give text"


class ObstacleBlock(Shape):
    """Neither entered nor seen through, unless ``blocks`` says otherwise."""

    model_config = ConfigDict(json_schema_extra=one_of("ring", "outer", "circle", "geojson"))

    name: Text | None = Field(None, description="for people")
    blocks: Literal["both", "motion", "sight"] = "both"
    asks: Literal["all", "nothing"] = Field(
        "all", description="all: the ground under blocks: motion is asked for as anywhere else; nothing: it is not"
    )


class ZoneBlock(Shape):
    """Part of the area with its own period."""

    model_config = ConfigDict(
        json_schema_extra=one_of(
            "ring",
            "outer",
            "circle",
            "geojson",
            anyOf=[{"required": [*keys]} for keys in (("geojson",), ("name", "period_s"), ("name", "importance"))],
        )
    )

    name: Text | None = None
    period_s: Duration | None = Field(None, description="seconds; null: nothing is asked there")
    importance: Importance | None = Field(
        None, description="of a swarm's ground: what a square metre is worth there; null: as outside zones"
    )
    demand: Literal["every_point", "visit"] = "every_point"

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """As a shape; a zone that is no GeoJSON file needs a name, and a period or an importance."""
        yield from super().faults(data)
        if data.get("geojson") is None:
            if data.get("name") is None:
                yield ("name",), "is missing; give the zone a name"
            if "period_s" not in data and data.get("importance") is None:
                yield ("period_s",), "is missing; give seconds, or null to ask nothing in this zone"


_AREA_ALLOWED = (
    "a ring [[x, y], ...] or one of {ring: ...}, {outer: ...}, {circle: ...}, {geojson: ...}, {map: ...}, {text: ...}"
)
_SHAPE_ALLOWED = "a ring [[x, y], ...] or one of {ring: ...}, {outer: ...}, {circle: ...}, {geojson: ...}"
Area = Annotated[Annotated[Ring, Tag("<list>")] | Annotated[AreaBlock, Tag("<block>")], _either(_AREA_ALLOWED)]
ObstacleEntry = Annotated[
    Annotated[Ring, Tag("<list>")] | Annotated[ObstacleBlock, Tag("<block>")], _either(_SHAPE_ALLOWED)
]

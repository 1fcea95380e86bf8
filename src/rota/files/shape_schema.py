"""Where things are in a mission file: rings, circles and polygons of other files; what only the area may be besides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from rota.files.rings import ring_fault, wkt_fault
from rota.model.fields import REQUIRED, field_of, fields_of
from rota.model.limits import COORDINATE, LENGTH
from rota.model.refusals import Where

Point = tuple[float, float]
Ring = tuple[Point, ...]
PLACES: dict[str, Any] = {"least": COORDINATE[0], "most": COORDINATE[1]}
TEXT = ((1, None),)

_BELONGS = {
    "holes": ["outer"], "feature": ["geojson"], "map": ["inside"], "inside": ["map"], "unknown": ["map"],
    "close_gaps_m": ["map"], "text": ["cell_m"], "cell_m": ["text"],
    "width_m": ["graph"],
}  # fmt: skip
_RING_NEEDED = "a ring [[x, y], [x, y], [x, y], ...] or {outer: ring, holes: [ring, ...]} is needed"
SHAPE_NEEDED = (
    "a ring [[x, y], ...] or one of {ring: ...}, {outer: ...}, {circle: ...}, {wkt: ...}, {geojson: ...} is needed"
)
AREA_NEEDED = f"{SHAPE_NEEDED.removesuffix(' is needed')}, {{map: ...}}, {{text: ...}}, {{graph: ...}} is needed"


def rings_of(default: Any = None, meaning: str = "", **takes: Any) -> Any:
    """A field of a ring, or of several, whose borders are checked."""
    return field_of(default, meaning, check=ring_fault, count=((0, None), (0, None)), **PLACES, **takes)


@dataclass(frozen=True, kw_only=True)
class Circle:
    """A circle; planned as a 64-gon that contains it."""

    centre: Point = field_of(meaning="[x, y] in metres, or [longitude, latitude] in a wgs84 mission", **PLACES)
    radius_m: float = field_of(above=0, most=LENGTH[1])


@dataclass(frozen=True, kw_only=True)
class Holed:
    """A polygon with holes."""

    outer: Ring = rings_of(REQUIRED)
    holes: tuple[Ring, ...] = rings_of(())


@dataclass(frozen=True, kw_only=True)
class Shape:
    """One of a ring, an outer ring with holes, a circle, well-known text, or polygons of a GeoJSON file."""

    ring: Ring | Holed | None = rings_of(needs=_RING_NEEDED)
    outer: Ring | None = rings_of(meaning="the border of a polygon with holes")
    holes: tuple[Ring, ...] | None = rings_of(meaning="beside outer: rings within it")
    circle: Circle | None = field_of(None, "a 64-gon that contains it")
    wkt: str | None = field_of(
        None, "well-known text, POLYGON or MULTIPOLYGON, in the mission's coordinates", count=TEXT, check=wkt_fault
    )
    geojson: str | None = field_of(None, "path of a GeoJSON file (RFC 7946: longitude, latitude)", count=TEXT)
    feature: str | None = field_of(
        None, "beside geojson: only the feature whose property name, Name or id equals this", count=TEXT
    )


@dataclass(frozen=True, kw_only=True)
class Area(Shape):
    """Where robots may be and must look."""

    map: str | None = field_of(None, "path of a ROS map_server .yaml file", count=TEXT)
    inside: Point | None = field_of(None, "beside map: a point [x, y] in the free part of it that is meant", **PLACES)
    unknown: Literal["blocked", "free"] | None = field_of(None, "beside map: overrides how unknown cells are read")
    close_gaps_m: float | None = field_of(
        None, "beside map: gaps and nooks that are narrower count as wall", written=LENGTH
    )
    text: str | None = field_of(
        None, "lines of . (free) and # (obstacle), the first is north; from (0, 0) on", count=TEXT
    )
    cell_m: float | None = field_of(None, "beside text: side of a character in metres", written=LENGTH)
    graph: str | None = field_of(
        None,
        "path of a graph: networkx node-link JSON, a Nav2 route graph or a .graph file of patrolling_sim; robots keep"
        " to its edges and come to each place within period_s",
        count=TEXT,
    )
    width_m: float | None = field_of(None, "beside graph: how wide its ways are; null: 1", written=LENGTH)


@dataclass(frozen=True, kw_only=True)
class Spot:
    """Where a zone is that has no shape."""

    place: str | None = field_of(None, "where the area is a graph: the place of it that is meant", count=TEXT)


SHAPE_KEYS = tuple(item.name for item in fields_of(Shape))
SOURCES = tuple(name for name in SHAPE_KEYS if name not in _BELONGS)
AREA_SOURCES = (*SOURCES, "map", "text", "graph")
ZONE_SOURCES = (*SOURCES, "place")


def one_of(sources: tuple[str, ...], **more: Any) -> dict[str, Any]:
    """What the published schema says of blocks that take exactly one of several keys."""
    return {"oneOf": [{"required": [key]} for key in sources], "dependentRequired": _BELONGS, **more}


def keys_with_values(data: dict[str, Any], *keys: str) -> list[str]:
    """Those of the keys that a raw block gives a value."""
    return [key for key in keys if data.get(key) is not None]


def shape_faults(data: dict[str, Any], sources: tuple[str, ...] = SOURCES) -> Iterator[tuple[Where, str]]:
    """What is wrong with a shape: exactly one source; holes need an outer ring, a feature needs a file."""
    given = keys_with_values(data, *sources)
    listed = f"{', '.join(sources[:-1])} or {sources[-1]}"
    if not given:
        yield (), f"has no shape; give one of {listed}"
    for extra in given[1:]:
        yield (extra,), f"given beside {given[0]}; exactly one of {listed} is allowed"
    if data.get("holes") is not None and data.get("outer") is None:
        yield ("holes",), "given without outer; write {outer: ring, holes: [ring, ...]}"
    if data.get("feature") is not None and data.get("geojson") is None:
        yield ("feature",), "given without geojson, the file to find it in"


def area_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """As of a shape; inside belongs to a map and a map needs it, and cell_m to a text."""
    yield from shape_faults(data, AREA_SOURCES)
    if data.get("map") is not None and data.get("inside") is None:
        yield ("inside",), "is missing; a map needs a point [x, y] in the free part that is meant"
    for key in keys_with_values(data, "inside", "unknown", "close_gaps_m"):
        if data.get("map") is None:
            yield (key,), "belongs to a map; remove it, or give map"
    if data.get("width_m") is not None and data.get("graph") is None:
        yield ("width_m",), "belongs to a graph; remove it, or give graph"
    if data.get("text") is not None and data.get("cell_m") is None:
        yield ("cell_m",), "is missing; a text map needs the side of a character in metres"
    if data.get("cell_m") is not None and data.get("text") is None:
        yield ("cell_m",), "belongs to a text map; remove it, or give text"

"""GeoJSON (RFC 7946) to polygons in longitude and latitude."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np
from shapely import MultiPolygon, Polygon, unary_union

from rota.errors import MissionError
from rota.files.geodesy import require_degrees
from rota.files.json_text import unique_keys
from rota.files.local_file import read_text
from rota.files.rings import open_ring, polygon_fault, ring_fault
from rota.model.polygons import polygons_of
from rota.model.refusals import shorten, show_value

_MOST_DIGITS = 300
_WGS84_NAMES = ("CRS84", "EPSG::4326", "EPSG:4326", "WGS84")


@dataclass(frozen=True, kw_only=True)
class Feature:
    """One feature: ``shape`` in degrees (x longitude, y latitude); ``where`` names it in errors."""

    name: str | None
    where: str
    properties: dict[str, Any]
    shape: MultiPolygon


class Features(NamedTuple):
    """The features of a file that hold polygons, and how many others were left out."""

    features: tuple[Feature, ...]
    without_polygons: int


def read_features(path: Path) -> Features:
    """The polygons of a GeoJSON file: a FeatureCollection, a Feature, or a bare geometry.

    Heights are dropped; rings may be closed or not; overlapping parts of one feature are united. Points and lines are
    left out and counted. Raises MissionError, all faults at once, for what is not GeoJSON, coordinates that are no
    degrees (saying when they look swapped), rings that cross themselves, and files without any polygon.
    """
    document = _load(path)
    features: list[Feature] = []
    faults: list[str] = []
    left_out = 0
    for where, geometry, properties in _entries(path, document):
        try:
            name = feature_name(properties)
        except MissionError as error:
            faults += [f"{path}: {where}: {fault}" for fault in error.faults]
            continue
        label = f"{path}: {where}{f' ({name})' if name else ''}"
        try:
            shape = unary_union([_polygon(rings) for rings in _polygons(geometry)])
        except MissionError as error:
            faults += [f"{label}: {fault}" for fault in error.faults]
            continue
        if shape.is_empty:
            left_out += 1
        else:
            features.append(Feature(name=name, where=where, properties=properties, shape=polygons_of(shape)))
    if faults:
        raise MissionError(*faults)
    if not features:
        raise MissionError(f"{path}: holds no polygon; a Polygon or MultiPolygon is needed")
    return Features(tuple(features), left_out)


def feature_name(properties: dict[str, Any]) -> str | None:
    """The property name, Name or id (the first one given) as text, or None.

    Raises MissionError for text that no file can hold: JSON can write the halves of a character alone.
    """
    for key in ("name", "Name", "id"):
        value = properties.get(key)
        if isinstance(value, str | int) and not isinstance(value, bool) and str(value):
            if any(0xD800 <= ord(letter) < 0xE000 for letter in str(value)):
                raise MissionError(f"{key} {shorten(ascii(value))} holds half a character; whole ones are needed")
            return str(value)
    return None


def pick_feature(features: tuple[Feature, ...], name: str, path: Path) -> Feature:
    """The one feature with this name, Name or id. Raises MissionError when there is none, or more than one."""
    keys = ("name", "Name", "id")
    matching = [f for f in features if name in [str(f.properties[key]) for key in keys if key in f.properties]]
    if len(matching) == 1:
        return matching[0]
    names = ", ".join(repr(f.name) for f in features if f.name) or "no names at all"
    count = f"{len(matching)} features are" if matching else "no feature is"
    raise MissionError(f"{count} called {name!r} in {path}; it has {names}")


def _load(path: Path) -> Any:
    """The JSON value that a file holds; MissionError with line and column for text that is none."""

    def refuse(word: str) -> NoReturn:
        raise MissionError(f"{path}: holds {word}; JSON has finite numbers only")

    text = read_text(path, "a GeoJSON file")
    try:
        return json.loads(text, parse_constant=refuse, parse_int=_whole, object_pairs_hook=unique_keys)
    except json.JSONDecodeError as error:
        raise MissionError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except MissionError:
        raise
    except (RecursionError, ValueError) as error:
        raise MissionError(f"{path}: not JSON: {error}") from None


def _whole(digits: str) -> int | float:
    """An integer; infinite where it is longer than Python converts, and out of every range all the same."""
    if len(digits) <= _MOST_DIGITS:
        return int(digits)
    return -math.inf if digits[0] == "-" else math.inf


def _entries(path: Path, document: Any) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """(where, geometry, properties) of each feature."""
    kind = document.get("type") if isinstance(document, dict) else None
    if kind is None:
        raise MissionError(
            f"{path}: not GeoJSON; a FeatureCollection, a Feature, a Polygon or a MultiPolygon is needed"
        )
    _require_wgs84(path, document.get("crs"))
    if kind not in ("FeatureCollection", "Feature"):
        yield "geometry", document, {}
        return
    entries = document.get("features") if kind == "FeatureCollection" else [document]
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise MissionError(f"{path}: features must be a list of features")
    for k, entry in enumerate(entries):
        properties = entry.get("properties")
        properties = dict(properties) if isinstance(properties, dict) else {}
        if "id" in entry:
            properties.setdefault("id", entry["id"])
        yield f"features[{k}]" if kind == "FeatureCollection" else "feature", entry.get("geometry"), properties


def _require_wgs84(path: Path, crs: Any) -> None:
    """Old files may name another reference system; read as degrees they would put the area somewhere else."""
    if crs is None:
        return
    properties = crs.get("properties") if isinstance(crs, dict) else None
    name = str(properties.get("name", crs) if isinstance(properties, dict) else crs)
    if not name.upper().endswith(_WGS84_NAMES):
        raise MissionError(f"{path}: crs is {name}; GeoJSON is read as WGS84 longitude, latitude: convert the file")


def _polygons(geometry: Any) -> Iterator[Any]:
    """The lists of rings of every polygon in a geometry."""
    if geometry is None:
        return
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection":
        parts = geometry.get("geometries")
        for part in parts if isinstance(parts, list) else []:
            yield from _polygons(part)
    elif kind in ("Polygon", "MultiPolygon"):
        coordinates = geometry.get("coordinates")
        if not isinstance(coordinates, list):
            raise MissionError(f"{kind} without a list of coordinates")
        yield from [coordinates] if kind == "Polygon" else coordinates
    elif kind not in ("Point", "MultiPoint", "LineString", "MultiLineString"):
        raise MissionError(f"{show_value(kind)} is no geometry type; a Polygon or MultiPolygon is needed")


def _polygon(rings: Any) -> Polygon:
    if not isinstance(rings, list) or not rings:
        raise MissionError("a polygon needs a list of rings, the outer one first")
    read = [_ring(ring) for ring in rings]
    fault = next(filter(None, map(ring_fault, read)), None) or polygon_fault(read[0], read[1:])
    if fault is not None:
        raise MissionError(fault)
    return Polygon(read[0], read[1:])


def _ring(points: Any) -> list[tuple[float, float]]:
    """The corners of a ring in degrees, each once; MissionError for positions that are none."""
    if not isinstance(points, list):
        raise MissionError("a ring must be a list of positions [longitude, latitude]")
    for point in points:
        numbers = isinstance(point, list) and len(point) >= 2 and all(_is_number(value) for value in point[:2])
        if not numbers:
            raise MissionError(f"{show_value(point)} is no position [longitude, latitude]")
    ring = open_ring([(float(point[0]), float(point[1])) for point in points])
    if ring:
        require_degrees(*np.array(ring).T)
    return ring


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300 and math.isfinite(value)

"""Shapes of GeoJSON files written into a mission's document, where they can be edited like those that were drawn.

Only missions in degrees take them as they are, digit by digit; in others the files stay what they are named for.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import shapely
from shapely import Polygon, unary_union

from rota.errors import MissionError
from rota.files.geojson_shapes import Feature, pick_feature, read_features
from rota.files.mission_json import polygons_to_json
from rota.model.polygons import polygons_of
from rota.web.refusal import Json
from rota.web.tasks.context import Context, lay_out
from rota.web.tasks.sources import Source

MOST_VERTICES = 5_000  # of one entry; with more a shape is shown and not edited


class Inlined(NamedTuple):
    """The document, the files that it still names, and what its author should know."""

    document: Json
    files: dict[str, bytes]
    warnings: list[str]


def inline(context: Context, source: Source) -> Inlined:
    """The document of a source with the shapes of its GeoJSON files in it, as far as they fit."""
    document = dict(source.document)
    if document.get("coordinates") == "wgs84":
        with lay_out({name: content for name, content in source.files.items() if _may_be_named(name)}) as folder:
            document = _with_shapes(document, folder)
    return Inlined(document, _still_named(document, source.files), source.warnings)


def _may_be_named(name: str) -> bool:
    return name.lower().endswith((".geojson", ".json"))


def _with_shapes(document: Json, folder: Path) -> Json:
    """The document with the entries replaced that can be."""
    area = document.get("area")
    if isinstance(area, dict) and (features := _features(area, folder)):
        shape = polygons_of(unary_union([feature.shape for feature in features]))
        if _fits([shape]) and len(shape.geoms) == 1:
            document["area"] = _shape_in_file(shape.geoms[0])
    for key, entries in (("obstacles", _obstacles), ("zones", _zones)):
        listed = document.get(key)
        if isinstance(listed, list):
            document[key] = [made for entry in listed for made in entries(entry, folder)]
    return document


def _features(entry: Any, folder: Path) -> tuple[Feature, ...]:
    """The features that an entry names; none where it names no file, or one that is faulty (which validating tells)."""
    if not isinstance(entry, dict) or not isinstance(entry.get("geojson"), str) or "/" in entry["geojson"]:
        return ()
    path = folder / entry["geojson"]
    try:
        features = read_features(path).features
        if isinstance(entry.get("feature"), str):
            return (pick_feature(features, entry["feature"], path),)
    except MissionError:
        return ()
    return features if entry.get("feature") is None else ()


def _obstacles(entry: Any, folder: Path) -> Iterator[Any]:
    """An obstacle for each polygon of the file, with the name of its feature."""
    features = _features(entry, folder)
    if not features or not _fits([feature.shape for feature in features]):
        yield entry
        return
    more = {key: value for key, value in entry.items() if key not in ("geojson", "feature")}
    for feature in features:
        name = {} if feature.name is None else {"name": feature.name}
        for polygon in feature.shape.geoms:
            yield {**_shape_in_file(polygon), **name, **more}


def _zones(entry: Any, folder: Path) -> Iterator[Any]:
    """A zone for each feature of the file, with what the feature says of itself."""
    features = _features(entry, folder)
    whole = all(len(feature.shape.geoms) == 1 for feature in features)
    named = all(feature.name or entry.get("name") for feature in features)
    if not features or not whole or not named or not _fits([feature.shape for feature in features]):
        yield entry
        return
    for feature in features:
        zone: Json = {"name": entry.get("name") or feature.name}
        for key in ("period_s", "demand", "importance"):
            if key in feature.properties or key in entry:
                zone[key] = feature.properties.get(key, entry.get(key))
        yield {**zone, **_shape_in_file(feature.shape.geoms[0])}


def _fits(shapes: list[shapely.MultiPolygon]) -> bool:
    return sum(int(shapely.get_num_coordinates(shape)) for shape in shapes) <= MOST_VERTICES


def _shape_in_file(polygon: Polygon) -> Json:
    """A polygon as missions write it."""
    ((outer, *holes),) = polygons_to_json(shapely.MultiPolygon([polygon]))
    return {"outer": outer, "holes": holes} if holes else {"ring": outer}


def _still_named(document: Json, files: dict[str, bytes]) -> dict[str, bytes]:
    """The files that the document names, and those that such a file names."""
    text = str([document.get(key) for key in ("area", "obstacles", "zones", "importance")])
    named = {name for name in files if repr(name) in text}
    for name in list(named):
        if len(files[name]) < 2**16:
            named |= {other for other in files if other.encode() in files[name]}
    return {name: content for name, content in files.items() if name in named}

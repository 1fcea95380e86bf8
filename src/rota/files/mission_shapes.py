"""The shapes of a mission file, rings, circles, well-known text and GeoJSON files, to polygons in local metres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from shapely import MultiPolygon, Polygon, get_coordinates, transform, unary_union

from rota.errors import MissionError
from rota.files.blocks import Fault
from rota.files.geodesy import Projection, require_degrees
from rota.files.geojson_shapes import Feature, pick_feature, read_features
from rota.files.local_file import local_file
from rota.files.rings import circle_ring, fault_point, open_ring, polygon_fault, shape_of_wkt
from rota.files.yaml_text import Place
from rota.model.polygons import polygons_of


class Stop(Exception):  # noqa: N818 (an entry cannot be read further; the reader of the ground catches it)
    """What is wrong with one entry of a mission file, and where."""

    def __init__(self, place: Place, *messages: str) -> None:
        self.faults = [Fault(place, message) for message in messages]


@dataclass(frozen=True, kw_only=True)
class Frame:
    """How a mission file's places are written, and where they lie.

    folder: where relative paths start; confine: whether they may not leave it. in_degrees: coordinates are WGS84
    longitude and latitude. projection: from there to local metres; None: nothing places the mission on the globe.
    """

    folder: Path
    confine: bool
    in_degrees: bool
    projection: Projection | None = None

    @property
    def confine_to(self) -> Path | None:
        """The folder that no path may leave, if there is one."""
        return self.folder if self.confine else None

    def file(self, name: str) -> Path:
        """The path of a file that the mission names; raises MissionError when it leaves where it is confined to."""
        return local_file(self.folder, name, confine_to=self.confine_to)


def gives(entry: Any, key: str) -> bool:
    """Whether an entry of the file is a block that gives a value for the key."""
    return isinstance(entry, dict) and entry.get(key) is not None


class Written(NamedTuple):
    """A shape in the coordinates in which it is written, and the place of its source."""

    shape: MultiPolygon
    in_degrees: bool
    source: Place


def shape_in_metres(frame: Frame, place: Place, entry: Any, warnings: list[Fault]) -> MultiPolygon:
    """The ring, block or file ``entry`` in local metres; raises Stop when it is no shape. Adds to ``warnings``."""
    if gives(entry, "circle"):
        return _circle(frame, (*place, "circle"), entry["circle"])
    written = shape_as_written(frame, place, entry, warnings)
    return to_metres(frame, written.source, written.shape) if written.in_degrees else written.shape


def shape_as_written(frame: Frame, place: Place, entry: Any, warnings: list[Fault]) -> Written:
    """The ring, block or file ``entry``, no circle, as it is written; raises Stop. Adds to ``warnings``."""
    if gives(entry, "geojson"):
        features = features_of(frame, place, entry, warnings)
        return Written(polygons_of(unary_union([feature.shape for feature in features])), True, (*place, "geojson"))
    if gives(entry, "wkt"):
        return _on_ground(frame, (*place, "wkt"), shape_of_wkt(entry["wkt"]))
    place, outer, holes = _rings(place, entry)
    fault = polygon_fault(outer, holes)
    if fault is not None:
        raise Stop(place, fault)
    polygon = Polygon(open_ring(outer), [open_ring(hole) for hole in holes])
    return _on_ground(frame, place, MultiPolygon([polygon]))


def _on_ground(frame: Frame, place: Place, shape: MultiPolygon) -> Written:
    """A shape in the mission's coordinates; Stop where these are degrees and its corners are not on the globe."""
    if frame.in_degrees:
        _require_on_globe(place, get_coordinates(shape))
    return Written(shape, frame.in_degrees, place)


def features_of(frame: Frame, place: Place, entry: dict[str, Any], warnings: list[Fault]) -> tuple[Feature, ...]:
    """The polygons of the GeoJSON file that ``entry`` names, or the one it picks; raises Stop. Adds to ``warnings``."""
    try:
        path = frame.file(entry["geojson"])
        features, without_polygons = read_features(path)
    except MissionError as error:
        raise Stop((*place, "geojson"), *error.faults) from None
    if without_polygons:
        message = f"{without_polygons} features of {path} hold no polygon and are passed over"
        warnings.append(Fault((*place, "geojson"), message))
    if entry.get("feature") is None:
        return features
    try:
        return (pick_feature(features, entry["feature"], path),)
    except MissionError as error:
        raise Stop((*place, "feature"), *error.faults) from None


def to_metres(frame: Frame, place: Place, degrees: MultiPolygon) -> MultiPolygon:
    """A shape of longitudes and latitudes in local metres; raises Stop where there is no projection for it."""
    projection = frame.projection
    if projection is None:
        message = (
            "GeoJSON is longitude and latitude, but nothing places this mission in metres on the globe; "
            "give origin: {lat: ..., lon: ...}, or the area as GeoJSON too"
        )
        raise Stop(place, message)
    shape = transform(degrees, lambda points: np.column_stack(projection.to_metres(*points.T)))
    if not np.isfinite(shape.bounds).all() or not shape.is_valid:
        message = f"the shape is not valid in local metres, near {fault_point(shape)}; order its points anew"
        raise Stop(place, message)
    return shape


def _rings(place: Place, entry: Any) -> tuple[Place, Any, list[Any]]:
    """Where the rings of ``entry`` stand, the outer one, and its holes."""
    if gives(entry, "outer"):
        return (*place, "outer"), entry["outer"], entry.get("holes") or []
    if isinstance(entry, dict):
        place, entry = (*place, "ring"), entry["ring"]
    return (place, entry["outer"], entry.get("holes", [])) if isinstance(entry, dict) else (place, entry, [])


def _circle(frame: Frame, place: Place, circle: dict[str, Any]) -> MultiPolygon:
    """A circle as the polygon that contains it, in local metres."""
    centre = np.array([circle["centre"]])
    if frame.in_degrees:
        _require_on_globe((*place, "centre"), centre)
        assert frame.projection is not None
        centre = np.column_stack(frame.projection.to_metres(*centre.T))
    return MultiPolygon([Polygon(circle_ring((centre[0, 0], centre[0, 1]), circle["radius_m"]))])


def _require_on_globe(place: Place, points: Any) -> None:
    """Stop where points (n, 2) are no longitudes and latitudes."""
    try:
        require_degrees(points[:, 0], points[:, 1])
    except MissionError as error:
        hint = "" if "swapped" in str(error) else "; if these are metres, write coordinates: metres"
        raise Stop(place, *(fault + hint for fault in error.faults)) from None

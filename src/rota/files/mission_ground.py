"""The places of a mission file, from whatever source, to polygons in local metres."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import TypeAdapter, ValidationError
from shapely import MultiPolygon, Polygon, transform, unary_union

from rota.errors import MissionError
from rota.files.geodesy import Projection, projection_for, require_degrees
from rota.files.geojson_shapes import Feature, pick_feature, read_features
from rota.files.local_file import local_file
from rota.files.mission_schema import (
    Area,
    AreaBlock,
    Circle,
    Holed,
    Number,
    ObstacleBlock,
    ObstacleEntry,
    OriginBlock,
    Shape,
    ZoneBlock,
)
from rota.files.occupancy_map import InsideError, read_map
from rota.files.rings import circle_ring, fault_point, open_ring, polygon_fault, polygons_of
from rota.files.schema_faults import Fault
from rota.files.yaml_text import Place
from rota.mission import Demand, GeoPoint, Obstacle, Zone

_SMALLEST_CUT = 1e-9  # relative: borders drawn along each other differ by rounding

_AREA: TypeAdapter[Any] = TypeAdapter(Area)
_OBSTACLE: TypeAdapter[Any] = TypeAdapter(ObstacleEntry)
_ZONE: TypeAdapter[ZoneBlock] = TypeAdapter(ZoneBlock)
_ORIGIN: TypeAdapter[OriginBlock | None] = TypeAdapter(OriginBlock | None)
_PERIOD: TypeAdapter[float | None] = TypeAdapter(Number | None)


class Ground(NamedTuple):
    """Where the mission takes place, in local metres."""

    area: MultiPolygon
    obstacles: tuple[Obstacle, ...]
    zones: tuple[Zone, ...]
    origin: GeoPoint | None


def read_ground(data: Any, folder: Path, *, confine: bool) -> tuple[Ground | None, list[Fault], list[Fault]]:
    """The ground of a mission, the faults found in it, and warnings.

    Entries that break the schema are passed over (their faults are the schema's to tell), so that what is wrong with
    the others is told at the same time. The ground is None when there are faults or when the area is missing.
    """
    reading = _Reading(data, folder, confine)
    ground = reading.ground()
    return (None if reading.faults else ground), reading.faults, reading.warnings


class _Stop(Exception):  # noqa: N818 (it never leaves this module)
    def __init__(self, place: Place, *messages: str) -> None:
        self.place, self.messages = place, messages


class _Reading:
    """State of one reading: the frame, found with the area, and what was noticed on the way."""

    def __init__(self, data: Any, folder: Path, confine: bool) -> None:
        self.data: dict[str, Any] = data if isinstance(data, dict) else {}
        self.folder, self.confine_to = folder, folder if confine else None
        self.in_degrees = self.data.get("coordinates") == "wgs84"
        self.projection: Projection | None = None
        self.faults: list[Fault] = []
        self.warnings: list[Fault] = []

    def ground(self) -> Ground | None:
        area_entry = _valid(_AREA, self.data.get("area"))
        if area_entry is None or self.data.get("coordinates", "metres") not in ("metres", "wgs84"):
            return None
        try:
            area, obstacles = self.area(area_entry)
        except _Stop as fault:
            self.note(fault)
            return None
        obstacles += self.obstacles(area)
        zones = self.zones(area)
        stops = [obstacle.shape for obstacle in obstacles if obstacle.blocks_motion]
        if stops and not self.faults and area.difference(unary_union(stops)).area == 0:
            self.faults.append(Fault(("obstacles",), "cover the whole area; leave free space to move in"))
        origin = self.projection.origin if self.projection else None
        return Ground(area, tuple(obstacles), tuple(zones), origin)

    def note(self, fault: _Stop) -> None:
        self.faults += [Fault(fault.place, message) for message in fault.messages]

    # ---- the area, and with it the frame

    def area(self, entry: Any) -> tuple[MultiPolygon, list[Obstacle]]:
        origin = _valid(_ORIGIN, self.data.get("origin"))
        if origin is not None and not self.in_degrees:
            self.projection = Projection(GeoPoint(lat=origin.lat, lon=origin.lon))
        block = entry if isinstance(entry, AreaBlock) else None
        if block is not None and block.map is not None:
            return self.map_area(block)
        if self.in_degrees or (self.projection is None and block is not None and block.geojson is not None):
            self.projection = self.frame_of(entry)
        return self.shape(("area",), entry), []

    def frame_of(self, entry: Any) -> Projection:
        """The projection about the middle of the area's bounding box."""
        if isinstance(entry, AreaBlock) and entry.circle is not None:
            x, y = entry.circle.centre
            bounds: Any = (x, y, x, y)
        else:
            bounds = self.flat_shape(("area",), entry)[0].bounds
        try:
            return projection_for(bounds)
        except MissionError as error:
            raise _Stop(("area",), *error.faults) from None

    def map_area(self, block: AreaBlock) -> tuple[MultiPolygon, list[Obstacle]]:
        assert block.map is not None
        assert block.inside is not None
        if self.in_degrees:
            raise _Stop(
                ("coordinates",), "wgs84 does not go with area.map: a map is in metres; write coordinates: metres"
            )
        try:
            path = self.file(block.map)
            unknown = block.unknown or "map_server reading"
            sheet = read_map(path, block.inside, unknown, confine_to=self.confine_to)
        except InsideError as error:
            raise _Stop(("area", "inside"), *error.faults) from None
        except MissionError as error:
            raise _Stop(("area", "map"), *error.faults) from None
        self.warnings += [Fault(("area", "map"), warning) for warning in sheet.warnings]
        return sheet.area, [Obstacle(shape=sheet.obstacles)] if sheet.obstacles is not None else []

    # ---- what lies in it

    def obstacles(self, area: MultiPolygon) -> list[Obstacle]:
        obstacles = []
        for k, raw in _items(self.data, "obstacles"):
            entry = _valid(_OBSTACLE, raw)
            if entry is None:
                continue
            try:
                shape = self.shape(("obstacles", k), entry)
            except _Stop as fault:
                self.note(fault)
                continue
            if not shape.intersects(area):
                self.warnings.append(Fault(("obstacles", k), "lies wholly outside the area"))
            blocks = entry.blocks if isinstance(entry, ObstacleBlock) else "both"
            obstacles.append(Obstacle(shape=shape, blocks=blocks))
        return obstacles

    def zones(self, area: MultiPolygon) -> list[Zone]:
        zones: list[Zone] = []
        for k, raw in _items(self.data, "zones"):
            entry = _valid(_ZONE, raw)
            if entry is None:
                continue
            try:
                for place, zone in self.zones_of(("zones", k), entry, {zone.name for zone in zones}):
                    if any(zone.name == other.name for other in zones):
                        raise _Stop(place, f"{zone.name!r} is the name of another zone; names must be unique")
                    zones += self.cut(place[:2], zone, area)
            except _Stop as fault:
                self.note(fault)
        return zones

    def zones_of(self, place: Place, entry: ZoneBlock, taken: set[str]) -> Iterable[tuple[Place, Zone]]:
        if entry.geojson is None:
            assert entry.name is not None
            shape = self.shape(place, entry)
            yield (
                (*place, "name"),
                Zone(name=entry.name, shape=shape, period_s=entry.period_s, demand=entry.demand),
            )
            return
        features = self.features(place, entry)
        if entry.name is not None and len(features) > 1:
            message = f"{len(features)} features cannot share one name; name them in the file, or pick one by feature"
            raise _Stop((*place, "name"), message)
        named = {feature.name for feature in features} | taken
        free_names = (name for k in range(1, len(named) + len(features) + 2) if (name := f"zone-{k}") not in named)
        for feature in features:
            name = entry.name or feature.name or next(free_names)
            shape = self.to_metres((*place, "geojson"), feature.shape)
            period_s, demand = self.feature_demand((*place, "geojson"), entry, feature)
            yield (*place, "geojson"), Zone(name=name, shape=shape, period_s=period_s, demand=demand)

    def feature_demand(self, place: Place, entry: ZoneBlock, feature: Feature) -> tuple[float | None, Demand]:
        where = feature.where + (f" ({feature.name})" if feature.name else "")
        if "period_s" not in feature.properties and "period_s" not in entry.model_fields_set:
            raise _Stop(place, f"{where} has no property period_s; give it one in the file, or period_s beside geojson")
        period = feature.properties.get("period_s", entry.period_s)
        try:
            period_s = _PERIOD.validate_python(period)
        except ValidationError:
            period_s = -1.0
        if period_s is not None and period_s <= 0:
            raise _Stop(place, f"{where} has period_s {period!r}; a number greater than 0, or null, is needed")
        demand = feature.properties.get("demand", entry.demand)
        if demand not in ("every_point", "visit"):
            raise _Stop(place, f"{where} has demand {demand!r}; every_point or visit is needed")
        return period_s, demand

    def cut(self, place: Place, zone: Zone, area: MultiPolygon) -> list[Zone]:
        """The zone without what sticks out of the area, with a warning; none of it inside is a fault."""
        if area.covers(zone.shape):
            return [zone]
        inside = polygons_of(zone.shape.intersection(area))
        lost_m2 = zone.shape.area - inside.area
        if inside.area <= _SMALLEST_CUT * zone.shape.area:
            gap_m = zone.shape.distance(area)
            message = f"zone {zone.name!r} lies outside the area, {gap_m:.6g} m away from it; it must overlap the area"
            raise _Stop(place, message)
        if lost_m2 > _SMALLEST_CUT * zone.shape.area:
            share = 100 * lost_m2 / zone.shape.area
            message = f"zone {zone.name!r} sticks out of the area: {lost_m2:.6g} m2 ({share:.2g} %) of it are cut off"
            self.warnings.append(Fault(place, message))
        return [Zone(name=zone.name, shape=inside, period_s=zone.period_s, demand=zone.demand)]

    # ---- shapes

    def shape(self, place: Place, entry: Any) -> MultiPolygon:
        """A ring, block or file in local metres."""
        if isinstance(entry, Shape) and entry.circle is not None:
            return self.circle((*place, "circle"), entry.circle)
        flat, in_degrees, source = self.flat_shape(place, entry)
        return self.to_metres(source, flat) if in_degrees else flat

    def flat_shape(self, place: Place, entry: Any) -> tuple[MultiPolygon, bool, Place]:
        """A ring, block or file as it is written, whether that is degrees, and the place of its source."""
        if isinstance(entry, Shape) and entry.geojson is not None:
            features = self.features(place, entry)
            return polygons_of(unary_union([feature.shape for feature in features])), True, (*place, "geojson")
        holes: list[Any] = []
        if isinstance(entry, Shape) and entry.outer is not None:
            place, outer, holes = (*place, "outer"), entry.outer, entry.holes or []
        else:
            if isinstance(entry, Shape):
                place, entry = (*place, "ring"), entry.ring
            outer, holes = (entry.outer, entry.holes) if isinstance(entry, Holed) else (entry, [])
        fault = polygon_fault(outer, holes)
        if fault is not None:
            raise _Stop(place, fault)
        polygon = Polygon(open_ring(outer), [open_ring(hole) for hole in holes])
        if self.in_degrees:
            self.require_degrees(
                place, np.vstack([np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)])
            )
        return MultiPolygon([polygon]), self.in_degrees, place

    def circle(self, place: Place, circle: Circle) -> MultiPolygon:
        centre = np.array([circle.centre])
        if self.in_degrees:
            self.require_degrees((*place, "centre"), centre)
            assert self.projection is not None
            centre = np.column_stack(self.projection.to_metres(*centre.T))
        return MultiPolygon([Polygon(circle_ring((centre[0, 0], centre[0, 1]), circle.radius_m))])

    def features(self, place: Place, entry: Shape) -> tuple[Feature, ...]:
        assert entry.geojson is not None
        try:
            path = self.file(entry.geojson)
            features, without_polygons = read_features(path)
        except MissionError as error:
            raise _Stop((*place, "geojson"), *error.faults) from None
        if without_polygons:
            self.warnings.append(
                Fault((*place, "geojson"), f"{without_polygons} features of {path} hold no polygon and are passed over")
            )
        if entry.feature is None:
            return features
        try:
            return (pick_feature(features, entry.feature, path),)
        except MissionError as error:
            raise _Stop((*place, "feature"), *error.faults) from None

    def to_metres(self, place: Place, degrees: MultiPolygon) -> MultiPolygon:
        if self.projection is None:
            message = (
                "GeoJSON is longitude and latitude, but nothing places this mission in metres on the globe; "
                "give origin: {lat: ..., lon: ...}, or the area as GeoJSON too"
            )
            raise _Stop(place, message)
        projection = self.projection
        shape = transform(degrees, lambda points: np.column_stack(projection.to_metres(*points.T)))
        if not np.isfinite(shape.bounds).all() or not shape.is_valid:
            raise _Stop(
                place, f"the shape is not valid in local metres, near {fault_point(shape)}; order its points anew"
            )
        return shape

    def require_degrees(self, place: Place, points: Any) -> None:
        try:
            require_degrees(points[:, 0], points[:, 1])
        except MissionError as error:
            hint = "" if "swapped" in str(error) else "; if these are metres, write coordinates: metres"
            raise _Stop(place, *(fault + hint for fault in error.faults)) from None

    def file(self, name: str) -> Path:
        return local_file(self.folder, name, confine_to=self.confine_to)


def _items(data: dict[str, Any], key: str) -> Iterable[tuple[int, Any]]:
    entries = data.get(key)
    return enumerate(entries if isinstance(entries, list) else [])


def _valid(adapter: TypeAdapter[Any], value: Any) -> Any:
    try:
        return adapter.validate_python(value)
    except ValidationError:
        return None

"""Where a mission takes place: its area, obstacles and zones, from whatever source, in local metres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from shapely import MultiPolygon, unary_union

from rota.errors import MissionError
from rota.files.blocks import Fault, read_field
from rota.files.geodesy import Projection, projection_for
from rota.files.geojson_shapes import Feature
from rota.files.graph_file import Graph
from rota.files.importance_map import read_importance_map
from rota.files.mission_graph import GraphGround, bounds_of, ground_of_graph, load_graph
from rota.files.mission_schema import mission_field
from rota.files.mission_shapes import Frame, Stop, features_of, gives, shape_as_written, shape_in_metres, to_metres
from rota.files.occupancy_map import GapsError, InsideError, read_map
from rota.files.raster_map import Site
from rota.files.text_map import text_map
from rota.files.yaml_text import Place
from rota.model.fields import fields_of
from rota.model.importance import ALLOWED, ImportanceMap
from rota.model.limits import DURATION, LENGTH
from rota.model.mission import AREA, AREA_IS_TAKEN, Demand, GeoPoint, Lane, Obstacle, Zone
from rota.model.polygons import polygons_of
from rota.model.refusals import show_value

_SMALLEST_CUT = 1e-9  # relative: borders drawn along each other differ by rounding


Values = dict[str, Any]  # of a block of the file, those that are given, by their names


class Ground(NamedTuple):
    """Where the mission takes place, in local metres."""

    area: MultiPolygon
    obstacles: tuple[Obstacle, ...]
    zones: tuple[Zone, ...]
    origin: GeoPoint | None
    importance: float | ImportanceMap | None = None
    lanes: tuple[Lane, ...] = ()


class Noticed(NamedTuple):
    """What was found wrong and what is worth a warning so far; the reading of one entry after another adds to it."""

    faults: list[Fault]
    warnings: list[Fault]


def read_ground(data: Any, folder: Path, *, confine: bool) -> tuple[Ground | None, list[Fault], list[Fault]]:
    """The ground of a mission, the faults found in it, and warnings.

    Entries that break the schema are passed over (their faults are the schema's to tell), so that what is wrong with
    the others is told at the same time. The ground is None when there are faults or when the area is missing.
    """
    noticed = Noticed([], [])
    ground = _ground(data if isinstance(data, dict) else {}, folder, confine, noticed)
    return (None if noticed.faults else ground), noticed.faults, noticed.warnings


def _ground(data: dict[str, Any], folder: Path, confine: bool, noticed: Noticed) -> Ground | None:
    """The ground, as far as it can be read; None without an area."""
    entry = _valid(data, "area")
    if entry is None or data.get("coordinates", "metres") not in ("metres", "wgs84"):
        return None
    frame = Frame(folder=folder, confine=confine, in_degrees=data.get("coordinates") == "wgs84")
    try:
        graph = load_graph(frame, entry) if gives(entry, "graph") else None
        frame = _place(frame, entry, _valid(data, "origin"), noticed, graph)
        on_graph = None if graph is None else ground_of_graph(frame, graph, entry.get("width_m"))
        area, obstacles = _area(frame, entry, noticed) if on_graph is None else (on_graph.area, [])
        if (fault := _extent_fault(area)) is not None:
            raise Stop(("area",), fault)
    except Stop as stop:
        noticed.faults.extend(stop.faults)
        return None
    obstacles += _obstacles(frame, data, area, noticed)
    zones = _zones(frame, data, area, noticed, on_graph)
    stops = [obstacle.shape for obstacle in obstacles if obstacle.blocks_motion]
    if stops and not noticed.faults and area.difference(unary_union(stops)).area == 0:
        noticed.faults.append(Fault(("obstacles",), "cover the whole area; leave free space to move in"))
    origin = frame.projection.origin if frame.projection else None
    importance = _importance(frame, data, Site(area.bounds, origin), noticed)
    lanes = () if on_graph is None else on_graph.lanes
    return Ground(area, tuple(obstacles), tuple(zones), origin, importance, lanes)


# ---------------------------------------------------------------- the area, and with it the frame


def _place(frame: Frame, entry: Any, origin: Values | None, noticed: Noticed, graph: Graph | None) -> Frame:
    """The frame with its projection: about the given origin, or about the middle of an area or graph in degrees."""
    if origin is not None and not frame.in_degrees:
        return replace(frame, projection=Projection(GeoPoint(**origin)))
    if gives(entry, "map") or gives(entry, "text") or not (frame.in_degrees or gives(entry, "geojson")):
        return frame
    if gives(entry, "circle"):
        x, y = entry["circle"]["centre"]
        bounds: Any = (x, y, x, y)
    elif graph is not None:
        bounds = bounds_of(graph)
    else:
        bounds = shape_as_written(frame, ("area",), entry, noticed.warnings).shape.bounds
    try:
        return replace(frame, projection=projection_for(bounds))
    except MissionError as error:
        raise Stop(("area",), *error.faults) from None


def _area(frame: Frame, entry: Any, noticed: Noticed) -> tuple[MultiPolygon, list[Obstacle]]:
    """The area, and the obstacles that come with it when it is the free part of a map."""
    if gives(entry, "map"):
        return _area_of_map(frame, entry, noticed)
    if gives(entry, "text"):
        return _area_of_text(frame, entry)
    return shape_in_metres(frame, ("area",), entry, noticed.warnings), []


def _area_of_map(frame: Frame, block: Values, noticed: Noticed) -> tuple[MultiPolygon, list[Obstacle]]:
    """The free part of a ROS map round a point, and all that is not free as one obstacle."""
    if frame.in_degrees:
        message = "wgs84 does not go with area.map: a map is in metres; write coordinates: metres"
        raise Stop(("coordinates",), message)
    unknown: Any = block.get("unknown") or "map_server reading"
    try:
        sheet = read_map(
            frame.file(block["map"]), block["inside"], unknown,
            close_gaps_m=block.get("close_gaps_m") or 0.0, confine_to=frame.confine_to,
        )  # fmt: skip
    except InsideError as error:
        raise Stop(("area", "inside"), *error.faults) from None
    except GapsError as error:
        raise Stop(("area", "close_gaps_m"), *error.faults) from None
    except MissionError as error:
        raise Stop(("area", "map"), *error.faults) from None
    noticed.warnings.extend(Fault(("area", "map"), warning) for warning in sheet.warnings)
    return sheet.area, [Obstacle(shape=sheet.obstacles)] if sheet.obstacles is not None else []


def _area_of_text(frame: Frame, block: Values) -> tuple[MultiPolygon, list[Obstacle]]:
    """The rectangle of a typed map, and its obstacles as one."""
    if frame.in_degrees:
        raise Stop(("coordinates",), "wgs84 does not go with area.text: a typed map is in metres; write metres")
    try:
        area, walls = text_map(block["text"], block["cell_m"])
    except MissionError as error:
        raise Stop(("area", "text"), *error.faults) from None
    return area, [Obstacle(shape=walls)] if not walls.is_empty else []


def _extent_fault(area: MultiPolygon) -> str | None:
    """What is wrong with where an area begins and ends, in words, or None."""
    left, bottom, right, top = area.bounds
    farthest_m = max(abs(left), abs(bottom), abs(right), abs(top))
    least_m, most_m = LENGTH
    if not farthest_m <= most_m:
        return f"reaches {farthest_m:.6g} m from (0, 0); at most {most_m:,.0f} m are allowed"
    across_m = min(right - left, top - bottom)
    if across_m < least_m:
        return f"is {across_m:.6g} m across; at least {least_m:g} m are needed"
    return None


# ---------------------------------------------------------------- what lies in it


def _importance(frame: Frame, data: dict[str, Any], site: Site, noticed: Noticed) -> float | ImportanceMap | None:
    """What the ground is worth outside zones, a number or a map."""
    told = _valid(data, "importance")
    if not isinstance(told, dict):
        return None if told is None else float(told)
    key = "values" if gives(told, "values") else "map"
    scale = (told["black"], told["white"]) if gives(told, "black") and gives(told, "white") else None
    try:
        if key == "values":
            return ImportanceMap(**{item.name: told[item.name] for item in fields_of(ImportanceMap)})
        return read_importance_map(frame.file(told["map"]), site, scale)
    except MissionError as error:
        noticed.faults.extend(Fault(("importance", key), fault) for fault in error.faults)
    return None


def _obstacles(frame: Frame, data: dict[str, Any], area: MultiPolygon, noticed: Noticed) -> list[Obstacle]:
    """The obstacles that can be read."""
    obstacles = []
    for place, entry in _entries(data, "obstacles"):
        try:
            shape = shape_in_metres(frame, place, entry, noticed.warnings)
        except Stop as stop:
            noticed.faults.extend(stop.faults)
            continue
        if not shape.intersects(area):
            noticed.warnings.append(Fault(place, "lies wholly outside the area"))
        obstacles.append(Obstacle(**_own(Obstacle, entry), shape=shape))
    return obstacles


def _zones(
    frame: Frame, data: dict[str, Any], area: MultiPolygon, noticed: Noticed, on_graph: GraphGround | None
) -> list[Zone]:
    """The zones that can be read, without what sticks out of the area; on a graph those of its places besides."""
    zones: list[Zone] = []
    taken: set[str] = set()
    spots: set[str] = set()
    for place, entry in _entries(data, "zones"):
        try:
            if gives(entry, "place"):
                found: Iterable[tuple[Place, Zone]] = [_zone_at_a_place(place, entry, on_graph)]
                spots.add(entry["place"])
            else:
                found = _zones_of(frame, place, entry, taken, noticed)
            for where, zone in found:
                _require_free_name(where, zone.name, taken)
                zones.append(_cut(place, zone, area, noticed))
                taken.add(zone.name)
        except Stop as stop:
            noticed.faults.extend(stop.faults)
    if on_graph is not None:
        try:
            for zone in on_graph.zones(_valid(data, "period_s"), spots):
                _require_free_name(("area", "graph"), zone.name, taken)
                zones.append(_cut(("area", "graph"), zone, area, noticed))
        except Stop as stop:
            noticed.faults.extend(stop.faults)
    return zones


def _zone_at_a_place(place: Place, entry: Values, on_graph: GraphGround | None) -> tuple[Place, Zone]:
    """The zone of an entry that names a place of the graph: to be visited, and called by the place's name."""
    spot = None if on_graph is None else on_graph.spot(entry["place"])
    if spot is None:
        needed = "the id of a node is needed" if on_graph else "only an area that is a graph has places"
        raise Stop((*place, "place"), f"{entry['place']!r} is no place of the graph; {needed}")
    usual = {"name": entry["place"], "period_s": None, "demand": "visit"}
    return (*place, "place"), Zone(**{**usual, **_own(Zone, entry), "shape": spot})


def _zones_of(
    frame: Frame, place: Place, entry: Values, taken: set[str], noticed: Noticed
) -> Iterator[tuple[Place, Zone]]:
    """The zones of an entry, each with the place of its name: one with a shape, or those of a GeoJSON file."""
    if gives(entry, "geojson"):
        yield from _zones_of_file(frame, place, entry, taken, noticed)
        return
    shape = shape_in_metres(frame, place, entry, noticed.warnings)
    yield (*place, "name"), Zone(**{"period_s": None, **_own(Zone, entry), "shape": shape})


def _zones_of_file(
    frame: Frame, place: Place, entry: Values, taken: set[str], noticed: Noticed
) -> Iterator[tuple[Place, Zone]]:
    """One zone per feature of the GeoJSON file, with the place of its name; nameless ones get names not ``taken``."""
    features = features_of(frame, place, entry, noticed.warnings)
    if gives(entry, "name") and len(features) > 1:
        message = f"{len(features)} features cannot share one name; name them in the file, or pick one by feature"
        raise Stop((*place, "name"), message)
    named = {feature.name for feature in features} | taken
    free_names = (name for k in range(1, len(named) + len(features) + 2) if (name := f"zone-{k}") not in named)
    source = (*place, "geojson")
    for feature in features:
        name = entry.get("name") or feature.name or next(free_names)
        shape = to_metres(frame, source, feature.shape)
        importance = _feature_importance(source, entry, feature)
        period_s, demand = _feature_demand(source, entry, feature, importance)
        told = {"name": name, "shape": shape, "period_s": period_s, "demand": demand, "importance": importance}
        yield source, Zone(**_own(Zone, entry) | told)


def _name_of(feature: Feature) -> str:
    return feature.where + (f" ({feature.name})" if feature.name else "")


def _feature_importance(place: Place, entry: Values, feature: Feature) -> float | None:
    """The importance of a feature: its own property, or else that beside the file's name."""
    told = feature.properties.get("importance", entry.get("importance"))
    value, wrong = read_field(mission_field("zones", "importance"), told)
    if wrong:
        raise Stop(place, f"{_name_of(feature)} has importance {show_value(told)}; {ALLOWED}")
    return None if value is None else float(value)


def _feature_demand(
    place: Place, entry: Values, feature: Feature, importance: float | None
) -> tuple[float | None, Demand]:
    """Period and demand of a feature: its own properties, or else those beside the file's name."""
    where, periodic = _name_of(feature), "period_s" in feature.properties or "period_s" in entry
    if not periodic and importance is None:
        raise Stop(place, f"{where} has no property period_s; give it one in the file, or period_s beside geojson")
    period = feature.properties.get("period_s", entry.get("period_s"))
    period_s, wrong = read_field(mission_field("zones", "period_s"), period)
    if wrong:
        allowed = f"a number of seconds from {DURATION[0]:g} to {DURATION[1]:.9g}, or null, is needed"
        raise Stop(place, f"{where} has period_s {show_value(period)}; {allowed}")
    demand = feature.properties.get("demand", entry.get("demand", "every_point"))
    if demand not in ("every_point", "visit"):
        raise Stop(place, f"{where} has demand {show_value(demand)}; every_point or visit is needed")
    return period_s, demand


def _require_free_name(place: Place, name: str, taken: set[str]) -> None:
    """Stop where a zone has the name of another one or of the ground outside zones."""
    if name == AREA:
        raise Stop(place, f"{name!r} is not allowed; {AREA_IS_TAKEN}")
    if name in taken:
        raise Stop(place, f"{name!r} is the name of another zone; names must be unique")


def _cut(place: Place, zone: Zone, area: MultiPolygon, noticed: Noticed) -> Zone:
    """The zone without what sticks out of the area, with a warning; Stop where none of it is inside."""
    if area.covers(zone.shape):
        return zone
    inside = polygons_of(zone.shape.intersection(area))
    lost_m2 = zone.shape.area - inside.area
    if inside.area <= _SMALLEST_CUT * zone.shape.area:
        gap_m = zone.shape.distance(area)
        message = f"zone {zone.name!r} lies outside the area, {gap_m:.6g} m away from it; it must overlap the area"
        raise Stop(place, message)
    if lost_m2 > _SMALLEST_CUT * zone.shape.area:
        share = 100 * lost_m2 / zone.shape.area
        message = f"zone {zone.name!r} sticks out of the area: {lost_m2:.6g} m2 ({share:.2g} %) of it are cut off"
        noticed.warnings.append(Fault(place, message))
    return replace(zone, shape=inside)


def _entries(data: dict[str, Any], key: str) -> Iterable[tuple[Place, Any]]:
    """The entries of a list that keep to the schema, with their places."""
    listed = data.get(key)
    for k, raw in enumerate(listed if isinstance(listed, list) else []):
        entry = _valid({key: raw}, key)
        if entry is not None:
            yield (key, k), entry


def _valid(data: Values, key: str) -> Any:
    """The value of a key, or an entry of its list, as its field reads it; None where it is absent or at fault."""
    return read_field(mission_field(key), data[key])[0] if key in data else None


def _own(kind: type[Any], entry: Any) -> Values:
    """What an entry gives for the fields of its type."""
    return {item.name: entry[item.name] for item in fields_of(kind) if isinstance(entry, dict) and item.name in entry}

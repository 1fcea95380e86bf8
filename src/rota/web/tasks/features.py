"""Features of GeoJSON files as a mission: each is taken as area, zone or obstacle, or left out.

Without a choice all are the area, which is what ``area: {geojson: FILE}`` makes of a file in a mission.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import NamedTuple

import shapely

from rota.files.geojson_shapes import Feature, read_features
from rota.files.mission_json import polygons_to_json
from rota.model.polygons import polygons_of
from rota.web.refusal import Json, Refusal
from rota.web.tasks.context import lay_out

ROLES = {"a": "area", "o": "obstacle", "z": "zone", "-": "left out"}
GUESSED = "the fleet and the period are guesses: set them before you plan"
PERIOD_S = 600
SHOWN = 300  # times finer than the whole the outlines are, in which a choice is made
DEGREE_M = 111_195


class Features(NamedTuple):
    """Features by the names of their files in order; their own names are there and unique."""

    files: tuple[str, ...]
    features: tuple[Feature, ...]
    warnings: list[str]


def features_of(contents: dict[str, bytes], names: list[str]) -> Features:
    """The features of some of the files. MissionError for one that is no GeoJSON, or has no polygons."""
    files: list[str] = []
    features: list[Feature] = []
    warnings: list[str] = []
    taken: set[str] = set()
    with lay_out({name: contents[name] for name in names}) as folder:
        for name in sorted(names):
            read = read_features(folder / name)
            if read.without_polygons:
                warnings.append(f"{name}: {read.without_polygons} features without polygons are left out")
            for feature in read.features:
                files.append(name)
                features.append(replace(feature, name=_free(feature.name or f"feature {len(features) + 1}", taken)))
    return Features(tuple(files), tuple(features), warnings)


def _free(name: str, taken: set[str]) -> str:
    """A name that no other has, which is taken then."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name} {number}"
    taken.add(free)
    return free


def list_features(found: Features) -> list[Json]:
    """Name, file, size and outline of each feature, for somebody who chooses."""
    x0, y0, x1, y1 = shapely.total_bounds([feature.shape for feature in found.features])
    coarse = max(x1 - x0, y1 - y0) / SHOWN
    outlines = [polygons_of(feature.shape.simplify(coarse)) for feature in found.features]
    return [
        {"name": feature.name, "file": file, "m2": round(_area_m2(feature), 1), "shape": polygons_to_json(outline)}
        for file, feature, outline in zip(found.files, found.features, outlines, strict=True)
    ]


def mission_of(found: Features, roles: str | None) -> tuple[Json, dict[str, bytes]]:
    """The mission in which each feature has its role, and the files that it names.

    roles: a letter of ROLES for each feature; None: all are the area. Refusal for another number, another letter, and
    for roles without any area.
    """
    roles = "a" * len(found.features) if roles is None else roles
    if len(roles) != len(found.features) or set(roles) - set(ROLES):
        told = ", ".join(f"{letter} {role}" for letter, role in ROLES.items())
        raise Refusal(400, f"as: {roles[:40]!r} is not allowed; a letter for each of {len(roles)} features: {told}")
    by_role = {
        role: [feature for feature, given in zip(found.features, roles, strict=True) if given == letter]
        for letter, role in ROLES.items()
    }
    if not by_role["area"]:
        raise Refusal(422, "no feature is the area; choose one")
    stem = found.files[0].rsplit(".", 1)[0] if len(set(found.files)) == 1 else by_role["area"][0].name
    document: Json = {"rota": 1, "name": stem, "coordinates": "wgs84", "area": {"geojson": "area.geojson"}}
    files = {"area.geojson": by_role["area"]}
    if by_role["obstacle"]:
        files["obstacles.geojson"] = by_role["obstacle"]
        document["obstacles"] = [
            {"geojson": "obstacles.geojson", "feature": feature.name, "name": feature.name}
            for feature in by_role["obstacle"]
        ]
    document["period_s"] = PERIOD_S
    if by_role["zone"]:
        files["zones.geojson"] = by_role["zone"]
        document["zones"] = [
            {"geojson": "zones.geojson", "feature": feature.name, "name": feature.name, **_demand_of(feature)}
            for feature in by_role["zone"]
        ]
    side_m = math.sqrt(sum(map(_area_m2, by_role["area"])))
    radius_m = float(f"{max(side_m / 20, 0.5):.1g}")
    document["fleet"] = {"robots": "fewest", "speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": radius_m}}
    document["planner"] = "patrol"
    return document, {name: _file_of(features) for name, features in files.items()}


def _demand_of(feature: Feature) -> Json:
    """What a zone asks: what its feature says, otherwise half of the area's period."""
    period = feature.properties.get("period_s", PERIOD_S / 2)
    demand = feature.properties.get("demand")
    return {"period_s": period} | ({} if demand is None else {"demand": demand})


def _area_m2(feature: Feature) -> float:
    """About its square metres: degrees at the latitude of its middle."""
    return float(feature.shape.area * math.cos(math.radians(feature.shape.centroid.y)) * DEGREE_M**2)


def _file_of(features: list[Feature]) -> bytes:
    """Features as a GeoJSON file, digit by digit."""
    written = [
        {
            "type": "Feature",
            "properties": {"name": feature.name},
            "geometry": {
                "type": "MultiPolygon",
                "coordinates": [[[*ring, ring[0]] for ring in polygon] for polygon in polygons_to_json(feature.shape)],
            },
        }
        for feature in features
    ]
    return json.dumps({"type": "FeatureCollection", "features": written}).encode()

"""Plan -> KML 2.2 with Google's extensions: the ground as polygons, each robot as a track that viewers play."""

from __future__ import annotations

from datetime import datetime
from xml.etree.ElementTree import Element

import numpy as np
from shapely import MultiPolygon, transform
from shapely.geometry.polygon import orient

from rota.files.geodesy import Projection, projection_of
from rota.files.timed_places import START, timed_routes
from rota.files.xml_text import child, decimal_text, xml_text
from rota.model.plan import Floats, Plan

NAMESPACE = "http://www.opengis.net/kml/2.2"
EXTENSIONS = "http://www.google.com/kml/ext/2.2"
GROUND_DIGITS = 9  # of degrees: 0.1 mm
STYLES = {"area": "4dffffff", "obstacle": "990000ff", "zone": "6600ffff"}  # aabbggrr


def kml_text(plan: Plan, start: datetime = START) -> str:
    """Area, obstacles and zones as polygons on the ground; each robot's approach and one round of its loop as a track.

    Heights are over the ground (relativeToGround). Raises PlanError for a mission without an origin and for routes
    beyond the year 9999.
    """
    projection = projection_of(plan.mission, "KML")
    root = Element("kml", {"xmlns": NAMESPACE, "xmlns:gx": EXTENSIONS})
    document = child(root, "Document")
    child(document, "name", plan.mission.name)
    for kind, colour in STYLES.items():
        style = child(document, "Style", id=kind)
        child(child(style, "LineStyle"), "color", "ff" + colour[2:])
        child(child(style, "PolyStyle"), "color", colour)
    _add_ground(document, plan, projection)
    robots = child(document, "Folder")
    child(robots, "name", "robots")
    for route in timed_routes(plan, projection, start):
        placemark = child(robots, "Placemark")
        child(placemark, "name", route.robot)
        track = child(placemark, "gx:Track")
        child(track, "altitudeMode", "relativeToGround")
        for instant in route.instants:
            child(track, "when", instant)
        for place in zip(route.lon.tolist(), route.lat.tolist(), route.heights_m.tolist(), strict=True):
            child(track, "gx:coord", " ".join(map(decimal_text, place)))
    return xml_text(root)


def _add_ground(document: Element, plan: Plan, projection: Projection) -> None:
    """Add a folder with the area, obstacles and zones."""
    mission = plan.mission
    ground = child(document, "Folder")
    child(ground, "name", "ground")
    _add_shape(ground, "area", mission.name, _demand_in_words(mission.period_s), mission.area, projection)
    for number, obstacle in enumerate(mission.obstacles, start=1):
        what = {"both": "motion and sight"}.get(obstacle.blocks, obstacle.blocks)
        what += "" if obstacle.asks == "all" else ", nothing is asked under it"
        _add_shape(ground, "obstacle", f"obstacle {number}", f"blocks {what}", obstacle.shape, projection)
    for zone in mission.zones:
        _add_shape(ground, "zone", zone.name, _demand_in_words(zone.period_s), zone.shape, projection)


def _demand_in_words(period_s: float | None) -> str:
    return "nothing is asked here" if period_s is None else f"period {period_s:g} s"


def _add_shape(
    ground: Element, kind: str, name: str, description: str, shape: MultiPolygon, projection: Projection
) -> None:
    """Add a shape with its name and what is asked of it."""

    def to_degrees(points_m: Floats) -> Floats:
        lon, lat = projection.to_degrees(points_m[:, 0], points_m[:, 1])
        return np.asarray(np.round(np.column_stack([lon, lat]), GROUND_DIGITS), dtype=np.float64)

    placemark = child(ground, "Placemark")
    child(placemark, "name", name)
    child(placemark, "description", description)
    child(placemark, "styleUrl", f"#{kind}")
    parts = child(placemark, "MultiGeometry")
    for polygon in transform(MultiPolygon([orient(part) for part in shape.geoms]), to_degrees).geoms:
        element = child(parts, "Polygon")
        for border, ring in [("outer", polygon.exterior), *(("inner", ring) for ring in polygon.interiors)]:
            corners = " ".join(f"{lon:.9f},{lat:.9f}" for lon, lat in ring.coords)
            child(child(child(element, f"{border}BoundaryIs"), "LinearRing"), "coordinates", corners)

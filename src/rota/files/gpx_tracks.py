"""Plan -> GPX 1.1: a track with times for each robot."""

from __future__ import annotations

from datetime import datetime
from xml.etree.ElementTree import Element

from rota.files.geodesy import projection_of
from rota.files.timed_places import START, instant_text, timed_routes
from rota.files.xml_text import child, decimal_text, xml_text
from rota.model.plan import Plan

NAMESPACE = "http://www.topografix.com/GPX/1/1"


def gpx_text(plan: Plan, start: datetime = START) -> str:
    """A track for each robot: its approach and one round of its loop, with ``ele`` and ``time``.

    ``ele`` is the height over the take-off point, which the mission knows; GPX itself means height over the sea.
    Raises PlanError for a mission without an origin and for routes beyond the year 9999.
    """
    projection = projection_of(plan.mission, "GPX")
    root = Element("gpx", {"xmlns": NAMESPACE, "version": "1.1", "creator": "Rota"})
    about = child(root, "metadata")
    child(about, "name", plan.mission.name)
    child(about, "time", instant_text(start))
    for route, trajectory in zip(timed_routes(plan, projection, start), plan, strict=True):
        track = child(root, "trk")
        child(track, "name", route.robot)
        child(track, "desc", f"loop from {trajectory.loop_start_s!r} s on, {trajectory.loop_duration_s!r} s long")
        segment = child(track, "trkseg")
        columns = (route.lat.tolist(), route.lon.tolist(), route.heights_m.tolist(), route.instants)
        for lat, lon, height_m, instant in zip(*columns, strict=True):
            point = child(segment, "trkpt", lat=decimal_text(lat), lon=decimal_text(lon))
            child(point, "ele", decimal_text(height_m))
            child(point, "time", instant)
    return xml_text(root)

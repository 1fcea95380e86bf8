"""Ground and tracks as fastkml reads them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import pytest
from fastkml import KML, Folder, Placemark
from fastkml.enums import AltitudeMode
from fastkml.utils import find_all
from pyproj import Geod
from shapely.geometry import shape
from tests.files.two_robots import ORIGIN, ROBOTS, two_robots, with_heights

from rota.errors import PlanError
from rota.files.geodesy import Projection
from rota.files.kml_tour import kml_text
from rota.model.plan import Plan


def placemarks(plan: Plan, folder: str, **options: Any) -> list[Any]:
    text = kml_text(plan, **options)
    (found,) = find_all(KML.from_string(text.partition("\n")[2]), of_type=Folder, name=folder)
    return list(find_all(found, of_type=Placemark))


def test_fastkml_reads_tracks_with_places_heights_and_instants() -> None:
    plan, start = two_robots(), datetime(2026, 5, 1, 12, tzinfo=UTC)
    robots = placemarks(plan, "robots", start=start)
    assert [robot.name for robot in robots] == list(ROBOTS)
    for robot, trajectory in zip(robots, plan, strict=True):
        track = robot.kml_geometry
        assert track.altitude_mode is AltitudeMode.relative_to_ground
        lon, lat = Projection(ORIGIN).to_degrees(*trajectory.positions_m.T)
        read = np.array([item.coord.coords[0] for item in track.track_items])
        np.testing.assert_allclose(read, np.c_[lon, lat, np.full(len(lat), 25)], atol=1e-14)
        for item, time_s in zip(track.track_items, trajectory.times_s.tolist(), strict=True):
            assert abs(item.when.dt - start - timedelta(seconds=time_s)) <= timedelta(microseconds=1)


def test_heights_of_their_own_are_told() -> None:
    climbing, _ = placemarks(with_heights(), "robots")
    assert [item.coord.z for item in climbing.kml_geometry.track_items] == [30, 40.125, 30]


def test_the_ground_has_its_shapes_and_names() -> None:
    ground = placemarks(two_robots(), "ground")
    told = [(place.name, place.description, place.style_url.url) for place in ground]
    assert told == [
        ("quay <1>", "nothing is asked here", "#area"),
        ("obstacle 1", "blocks motion", "#obstacle"),
        ("gate & moat", "period 60 s", "#zone"),
    ]
    sizes_m2 = [abs(Geod(ellps="WGS84").geometry_area_perimeter(shape(place.geometry))[0]) for place in ground]
    assert sizes_m2 == pytest.approx([600**2 - 10**2 + 10**2, 10**2, 50**2], rel=1e-5)


def test_a_mission_without_an_origin_is_refused() -> None:
    with pytest.raises(PlanError, match=r"without an origin .* which KML needs; give --origin LAT,LON"):
        kml_text(two_robots(origin=None))

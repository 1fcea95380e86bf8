"""Tracks with times as gpxpy reads them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import gpxpy
import numpy as np
import pytest
from tests.files.two_robots import ORIGIN, ROBOTS, two_robots, with_heights

from rota.errors import PlanError
from rota.files.geodesy import Projection
from rota.files.gpx_tracks import gpx_text


def test_gpxpy_reads_places_heights_and_instants() -> None:
    plan = two_robots()
    start = datetime(2026, 5, 1, 23, 59, 50, 700, tzinfo=UTC)
    read = gpxpy.parse(gpx_text(plan, start))
    assert (read.version, read.creator, read.name) == ("1.1", "Rota", "quay <1>")
    assert [track.name for track in read.tracks] == list(ROBOTS)
    for track, trajectory in zip(read.tracks, plan, strict=True):
        (segment,) = track.segments
        lon, lat = Projection(ORIGIN).to_degrees(*trajectory.positions_m.T)
        np.testing.assert_allclose([[p.latitude, p.longitude] for p in segment.points], np.c_[lat, lon], atol=1e-14)
        assert [point.elevation for point in segment.points] == [25] * len(lat)
        for point, time_s in zip(segment.points, trajectory.times_s.tolist(), strict=True):
            assert point.time is not None
            assert abs(point.time - start - timedelta(seconds=time_s)) <= timedelta(microseconds=1)
    assert "loop from 4.0 s on" in (read.tracks[0].description or "")


def test_heights_of_their_own_are_told() -> None:
    first, second = gpxpy.parse(gpx_text(with_heights())).tracks
    assert [point.elevation for point in first.segments[0].points] == [30, 40.125, 30]
    assert [point.elevation for point in second.segments[0].points] == [25, 25]


def test_the_same_plan_gives_the_same_file_from_a_fixed_instant() -> None:
    first = gpxpy.parse(gpx_text(two_robots())).tracks[0].segments[0].points[0]
    assert first.time == datetime(2000, 1, 1, tzinfo=UTC)
    assert gpx_text(two_robots()) == gpx_text(two_robots())


def test_letters_that_xml_cannot_hold_are_replaced() -> None:
    read = gpxpy.parse(gpx_text(two_robots(robots=("a\uffffb", "]]>\ufffe"))))
    assert [track.name for track in read.tracks] == ["a\ufffdb", "]]>\ufffd"]


def test_what_has_no_place_or_no_date_is_refused() -> None:
    with pytest.raises(PlanError, match=r"without an origin .* which GPX needs; give --origin LAT,LON"):
        gpx_text(two_robots(origin=None))
    with pytest.raises(
        PlanError, match=r"its route of 65\.5004 s from 9999-12-31T23:59:00\.000Z on ends after the year"
    ):
        gpx_text(two_robots(), datetime(9999, 12, 31, 23, 59, tzinfo=UTC))

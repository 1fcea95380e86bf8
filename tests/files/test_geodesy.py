import math

import numpy as np
import pytest
from pyproj import Geod

from rota.errors import MissionError
from rota.files.geodesy import Projection, projection_for
from rota.model.mission import GeoPoint

GEOD = Geod(ellps="WGS84")


@pytest.mark.parametrize(
    "origin", [GeoPoint(lat=48.1, lon=11.5), GeoPoint(lat=-77.5, lon=166.7), GeoPoint(lat=0, lon=0)]
)
def test_distance_and_direction_from_the_origin_are_the_geodesics(origin):
    rng = np.random.default_rng(7)
    lon = origin.lon + rng.uniform(-0.05, 0.05, 200)
    lat = origin.lat + rng.uniform(-0.05, 0.05, 200)
    x, y = Projection(origin).to_metres(lon, lat)
    azimuth, _, distance_m = GEOD.inv(np.full(200, origin.lon), np.full(200, origin.lat), lon, lat)
    assert np.hypot(x, y) == pytest.approx(distance_m, abs=1e-6)
    turned = np.degrees(np.arctan2(x, y)) - azimuth
    assert np.abs((turned + 180) % 360 - 180).max() < 1e-6


def test_there_and_back():
    rng = np.random.default_rng(8)
    projection = Projection(GeoPoint(lat=54.362, lon=13.084))
    lon, lat = 13.084 + rng.uniform(-0.1, 0.1, 500), 54.362 + rng.uniform(-0.1, 0.1, 500)
    lon_back, lat_back = projection.to_degrees(*projection.to_metres(lon, lat))
    # a tenth of a millimetre is 1e-9 degrees
    assert max(np.abs(lon - lon_back).max(), np.abs(lat - lat_back).max()) < 1e-10


def test_numbers_as_well_as_arrays():
    x, y = Projection(GeoPoint(lat=10, lon=20)).to_metres(20, 10)
    assert (float(x), float(y)) == (0, 0)


def test_the_origin_is_the_rounded_centre_of_the_box():
    assert projection_for((11.50000004, 48.0, 11.50000021, 48.1)).origin == GeoPoint(lat=48.05, lon=11.5000001)


@pytest.mark.parametrize(
    ("lon", "lat", "words"),
    [
        ([-33.86], [151.2], "looks swapped"),
        ([500.0], [48.0], "no place on the globe"),
        ([11.5], [math.nan], "no place on the globe"),
        ([11.5, 100.0], [48.1, 100.0], r"\[100, 100\] is no place"),
    ],
)
def test_what_is_no_place_is_refused(lon, lat, words):
    with pytest.raises(MissionError, match=words):
        Projection(GeoPoint(lat=0, lon=0)).to_metres(lon, lat)


def test_a_box_across_the_180th_meridian_is_refused():
    with pytest.raises(MissionError, match="180th meridian"):
        projection_for((-179.9, 10, 179.9, 11))

"""The page's longitudes and latitudes against PROJ's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rota.files.geodesy import Projection
from rota.model.mission import GeoPoint

pytestmark = pytest.mark.browser


@pytest.fixture
def page(used_page: Any) -> Any:
    """The page, which tests of this file take over from each other."""
    return used_page


ORIGINS = [(54.362, 13.084), (0.0, 0.0), (-33.9, 151.2), (78.2, 15.6), (-54.8, -68.3), (35.0, -179.2)]
REACH_M = 20_000

IN_THE_PAGE = """async ([origin, places, degrees]) => {
  const { toMetres, toDegrees } = await import("/static/js/geodesy.js");
  return [places.map(([x, y]) => toDegrees(origin, x, y)), degrees.map(([lon, lat]) => toMetres(origin, lon, lat))];
}"""


def test_metres_and_degrees_are_those_of_proj(page: Any) -> None:
    x, y = np.random.default_rng(7).uniform(-REACH_M, REACH_M, (2, 100))
    for lat, lon in ORIGINS:
        projection = Projection(GeoPoint(lat=lat, lon=lon))
        lons, lats = projection.to_degrees(x, y)
        given = [{"lat": lat, "lon": lon}, np.stack([x, y], 1).tolist(), np.stack([lons, lats], 1).tolist()]
        degrees, metres = (np.array(part) for part in page.evaluate(IN_THE_PAGE, given))
        back_x, back_y = projection.to_metres(degrees[:, 0], degrees[:, 1])
        assert np.hypot(back_x - x, back_y - y).max() < 1e-3, (lat, lon)
        assert np.hypot(metres[:, 0] - x, metres[:, 1] - y).max() < 1e-3, (lat, lon)
    degrees, metres = page.evaluate(IN_THE_PAGE, [{"lat": 54.362, "lon": 13.084}, [[0, 0]], [[13.084, 54.362]]])
    assert degrees == [[13.084, 54.362]]
    assert metres == [[0, 0]]


IN_WORDS = """async (texts) => {
  const { placeOf } = await import("/static/js/editor/places.js");
  return texts.map(placeOf);
}"""
RUEGEN, SYDNEY = (54.36, 13.08), (-33.9, 151.2)
WRITTEN = {
    "54.36, 13.08": RUEGEN,
    "54.36 13.08": RUEGEN,
    "54,36; 13,08": RUEGEN,
    "54.36N 13.08E": RUEGEN,
    "13.08 E, 54.36 N": RUEGEN,
    "54°21'36\"N 13°4'48\"E": RUEGEN,
    "54° 21′ 36″ N, 13° 4′ 48″ E": RUEGEN,
    "N 54° 21.6' E 013° 04.8'": RUEGEN,
    "54 21 36 N 13 4 48 E": RUEGEN,
    "geo:54.36,13.08": RUEGEN,
    "https://www.openstreetmap.org/#map=17/54.36/13.08": RUEGEN,
    "https://www.google.com/maps/@54.36,13.08,17z": RUEGEN,
    "-33.9, 151.2": SYDNEY,
    "33.9S 151.2E": SYDNEY,
    "151.2, -33.9": SYDNEY,
}
NO_PLACES = ["", "harbour", "54.36", "99, 99", "1, 2, 3", "54N 13N", "54°61'N 13°E", "54.36, 181"]


def test_places_are_read_as_people_write_them(page: Any) -> None:
    read = page.evaluate(IN_WORDS, [*WRITTEN, *NO_PLACES])
    for (text, place), found in zip(WRITTEN.items(), read, strict=False):
        assert found is not None, text
        assert (found["lat"], found["lon"]) == pytest.approx(place, abs=1e-9), text
    assert read[len(WRITTEN) :] == [None] * len(NO_PLACES)

"""Height maps: a PNG spread over the area, and GeoTIFFs that say where they lie."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from docs.hills_picture import PICTURE, heights_m, picture
from PIL import Image, TiffImagePlugin
from pyproj import Transformer

from rota.errors import MissionError
from rota.files.geodesy import Projection
from rota.files.height_map import read_height_map
from rota.files.raster_map import GEO_KEYS, NO_DATA, PIXEL_SCALE, TIE_POINT
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission
from rota.planners.swarm.planner_settings import SwarmSettings

DOUBLE, SHORT, ASCII = 12, 3, 2  # types of TIFF's fields


def mission_of(size: float = 100.0, origin: GeoPoint | None = None) -> Mission:
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=5))
    fleet = replace(fleet, robots=(fleet.equal_robot("a"),))
    area = shapely.MultiPolygon([shapely.box(0, 0, size, size)])
    return Mission(name="m", area=area, fleet=fleet, origin=origin, planning=SwarmSettings())


def geotiff(
    path: Path, values: np.ndarray, scale: tuple[float, float] | None, tie: tuple[float, float], **tags: object
) -> str:
    """A file of heights whose upper left corner lies at ``tie``; scale: the size of a pixel."""
    info = TiffImagePlugin.ImageFileDirectory_v2()
    if scale is not None:
        info[PIXEL_SCALE], info.tagtype[PIXEL_SCALE] = (*scale, 0.0), DOUBLE
        info[TIE_POINT], info.tagtype[TIE_POINT] = (0.0, 0.0, 0.0, *tie, 0.0), DOUBLE
    if (code := tags.get("code")) is not None:
        key = 2048 if code == 4326 else 3072
        info[GEO_KEYS], info.tagtype[GEO_KEYS] = (1, 1, 0, 2, 1024, 0, 1, 1, key, 0, 1, code), SHORT
    if (missing := tags.get("missing")) is not None:
        info[NO_DATA], info.tagtype[NO_DATA] = str(missing), ASCII
    Image.fromarray(values.astype(np.float32)).save(path, tiffinfo=info)
    return str(path)


def slope(rows: int, columns: int) -> np.ndarray:
    """Heights 10 + 0.5 x + 0.25 y at the middles of pixels of 1 m, the northern row first."""
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows)[::-1] + 0.5)
    return 10 + 0.5 * x + 0.25 * y


def test_a_png_is_spread_over_the_area_with_north_up(tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    Image.fromarray(np.array([[0, 51], [255, 102]], np.uint8)).save(path)
    height = read_height_map(str(path), mission_of(), "100,200")
    assert height(25, 75) == pytest.approx(100)  # the upper left pixel's middle
    assert height(25, 25) == pytest.approx(200)
    assert height(75, 25) == pytest.approx(140)
    assert height(50, 25) == pytest.approx(170)
    assert height(50, 50) == pytest.approx((100 + 120 + 200 + 140) / 4)
    assert height(-10, 110) == pytest.approx(100)


def test_a_geotiff_without_a_system_lies_in_the_missions_metres(tmp_path: Path) -> None:
    path = geotiff(tmp_path / "a.tif", slope(120, 140), (1.0, 1.0), (-20.0, 110.0))
    height = read_height_map(path, mission_of())
    for x, y in [(0, 0), (3.3, 71.9), (99, 1), (100, 100)]:
        assert height(x, y) == pytest.approx(10 + 0.5 * (x + 20) + 0.25 * (y + 10), abs=1e-4)


@pytest.mark.parametrize("code", [4326, 32632])
def test_a_geotiff_lies_where_its_system_says(tmp_path: Path, code: int) -> None:
    origin = GeoPoint(lat=48.1, lon=11.5)
    to = Transformer.from_crs(4326, code, always_xy=True)
    lon, lat = Projection(origin).to_degrees([-60.0, 160.0], [-60.0, 160.0])
    (west, east), (south, north) = to.transform(lon, lat)
    columns = rows = 400
    across, down = (east - west) / columns, (north - south) / rows
    u, v = np.meshgrid(west + across * (np.arange(columns) + 0.5), north - down * (np.arange(rows) + 0.5))
    lon, lat = to.transform(u, v, direction="INVERSE")
    x, y = Projection(origin).to_metres(lon, lat)
    path = geotiff(tmp_path / "a.tif", 100 + 0.5 * x - 0.2 * y, (across, down), (west, north), code=code)
    height = read_height_map(path, mission_of(origin=origin))
    for x, y in [(0, 0), (40, 60), (97, 3)]:
        assert height(x, y) == pytest.approx(100 + 0.5 * x - 0.2 * y, abs=0.01)
    with pytest.raises(MissionError, match=f"lies in EPSG:{code}, and the mission has no origin"):
        read_height_map(path, mission_of())


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    flat, mission = np.full((100, 100), 3.0), mission_of()
    small = geotiff(tmp_path / "small.tif", flat[:50], (1.0, 1.0), (0.0, 100.0))
    nowhere = geotiff(tmp_path / "nowhere.tif", flat, None, (0.0, 0.0))
    high = geotiff(tmp_path / "high.tif", flat * 1e5, (1.0, 1.0), (0.0, 100.0))
    holed = flat.copy()
    holed[20:30, 20:30] = -9999
    gap = geotiff(tmp_path / "gap.tif", holed, (1.0, 1.0), (0.0, 100.0), missing=-9999)
    unknown = geotiff(tmp_path / "unknown.tif", flat, (1.0, 1.0), (0.0, 100.0), code=9)
    damaged = tmp_path / "damaged.tif"
    damaged.write_bytes(Path(small).read_bytes()[:60])
    colours = tmp_path / "colours.tif"
    Image.new("RGB", (4, 4)).save(colours)
    line = tmp_path / "line.png"
    Image.fromarray(np.zeros((1, 5), np.uint8)).save(line)
    placed = mission_of(origin=GeoPoint(lat=1, lon=1))
    for path, heights, asked, message in [
        (small, None, mission, "covers 50% of the box"),
        (nowhere, None, mission, "does not say where it lies"),
        (high, None, mission, "heights of up to 300000 m; at most 12000"),
        (gap, None, mission, "has no heights for part"),
        (unknown, None, placed, "EPSG:9, which is not known"),
        (str(damaged), None, mission, "damaged TIFF"),
        (str(colours), None, mission, "3 channels; a map of heights has one"),
        (str(line), "0,5", mission, "5 x 1 pixels; at least 2 x 2"),
        (str(line), None, mission, "--heights LOW,HIGH is needed"),
        (str(line), "0;5", mission, "--heights: '0;5' is not allowed"),
        (str(line), "0,nan", mission, "--heights: '0,nan' is not allowed"),
        (str(tmp_path / "no.tif"), None, mission, "no such file"),
    ]:
        with pytest.raises(MissionError, match=message):
            read_height_map(path, asked, heights)


def test_the_hills_of_the_example_are_those_of_the_script() -> None:
    """`python -m docs.hills_picture` writes them anew."""
    with Image.open(PICTURE) as kept:
        assert np.array_equal(np.asarray(kept), np.asarray(picture()))
    height = read_height_map(str(PICTURE), mission_of(128.0), "0,20")
    assert height(70.5, 96.5) == pytest.approx(heights_m()[128 - 97, 70], abs=1e-3)
    assert 15 < height(0.55 * 128, 0.75 * 128) < 20

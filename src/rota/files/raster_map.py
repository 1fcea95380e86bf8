"""Maps of values under a mission: a GeoTIFF, which says where it lies, or a picture spread over the area."""

from __future__ import annotations

import io
import math
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rota.errors import MissionError
from rota.files.geodesy import Projection
from rota.files.local_file import read_bytes
from rota.files.map_image import MOST_PIXELS, read_brightness
from rota.model.arrays import Floats
from rota.model.mission import GeoPoint

Scale = tuple[float, float]  # what black and white stand for

PIXEL_SCALE, TIE_POINT, GEO_KEYS, NO_DATA = 33550, 33922, 34735, 42113  # tags of GeoTIFF 1.1
GEODETIC_SYSTEM, PROJECTED_SYSTEM = 2048, 3072  # keys that hold EPSG codes
WGS84 = 4326
MOST_ACROSS = 2000  # places of the grid that a map is sampled at, along each axis


class Site(NamedTuple):
    """Where a mission lies: the box round its area in metres, and its place on the globe, if it has one."""

    bounds: tuple[float, float, float, float]
    origin: GeoPoint | None


class Raster(NamedTuple):
    """Values at the places of a grid over a site, (rows, columns), the southern row first.

    low_m: (x, y) of the first place; step_m: (x, y) between places.
    """

    values: Floats
    low_m: tuple[float, float]
    step_m: tuple[float, float]


def read_raster(path: Path, site: Site, scale: Scale | None, what: str, unscaled: str) -> Raster:
    """The values of a map all over a site.

    scale: what black and white stand for; a picture (PNG, PGM), which is spread over the site with north up, needs it.
    A GeoTIFF holds the values themselves unless it is given; it lies in the reference system that it names, for which
    an origin is needed, or in the mission's metres where it names none. what: the values' name in errors. Raises
    MissionError for other files, for damaged ones, where the site is not covered, and ``unscaled`` without a scale.
    """
    if read_bytes(path, "a .png or .tif image")[:4] in (b"II*\0", b"MM\0*"):
        return _from_tiff(path, site, scale, what)
    if scale is None:
        raise MissionError(f"{path}: {unscaled}")
    bright = read_brightness(path, alpha_counts=False)[::-1]
    x0, y0, x1, y1 = site.bounds
    rows, columns = bright.shape
    if rows < 2 or columns < 2:
        raise MissionError(f"{path}: {columns} x {rows} pixels; at least 2 x 2 are needed")
    step = (x1 - x0) / columns, (y1 - y0) / rows
    low = x0 + step[0] / 2, y0 + step[1] / 2
    return Raster(scale[0] + (scale[1] - scale[0]) * bright / 255, low, step)


def _from_tiff(path: Path, site: Site, scale: Scale | None, what: str) -> Raster:
    """The values of a GeoTIFF, sampled at the places of a grid over the site."""
    values, tags = _pixels_of(path, what)
    missing = ~np.isfinite(values)
    if NO_DATA in tags:
        missing |= values == float(str(tags[NO_DATA]).strip("\0 ") or "nan")
    if scale is not None:
        values = scale[0] + (scale[1] - scale[0]) * values / 255
    if PIXEL_SCALE not in tags or TIE_POINT not in tags:
        raise MissionError(f"{path}: does not say where it lies (GeoTIFF's pixel scale and tie point are missing)")
    across, down = (float(value) for value in tags[PIXEL_SCALE][:2])
    column, row, _, left, top, _ = (float(value) for value in tags[TIE_POINT][:6])
    x0, y0, x1, y1 = site.bounds
    xs, ys = (np.linspace(a, b, _places(a, b, across, tags)) for a, b in ((x0, x1), (y0, y1)))
    x, y = _in_system_of(path, tags, site.origin, *np.meshgrid(xs, ys))
    i, j = (x - left) / across + column - 0.5, (top - y) / down + row - 0.5
    rows, columns = values.shape
    if rows < 2 or columns < 2:
        raise MissionError(f"{path}: {columns} x {rows} pixels; at least 2 x 2 are needed")
    outside = (i < -0.5) | (j < -0.5) | (i > columns - 0.5) | (j > rows - 0.5)
    if outside.any():
        raise MissionError(
            f"{path}: covers {1 - outside.mean():.0%} of the box round the mission's area; all is needed"
        )
    i, j = np.clip(i, 0, columns - 1), np.clip(j, 0, rows - 1)
    i0, j0 = np.minimum(i.astype(int), columns - 2), np.minimum(j.astype(int), rows - 2)
    a, b = i - i0, j - j0
    corners = [
        (j0, i0, (1 - a) * (1 - b)),
        (j0, i0 + 1, a * (1 - b)),
        (j0 + 1, i0, (1 - a) * b),
        (j0 + 1, i0 + 1, a * b),
    ]
    if any((missing[r, c] & (share > 0)).any() for r, c, share in corners):
        raise MissionError(f"{path}: has no {what} for part of the mission's area")
    found = np.asarray(sum(share * values[r, c] for r, c, share in corners))
    return Raster(found, (x0, y0), (float(xs[1] - xs[0]), float(ys[1] - ys[0])))


def _pixels_of(path: Path, what: str) -> tuple[Floats, dict[int, Any]]:
    """(rows, columns) values and the tags of a TIFF of one channel; MissionError for others and for damaged files."""
    from PIL import Image, TiffImagePlugin

    data = read_bytes(path, "a .png or .tif image")
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data), formats=["TIFF"]) as image:
            columns, rows = image.size
            if columns * rows > MOST_PIXELS:
                raise MissionError(f"{path}: {columns} x {rows} pixels; at most {MOST_PIXELS:,} are allowed")
            values = np.asarray(image, dtype=np.float64)
            tags = dict(image.tag_v2) if isinstance(image, TiffImagePlugin.TiffImageFile) else {}
    except MissionError:
        raise
    except Exception as error:  # Pillow raises many kinds for damaged files
        raise MissionError(f"{path}: damaged TIFF: {error}") from None
    if values.ndim != 2:
        raise MissionError(f"{path}: {values.shape[-1]} channels; a map of {what} has one")
    return values, tags


def _places(low: float, high: float, across: float, tags: dict[int, Any]) -> int:
    """How many places along an axis a map is sampled at: as dense as its pixels, where these are metres."""
    if not across > 0 or _code_of(tags) == WGS84:
        return 256
    return int(min(max(math.ceil((high - low) / across) + 1, 2), MOST_ACROSS))


def _code_of(tags: dict[int, Any]) -> int | None:
    """The EPSG code of a GeoTIFF's reference system; None where it names none."""
    keys = tuple(int(value) for value in tags.get(GEO_KEYS, ()))
    named = {keys[k]: keys[k + 3] for k in range(4, len(keys) - 3, 4) if keys[k + 1] == 0}
    return named.get(PROJECTED_SYSTEM) or named.get(GEODETIC_SYSTEM)


def _in_system_of(
    path: Path, tags: dict[int, Any], origin: GeoPoint | None, x: Floats, y: Floats
) -> tuple[Floats, Floats]:
    """Places of the mission, in metres, in a GeoTIFF's reference system."""
    code = _code_of(tags)
    if code is None:
        return x, y
    if origin is None:
        raise MissionError(f"{path}: lies in EPSG:{code}, and the mission has no origin: {{lat: ..., lon: ...}}")
    lon, lat = Projection(origin).to_degrees(x, y)
    if code == WGS84:
        return lon, lat
    from pyproj import Transformer
    from pyproj.exceptions import CRSError

    try:
        there = Transformer.from_crs(WGS84, code, always_xy=True).transform(lon, lat)
    except CRSError:
        raise MissionError(f"{path}: lies in EPSG:{code}, which is not known") from None
    return np.asarray(there[0]), np.asarray(there[1])

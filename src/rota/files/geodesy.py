"""Longitude and latitude (WGS84) to local metres and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rota.errors import MissionError, PlanError
from rota.model.arrays import Floats
from rota.model.mission import GeoPoint, Mission

ORIGIN_DECIMALS = 7  # 1e-7 degrees: about a centimetre, and what MAVLink's integers carry


@dataclass(frozen=True)
class Projection:
    """Azimuthal equidistant about ``origin``: x metres east, y metres north; distances from the origin are exact."""

    origin: GeoPoint

    def to_metres(self, lon: ArrayLike, lat: ArrayLike) -> tuple[Floats, Floats]:
        """Local x, y in metres of longitudes and latitudes in degrees (arrays of one shape, or numbers).

        Raises MissionError for values out of range, and says so when they look swapped.
        """
        lon, lat = np.asarray(lon, dtype=np.float64), np.asarray(lat, dtype=np.float64)
        require_degrees(lon, lat)
        x, y = _transformer(self.origin).transform(lon, lat)
        return np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)

    def to_degrees(self, x: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats]:
        """Longitude and latitude in degrees of local x, y in metres (arrays of one shape, or numbers)."""
        x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
        lon, lat = _transformer(self.origin).transform(x, y, direction="INVERSE")
        return np.asarray(lon, dtype=np.float64), np.asarray(lat, dtype=np.float64)


def projection_of(mission: Mission, reader: str) -> Projection:
    """The projection about a mission's origin; PlanError without one, since ``reader`` needs places on the globe."""
    if mission.origin is None:
        raise PlanError(
            f"mission {mission.name}: without an origin it has no place on the globe, which {reader} needs; give"
            " --origin LAT,LON, or add origin: {lat: ..., lon: ...} to the mission file and plan again"
        )
    return Projection(mission.origin)


def projection_for(bounds: tuple[float, float, float, float]) -> Projection:
    """The projection about the centre of a bounding box, rounded to 1e-7 degrees.

    bounds: least longitude, least latitude, greatest longitude, greatest latitude, in degrees. Raises MissionError for
    values out of range and for a box wider than half the globe (one that crosses the 180th meridian).
    """
    west, south, east, north = (float(value) for value in bounds)
    require_degrees(np.array([west, east]), np.array([south, north]))
    if east - west > 180:
        raise MissionError(
            f"longitudes reach from {west:.9g} to {east:.9g}; shapes across the 180th meridian are not supported"
        )
    lon = round((west + east) / 2, ORIGIN_DECIMALS)
    lat = round((south + north) / 2, ORIGIN_DECIMALS)
    return Projection(GeoPoint(lat=lat, lon=lon))


def require_degrees(lon: Floats, lat: Floats) -> None:
    """Raise MissionError unless longitudes lie in -180..180 and latitudes in -90..90; says when they look swapped."""
    # written so that NaN is out of range too
    good = (np.abs(lon) <= 180) & (np.abs(lat) <= 90)
    if good.all():
        return
    k = np.flatnonzero(~good.ravel())[0]
    point = f"[{lon.ravel()[k]:.9g}, {lat.ravel()[k]:.9g}]"
    if (np.abs(lat) <= 180).all() and (np.abs(lon) <= 90).all():
        raise MissionError(
            f"{point} looks swapped: WGS84 coordinates are [longitude, latitude], and latitudes lie in -90..90"
        )
    raise MissionError(f"{point} is no place on the globe: longitudes lie in -180..180, latitudes in -90..90 degrees")


@lru_cache(maxsize=16)
def _transformer(origin: GeoPoint) -> Any:
    # pyproj takes a tenth of a second to load, and missions in metres never need it
    from pyproj import CRS, Transformer

    local = CRS.from_proj4(f"+proj=aeqd +lat_0={origin.lat!r} +lon_0={origin.lon!r} +datum=WGS84 +units=m +no_defs")
    return Transformer.from_crs("EPSG:4326", local, always_xy=True)

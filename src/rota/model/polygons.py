"""The polygons of a geometry: overlays of shapes leave points, lines and slivers of rounding besides."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

POLYGON = 3  # the largest type number of shapely that is no collection


def polygons_of(shape: BaseGeometry | NDArray[np.object_], least_m2: float = 0.0) -> MultiPolygon:
    """The polygons, in their order, of a geometry of any kind, or of an array of them, that exceed ``least_m2``.

    Empty where there is none.
    """
    parts = shapely.get_parts(np.atleast_1d(shape))
    while (shapely.get_type_id(parts) > POLYGON).any():
        parts = shapely.get_parts(parts)
    kept = (shapely.get_type_id(parts) == POLYGON) & (shapely.area(parts) > least_m2)
    return MultiPolygon(list(parts[kept]))

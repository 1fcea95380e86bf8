"""Boxes that hold few corners each: what depends on nothing far away is worked out in one after the other.

Buffers and overlays of polygons take far more than twice the time for twice the corners. A box of them, with all that
is near enough to matter round it, takes no more than its corners ask for.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.polygons import polygons_of

Box = tuple[float, float, float, float]  # x0, y0, x1, y1 in metres

MOST_CORNERS = 3_000  # that one geometry call is given; a box no wider than its margin may hold more


def few_cornered_boxes(bounds: Box, corners_m: Floats, margin_m: float, most: int = MOST_CORNERS) -> list[Box]:
    """Boxes that share no ground and cover the bounds, cut across their longer sides until few corners are near each.

    corners_m: (n, 2). Near are those within ``margin_m`` of a box, as its sides measure. A box with at most ``most`` of
    them is not cut, nor is one whose sides are no longer than twice the margin: its halves would have the same near.
    """
    return list(_cut(bounds, corners_m, margin_m, most))


def _cut(box: Box, corners_m: Floats, margin_m: float, most: int) -> Iterator[Box]:
    """Halves of the box until each has at most so many corners near it, or is small."""
    x0, y0, x1, y1 = box
    low, high = np.array([x0, y0]) - margin_m, np.array([x1, y1]) + margin_m
    near = corners_m[((corners_m >= low) & (corners_m <= high)).all(axis=1)]
    if len(near) <= most or max(x1 - x0, y1 - y0) <= 2 * margin_m:
        yield box
        return
    if x1 - x0 >= y1 - y0:
        middle = (x0 + x1) / 2
        halves: tuple[Box, Box] = (x0, y0, middle, y1), (middle, y0, x1, y1)
    else:
        middle = (y0 + y1) / 2
        halves = (x0, y0, x1, middle), (x0, middle, x1, y1)
    for half in halves:
        yield from _cut(half, near, margin_m, most)


def grown_box(box: Box, margin_m: float) -> Box:
    """The box, margin_m wider on every side."""
    return box[0] - margin_m, box[1] - margin_m, box[2] + margin_m, box[3] + margin_m


def clip(shape: BaseGeometry, box: Box) -> MultiPolygon:
    """The part of a polygonal shape in the box: polygons, perhaps none."""
    return polygons_of(shapely.intersection(shape, shapely.box(*box)))

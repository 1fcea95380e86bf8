"""Rings of points and well-known text: what is wrong with them; circles as rings."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

import numpy as np
from shapely import MultiPolygon, Polygon, force_2d, from_wkt, is_valid_reason
from shapely.errors import ShapelyError
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.limits import COORDINATE
from rota.model.polygons import polygons_of

CIRCLE_CORNERS = 64

Points = Sequence[Sequence[float]]


def open_ring(points: Points) -> list[tuple[float, float]]:
    """The ring's points without the repeated last one and without points equal to the one before them."""
    kept: list[tuple[float, float]] = []
    for point in points:
        if not kept or tuple(point) != kept[-1]:
            kept.append((point[0], point[1]))
    while len(kept) > 1 and kept[0] == kept[-1]:
        kept.pop()
    return kept


def ring_fault(points: Points) -> str | None:
    """What makes this ring unusable, in words, or None.

    points: (n, 2) in any unit, closed (first point repeated) or not. At least 3 distinct points are needed; the ring
    may neither cross nor touch itself, and must enclose something.
    """
    distinct = len(set(open_ring(points)))
    if distinct < 3:
        return f"a ring of {distinct} distinct point{'s' * (distinct != 1)} encloses nothing; at least 3 are needed"
    polygon = Polygon(open_ring(points))
    # the hull, since the two halves of a ring shaped like an 8 cancel
    if polygon.convex_hull.area <= 1e-12 * polygon.length**2:
        return "the ring encloses no area: its points lie on one line; move one of them off it"
    if not polygon.is_valid:
        return f"the ring crosses or touches itself at {fault_point(polygon)}; order its points along the border"
    return None


def polygon_fault(outer: Points, holes: Sequence[Points]) -> str | None:
    """What makes a polygon with holes unusable although each ring is fine, in words, or None."""
    polygon = Polygon(open_ring(outer), [open_ring(hole) for hole in holes])
    if polygon.is_valid:
        return None
    return (
        f"the rings cross, touch along a line or lie outside each other near {fault_point(polygon)}; "
        "holes must lie inside the outer ring and apart from each other"
    )


def wkt_fault(text: str) -> str | None:
    """What makes a well-known text unusable as the shape of something, in words, or None."""
    try:
        shape = from_wkt(text)
    except ShapelyError as error:
        return f"no well-known text: {' '.join(str(error).split())}"
    if not isinstance(shape, Polygon | MultiPolygon) or shape.is_empty:
        return f"a POLYGON or a MULTIPOLYGON with corners is needed, not {shape.geom_type.upper()}"
    low, high = COORDINATE
    if not all(low <= bound <= high for bound in shape.bounds):
        return f"reaches beyond {high:g}; coordinates from {low:g} to {high:g} are allowed"
    if not shape.is_valid or any(part.area <= 1e-12 * part.length**2 for part in polygons_of(shape).geoms):
        return f"the rings cross, touch along a line or enclose nothing near {fault_point(shape)}; order their points"
    return None


def shape_of_wkt(text: str) -> MultiPolygon:
    """The polygons of a well-known text without fault, without heights, their corners as they stand."""
    return polygons_of(force_2d(from_wkt(text)))


def wkt_of(polygons: Iterable[Iterable[Points]]) -> str:
    """Polygons, each an outer ring and holes whose first point is not repeated, as text, all digits kept."""

    def ring_text(ring: Points) -> str:
        """The corners of a closed ring."""
        return "(" + ", ".join(f"{x!r} {y!r}" for x, y in (*ring, ring[0])) + ")"

    return "MULTIPOLYGON (" + ", ".join(f"({', '.join(map(ring_text, rings))})" for rings in polygons) + ")"


def fault_point(shape: BaseGeometry) -> str:
    """Where GEOS finds an invalid shape invalid, as ``(x, y)``."""
    place = re.search(r"\[(\S+) (\S+?)\]", is_valid_reason(shape))
    return f"({float(place[1]):.9g}, {float(place[2]):.9g})" if place else "an unknown point"


def circle_ring(centre: tuple[float, float], radius: float) -> Floats:
    """(64, 2) corners of the regular 64-gon whose sides touch the circle from outside, so that it contains it."""
    angles = (np.arange(CIRCLE_CORNERS) + 0.5) * (2 * math.pi / CIRCLE_CORNERS)
    # the factor beyond 1 / cos keeps the sides outside the circle when coordinates are rounded
    corner_radius = radius / math.cos(math.pi / CIRCLE_CORNERS) * (1 + 1e-12)
    return np.asarray(centre) + corner_radius * np.column_stack([np.cos(angles), np.sin(angles)])

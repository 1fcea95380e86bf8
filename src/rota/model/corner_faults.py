"""Whether a fleet may cut corners as far as its mission says: by less than its ground is wide."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon, union_all

from rota.model.fleet import Fleet

EXACT = 1e-3  # of the ground's width, to which its widest circle is found


def corner_faults(area: MultiPolygon, blocking: Sequence[MultiPolygon], fleet: Fleet) -> list[tuple[str, str]]:
    """Corners that no way on this ground has: the field at fault and a message.

    A robot that may pass a corner at a distance of ``corner_m`` needs ground at least so wide: a circle of that radius
    must fit into the free space, or it could leave out whole ways.
    """
    corners = [("fleet", fleet.motion.corner_m)]
    corners += [(f"fleet.robots[{k}]", robot.motion.corner_m) for k, robot in enumerate(fleet.robots or ())]
    faults = []
    for where, corner_m in corners:
        told = where == "fleet" or corner_m != fleet.motion.corner_m  # what a robot has from its fleet is told once
        if corner_m > 0 and told and not _fits(area, tuple(blocking), corner_m):
            room_m = _inner_radius_m(area, tuple(blocking))
            message = (
                f"{corner_m:.6g} is not allowed; corners are cut by less than the radius of the widest circle in the"
                f" free space, {room_m:.4g} m"
            )
            faults.append((f"{where}.corner_m", message))
    return faults


@lru_cache(maxsize=64)  # missions are made again and again of the same ground
def _fits(area: MultiPolygon, blocking: tuple[MultiPolygon, ...], radius_m: float) -> bool:
    """Whether a circle of this radius fits into the free space."""
    free = _free(area, blocking)
    with np.errstate(divide="ignore", invalid="ignore"):  # of ground whose squares float64 cannot hold; that is no room
        room_m = shapely.distance(shapely.point_on_surface(free), free.boundary)
    if room_m > radius_m:
        return True
    return not free.buffer(-radius_m).is_empty


@lru_cache(maxsize=8)
def _inner_radius_m(area: MultiPolygon, blocking: tuple[MultiPolygon, ...]) -> float:
    """The radius of the widest circle in the free space."""
    free = _free(area, blocking)
    parts = [part for part in getattr(free, "geoms", [free]) if isinstance(part, Polygon)]
    x0, y0, x1, y1 = free.bounds
    exact_m = EXACT * min(x1 - x0, y1 - y0)
    circles = [shapely.maximum_inscribed_circle(part, tolerance=exact_m) for part in parts]
    return float(max(shapely.length(circle) for circle in circles))


@lru_cache(maxsize=8)
def _free(area: MultiPolygon, blocking: tuple[MultiPolygon, ...]) -> MultiPolygon | Polygon:
    return area.difference(union_all(blocking)) if blocking else area

"""Ground that bodies cannot stand on in triangles, through whose sides they look in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.check import tiling_kernels
from rota.check.arrays import STANDING, WALL, Flags, Floats, Grid, Ints, Triangles
from rota.check.tolerances import GRID_MARGIN_M

ALONG = (0.29, 0.5, 0.71)  # where a side is asked whether it is one of a wall
MOST_CORNERS = 5_000  # of ground that is cut into triangles at once: larger ground takes longer than its parts


def triangles_of(ground: Any, walls: Any, standing: Any, near_m: float) -> Triangles:
    """The triangles of polygonal ground between walls and where bodies stand, both as lines.

    A side that two triangles share is one that sight passes. Any other is a wall where it lies on one, within near_m,
    and not on the border of where bodies stand. Whatever else it may be, by rounding, counts as where bodies stand: so
    no ground is ever hidden by what is no wall.
    """
    parts = np.array([part for polygon in _polygons(ground) for part in _small_parts(polygon)])
    rings = shapely.get_exterior_ring(shapely.get_parts(shapely.constrained_delaunay_triangles(parts)))
    xy = shapely.get_coordinates(rings).reshape(-1, 4, 2)[:, :3]
    sides = np.diff(xy, axis=1)
    clockwise = sides[:, 0, 0] * sides[:, 1, 1] < sides[:, 0, 1] * sides[:, 1, 0]
    xy[clockwise] = xy[clockwise][:, ::-1]
    corners_m, numbers = np.unique(xy.reshape(-1, 2), axis=0, return_inverse=True)
    triangles = numbers.reshape(-1, 3).astype(np.int64)
    beyond = _triangles_beyond(triangles, len(corners_m))
    alone = np.flatnonzero(beyond.ravel() < 0)
    ends_m = corners_m[np.stack([triangles.ravel()[alone], triangles[:, [1, 2, 0]].ravel()[alone]], axis=1)]
    beyond.ravel()[alone] = np.where(_are_walls(ends_m, walls, standing, near_m), WALL, STANDING)
    grid = _grid_over(corners_m, len(triangles))
    offsets, items = tiling_kernels.sort_into_cells(corners_m, triangles, grid, GRID_MARGIN_M)
    return Triangles(corners_m, triangles, beyond, grid, offsets, items)


def _polygons(shape: Any) -> NDArray[np.object_]:
    """The polygons among the parts of a shape."""
    parts = shapely.get_parts(shapely.get_parts(np.atleast_1d(shape)))
    return np.asarray(parts[(shapely.get_type_id(parts) == 3) & (shapely.area(parts) > 0)])


def _small_parts(polygon: Any) -> list[Any]:
    """The polygon, cut across its longer side as often as it has too many corners."""
    if shapely.get_num_coordinates(polygon) <= MOST_CORNERS:
        return [polygon]
    x0, y0, x1, y1 = polygon.bounds
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    halves = [(x0, y0, x, y1), (x, y0, x1, y1)] if x1 - x0 >= y1 - y0 else [(x0, y0, x1, y), (x0, y, x1, y1)]
    parts = [part for half in halves for part in _polygons(shapely.intersection(polygon, shapely.box(*half)))]
    return [small for part in parts for small in _small_parts(part)]


def _triangles_beyond(triangles: Ints, corners: int) -> Ints:
    """(t, 3) the triangle that has the same side the other way round; STANDING where there is none, or more."""
    begins, ends = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    key, other = begins * corners + ends, ends * corners + begins
    order = np.argsort(key, kind="stable")
    ranked = key[order]
    at = np.searchsorted(ranked, other)
    only = np.searchsorted(ranked, other, side="right") - at == 1
    alone = np.searchsorted(ranked, key, side="right") - np.searchsorted(ranked, key) == 1
    beyond = np.where(only & alone, order[np.minimum(at, len(order) - 1)] // 3, STANDING)
    return np.asarray(beyond.reshape(-1, 3))


def _are_walls(ends_m: Floats, walls: Any, standing: Any, near_m: float) -> Flags:
    """Whether each side, ends (n, 2, 2), lies on walls and bodies do not stand at it: (n,) flags."""
    are_walls = np.ones(len(ends_m), np.bool_)
    shapely.prepare(walls)
    shapely.prepare(standing)
    for share in ALONG:
        left = np.flatnonzero(are_walls)
        places = shapely.points((1 - share) * ends_m[left, 0] + share * ends_m[left, 1])
        near = shapely.dwithin(walls, places, near_m)  # few are
        near[near] = ~shapely.dwithin(standing, places[near], near_m)
        are_walls[left] = near
    return are_walls


def _grid_over(corners_m: Floats, triangles: int) -> Grid:
    """A grid with about as many cells as there are triangles."""
    low, high = corners_m.min(axis=0), corners_m.max(axis=0)
    wide, tall = np.maximum(high - low, GRID_MARGIN_M)
    cell_m = max(math.sqrt(wide * tall / triangles), max(wide, tall) / triangles)
    return Grid(low[0], low[1], cell_m, int(wide / cell_m) + 1, int(tall / cell_m) + 1)

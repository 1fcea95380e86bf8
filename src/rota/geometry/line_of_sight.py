"""What hides what: straight lines against the edges of a region, and what one point sees."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from rota.geometry import kernels
from rota.geometry.kernels import EdgeGrid

Floats = NDArray[np.float64]

EDGES_PER_CELL = 0.25  # so many cells that most hold no edge at all
MOST_CELLS = 4_000_000


def edge_grid(edges_m: Floats, cell_m: float | None = None) -> EdgeGrid:
    """The border edges (k, 4) of a region, sorted into cells for the kernels; k may be 0 (an empty region).

    cell_m: size of a cell; None: chosen from the number of edges and the size of the region.
    """
    edges_m = np.ascontiguousarray(edges_m, dtype=np.float64).reshape(-1, 4)
    if not len(edges_m):
        edges_m = np.zeros((0, 4))
    xs, ys = edges_m[:, [0, 2]], edges_m[:, [1, 3]]
    low = np.array([xs.min(initial=np.inf), ys.min(initial=np.inf)])
    high = np.array([xs.max(initial=-np.inf), ys.max(initial=-np.inf)])
    if not len(edges_m):
        low, high = np.zeros(2), np.ones(2)
    span = np.maximum(high - low, 1e-6)
    if cell_m is None:
        cell_m = math.sqrt(span[0] * span[1] / max(400.0, len(edges_m) / EDGES_PER_CELL))
    cell_m = max(cell_m, math.sqrt(span[0] * span[1] / MOST_CELLS), float(span.max()) / 20_000)
    size = np.ceil(span / cell_m).astype(np.int64) + 2
    frame = np.array([low[0] - cell_m, low[1] - cell_m, cell_m])
    start = np.zeros(int(size.prod()) + 1, dtype=np.int64)
    kernels.fill_grid(frame, size, edges_m, start, np.zeros(0, dtype=np.int64), True)
    start = np.cumsum(start)
    items = np.zeros(int(start[-1]), dtype=np.int64)
    kernels.fill_grid(frame, size, edges_m, start[:-1].copy(), items, False)
    grid = EdgeGrid(frame, size, start, items, np.zeros(int(size.prod()), dtype=np.int64), edges_m)
    kernels.label_cells(grid)
    return grid


def segments_free(a_m: Floats, b_m: Floats, grid: EdgeGrid) -> NDArray[np.bool_]:
    """Which segments (n,) between points a and b (n, 2) of the region stay in it; touching its border is allowed."""
    return np.asarray(kernels.many_segments_free(_points(a_m), _points(b_m), grid), dtype=bool)


def points_inside(points_m: Floats, grid: EdgeGrid) -> NDArray[np.bool_]:
    """Which points (n, 2) lie in the region, its border included."""
    return np.asarray(kernels.many_points_inside(_points(points_m), grid), dtype=bool)


def _points(points_m: Floats) -> Floats:
    return np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 2)


def visibility_polygon(point_m: Floats, walls_m: Floats, reach_m: float) -> BaseGeometry:
    """What the point (2,) sees within its reach: a 128-gon that contains the circle, less the shadows of walls (k, 4).

    A wall on whose line the point lies casts no shadow. Returns a polygon, or several that touch in points.
    """
    x, y = float(point_m[0]), float(point_m[1])
    disc = shapely.Point(x, y).buffer(reach_m / math.cos(math.pi / 128), quad_segs=32)
    walls = walls_m.reshape(-1, 4)
    lines = shapely.linestrings(walls.reshape(-1, 2, 2))
    walls = walls[shapely.dwithin(lines, shapely.Point(x, y), reach_m * 1.01)] if len(walls) else walls
    to_ends = walls.reshape(-1, 2, 2) - (x, y)
    along = to_ends[:, 1] - to_ends[:, 0]
    off_line = to_ends[:, 0, 0] * to_ends[:, 1, 1] - to_ends[:, 0, 1] * to_ends[:, 1, 0]
    long = np.hypot(*along.T)
    solid = np.abs(off_line) > 1e-9 * np.maximum(long, 1e-12)
    to_ends, along, off_line, long = to_ends[solid], along[solid], off_line[solid], long[solid]
    if not len(to_ends):
        return disc
    far = 4 * reach_m
    ends_far = far * to_ends / np.maximum(np.hypot(to_ends[..., 0], to_ends[..., 1]), 1e-12)[..., None]
    away = np.column_stack([along[:, 1], -along[:, 0]]) / long[:, None]
    away *= np.where(off_line > 0, far, -far)[:, None]
    # beyond the wall: its ends, the rays through them, and straight behind it, so that no chord cuts the reach
    ring = np.stack([to_ends[:, 0], to_ends[:, 1], ends_far[:, 1], away, ends_far[:, 0]], axis=1) + (x, y)
    shadows = shapely.convex_hull(shapely.multipoints(ring))
    return shapely.difference(disc, shapely.union_all(shadows))

"""Exact shortest paths round obstacles: a visibility graph over reflex corners, joined by bitangents only."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry import kernels
from rota.geometry.free_space import border_segments, standing_parts
from rota.geometry.line_of_sight import edge_grid, points_inside, segments_free

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ROWS = 2_000  # points handled at once: bounds the memory of one question


class ShortestPaths:
    """Shortest paths in one region (exact in the polygons given); built once, asked often.

    A shortest path bends only at reflex corners of the region, and leaves both edges of such a corner on one side, so
    that the graph needs no other vertex and no other edge (de Berg et al., Computational Geometry, chapter 15).
    """

    def __init__(self, space: MultiPolygon) -> None:
        self._parts = standing_parts(space)
        self._grid = edge_grid(border_segments(space))
        self._corners = reflex_corners(space)
        graph = kernels.bitangents(self._corners, self._grid)
        if len(graph):
            self._between, self._before = dijkstra(csr_array(graph), directed=False, return_predecessors=True)
        else:
            self._between, self._before = np.zeros((0, 0)), np.zeros((0, 0), dtype=np.int32)
        self._tree = shapely.STRtree(list(self._parts))

    def part_of(self, points_m: Floats) -> Ints:
        """Index (n,) of the part of the region that holds each point (n, 2), its border included; -1 outside."""
        points_m = np.asarray(points_m, dtype=np.float64).reshape(-1, 2)
        part = np.full(len(points_m), -1, dtype=np.int64)
        found = self._tree.query(shapely.points(points_m), predicate="dwithin", distance=2 * kernels.TOLERANCE_M)
        part[found[0][::-1]] = found[1][::-1]
        return part

    def distances(self, a_m: Floats, b_m: Floats) -> Floats:
        """Lengths (n, m) of the shortest paths between points a (n, 2) and b (m, 2); inf between different parts."""
        a_m, b_m = _points(a_m), _points(b_m)
        from_b = kernels.see_corners(b_m, self._corners, self._grid)
        rows = [self._distances(a_m[i : i + ROWS], b_m, from_b) for i in range(0, len(a_m), ROWS)]
        return np.vstack(rows) if rows else np.zeros((0, len(b_m)))

    def _distances(self, a_m: Floats, b_m: Floats, from_b: Floats) -> Floats:
        from_a = kernels.see_corners(a_m, self._corners, self._grid)
        straight = np.hypot(*(a_m[:, None] - b_m[None]).transpose(2, 0, 1))
        ends_a, ends_b = np.repeat(a_m, len(b_m), axis=0), np.tile(b_m, (len(a_m), 1))
        free = segments_free(ends_a, ends_b, self._grid).reshape(straight.shape)
        round_corners = kernels.through_corners(from_a, self._between, from_b)
        return np.where(free, straight, round_corners)

    def all_pairs(self, points_m: Floats) -> Floats:
        """Lengths (n, n) of the shortest paths between all points (n, 2); symmetric, 0 on the diagonal."""
        found = self.distances(points_m, points_m)
        found = np.minimum(found, found.T)
        np.fill_diagonal(found, 0.0)
        return found

    def path(self, a_m: Floats, b_m: Floats) -> Floats:
        """The shortest path (k, 2) from a to b (2,), both ends included; PlanError when there is none."""
        a, b = _points(a_m), _points(b_m)
        if segments_free(a, b, self._grid)[0] and points_inside(np.vstack([a, b]), self._grid).all():
            return np.vstack([a, b])
        from_a = kernels.see_corners(a, self._corners, self._grid)[0]
        from_b = kernels.see_corners(b, self._corners, self._grid)[0]
        total = from_a[:, None] + self._between + from_b[None]
        if not total.size or not np.isfinite(total.min()):
            raise PlanError(f"there is no way from {a[0].tolist()} to {b[0].tolist()}: one is outside, or no path joins them")
        first, at = (int(i) for i in np.unravel_index(int(np.argmin(total)), total.shape))
        corners = [at]
        while at != first:
            at = int(self._before[first, at])
            corners.append(at)
        return without_standing(np.vstack([a, self._corners[corners[::-1], :2], b]))

    def paths_along(self, points_m: Floats) -> Floats:
        """The polyline (k, 2) along shortest paths through all points (n, 2) in their order."""
        points_m = _points(points_m)
        free = segments_free(points_m[:-1], points_m[1:], self._grid)
        pieces = [points_m[:1]]
        for i, straight in enumerate(free):
            pieces.append(points_m[i + 1 : i + 2] if straight else self.path(points_m[i], points_m[i + 1])[1:])
        return without_standing(np.vstack(pieces))


def reflex_corners(space: MultiPolygon) -> Floats:
    """Corners (c, 6) of the region where a path may bend: x, y, then the border's corner before and the one after."""
    found = [np.zeros((0, 6))]
    for ring in shapely.get_rings(shapely.get_parts(shapely.orient_polygons(space))):
        xy = shapely.get_coordinates(ring)[:-1]
        before, after = np.roll(xy, 1, axis=0), np.roll(xy, -1, axis=0)
        into, out = xy - before, after - xy
        # the region lies to the left of its oriented rings: a right turn is a reflex corner
        turn = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
        reflex = turn < -1e-12 * np.hypot(*into.T) * np.hypot(*out.T)
        found.append(np.hstack([xy, before, after])[reflex])
    return np.ascontiguousarray(np.vstack(found))


def without_standing(path_m: Floats) -> Floats:
    """The polyline without points that repeat the one before; at least both ends stay."""
    moves = np.concatenate([[True], (np.diff(path_m, axis=0) != 0).any(axis=1)])
    return path_m[moves] if moves.sum() > 1 else path_m[[0, -1]]


def _points(points_m: Floats) -> Floats:
    return np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 2)

"""The demanded region as convex pieces: lattice cells clipped exactly by the region, and their subdivision."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.check import tiling_kernels
from rota.check.arrays import Flags, Floats, Ints
from rota.check.tolerances import CONVEX_SHARE


@dataclass(frozen=True, kw_only=True, eq=False)
class Pieces:
    """n convex polygons: corners_m[offsets[k]:offsets[k + 1]] are the corners of the k-th, in order round it."""

    offsets: Ints
    corners_m: Floats

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def choose(self, which: Ints | Flags) -> Pieces:
        """The pieces at these indices, or where the mask is true."""
        index = np.flatnonzero(which) if which.dtype == np.bool_ else which
        counts = np.diff(self.offsets)[index]
        offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        rows = np.arange(offsets[-1]) + np.repeat(self.offsets[:-1][index] - offsets[:-1], counts)
        return Pieces(offsets=offsets, corners_m=np.ascontiguousarray(self.corners_m[rows]))

    def owners(self) -> Ints:
        """Index of the piece that each row of ``corners_m`` belongs to."""
        return np.repeat(np.arange(len(self), dtype=np.int64), np.diff(self.offsets))

    def areas_m2(self) -> Floats:
        """(n,) areas in square metres."""
        if not len(self):
            return np.empty(0)
        nxt = np.arange(1, len(self.corners_m) + 1)
        nxt[self.offsets[1:] - 1] = self.offsets[:-1]
        # seen from a corner of the piece itself, products stay small far from the origin
        first = np.repeat(self.corners_m[self.offsets[:-1]], np.diff(self.offsets), axis=0)
        a, b = self.corners_m - first, self.corners_m[nxt] - first
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        return 0.5 * np.abs(np.add.reduceat(cross, self.offsets[:-1]))

    def centres_m(self) -> Floats:
        """(n, 2) means of the corners, which lie inside."""
        if not len(self):
            return np.empty((0, 2))
        sums = np.add.reduceat(self.corners_m, self.offsets[:-1], axis=0)
        return np.asarray(sums / np.diff(self.offsets)[:, None])

    def sizes_m(self) -> Floats:
        """(n,) longer sides of the bounding boxes."""
        if not len(self):
            return np.empty(0)
        low = np.minimum.reduceat(self.corners_m, self.offsets[:-1], axis=0)
        high = np.maximum.reduceat(self.corners_m, self.offsets[:-1], axis=0)
        return np.asarray((high - low).max(axis=1))


def join(parts: list[Pieces]) -> Pieces:
    """All pieces of several sets in one."""
    counts = np.concatenate([np.zeros(1, np.int64), *(np.diff(part.offsets) for part in parts)])
    corners = np.vstack([np.empty((0, 2)), *(part.corners_m for part in parts)])
    return Pieces(offsets=np.cumsum(counts), corners_m=np.ascontiguousarray(corners))


def point_pieces(points_m: Floats) -> Pieces:
    """Points (n, 2) as pieces of one corner each."""
    points = np.ascontiguousarray(points_m, np.float64).reshape(-1, 2)
    return Pieces(offsets=np.arange(len(points) + 1, dtype=np.int64), corners_m=points)


def quarter(pieces: Pieces, cuts: Floats, narrowest_m: float) -> tuple[Pieces, Ints]:
    """Each piece cut along a line and the parts across their longer sides, and the index of each part's piece.

    cuts: (n, 3) nx, ny, c: the line n.p = c; nan: across the longer side. Slivers are dropped: parts whose middle is
    nearer than ``narrowest_m`` to one of their sides have no area to speak of.
    """
    offsets, corners, first = tiling_kernels.halve(pieces.offsets, pieces.corners_m, cuts, narrowest_m)
    across = np.full((len(first), 3), np.nan)
    offsets, corners, second = tiling_kernels.halve(offsets, corners, across, narrowest_m)
    return Pieces(offsets=offsets, corners_m=corners), first[second]


def convex_pieces(region: Any, size_m: float, narrowest_m: float) -> Pieces:
    """Lattice cells of about ``size_m`` clipped exactly by a polygonal region; empty for an empty region.

    Cells inside stay squares; a clip that is not convex becomes triangles. Slivers narrower than ``narrowest_m`` (from
    their middle) are left out.
    """
    if region.is_empty:
        return Pieces(offsets=np.zeros(1, np.int64), corners_m=np.empty((0, 2)))
    x0, y0, x1, y1 = region.bounds
    levels = max(0, math.ceil(math.log2(max(x1 - x0, y1 - y0) / size_m)))
    boxes = np.array([[x0, y0, x0 + size_m * 2**levels, y0 + size_m * 2**levels]])
    clips = np.array([region], dtype=object)
    whole = []
    for level in range(levels + 1):
        cells = shapely.box(*boxes.T)
        shapely.prepare(clips)
        inside = shapely.covers(clips, cells)
        whole.append(_split_boxes(boxes[inside], levels - level))
        boxes, clips, cells = boxes[~inside], clips[~inside], cells[~inside]
        clips = shapely.intersection(clips, cells)
        filled = shapely.area(clips) > 0
        boxes, clips = boxes[filled], clips[filled]
        if level < levels:
            boxes, clips = _split_boxes(boxes, 1), np.repeat(clips, 4)
    squares = np.vstack(whole)
    corners = squares[:, [0, 1, 2, 1, 2, 3, 0, 3]].reshape(-1, 2)
    inner = Pieces(offsets=np.arange(0, len(corners) + 1, 4, dtype=np.int64), corners_m=np.ascontiguousarray(corners))
    border = _convex_parts(clips)
    wide = tiling_kernels.half_widths(border.offsets, border.corners_m) > narrowest_m
    return join([inner, border.choose(wide)])


def _split_boxes(boxes: Floats, times: int) -> Floats:
    """Each box (x0, y0, x1, y1) quartered ``times`` times; the four parts of a box stay together."""
    for _ in range(times):
        x0, y0, x1, y1 = boxes.T
        xm, ym = (x0 + x1) / 2, (y0 + y1) / 2
        parts = [(x0, y0, xm, ym), (xm, y0, x1, ym), (x0, ym, xm, y1), (xm, ym, x1, y1)]
        boxes = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 4)
    return boxes


def _convex_parts(shapes: NDArray[np.object_]) -> Pieces:
    """The polygons among the parts of the shapes, those that are not convex as triangles."""
    parts = _polygons(shapes)
    hulls = shapely.convex_hull(parts)
    convex = shapely.area(hulls) <= shapely.area(parts) * (1 + CONVEX_SHARE)
    triangles = _polygons(shapely.constrained_delaunay_triangles(parts[~convex]))
    rings = shapely.get_exterior_ring(np.concatenate([hulls[convex], triangles]))
    corners, owner = shapely.get_coordinates(rings, return_index=True)
    counts = np.bincount(owner, minlength=len(rings))
    last = np.cumsum(counts) - 1  # the point that closes the ring
    offsets = np.concatenate([[0], np.cumsum(counts - 1)]).astype(np.int64)
    return Pieces(offsets=offsets, corners_m=np.ascontiguousarray(np.delete(corners, last, axis=0)))


def _polygons(shapes: NDArray[np.object_]) -> NDArray[np.object_]:
    """All polygons (p,) in shapes (n,) of any kind, without those of no area."""
    parts = shapely.get_parts(shapely.get_parts(shapes))
    return np.asarray(parts[(shapely.get_type_id(parts) == 3) & (shapely.area(parts) > 0)])

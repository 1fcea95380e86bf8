"""What hides what: straight lines against borders and walls, and what one point sees."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from rota.geometry import kernels, sight_kernels
from rota.geometry.kernels import EdgeGrid
from rota.model.arrays import Flags, Floats, Ints

Number = TypeVar("Number", np.float64, np.int64)

# Cells per edge: few enough to build in milliseconds, so many that most cells hold no edge and lines skip over them.
_CELLS_PER_EDGE = 16
_FEWEST_CELLS = 1024
_MOST_CELLS = 4_000_000

_SAME_CORNER = 1e-12  # of the reach: two neighbouring walls give their common end with as much rounding
_HIDDEN = -2  # where an obstacle begins at the point that looks


def edge_grid(edges_m: Floats, cell_m: float | None = None) -> EdgeGrid:
    """The edges (k, 4) of a border, metres x0, y0, x1, y1, sorted into square cells for the kernels.

    The space (for walls of sight: the obstacle) is on the left of each edge, as ``border_segments`` and ``sight_walls``
    of ``rota.geometry.free_space`` give them; edges of no length are left out. k may be 0: an empty space, or a view
    that nothing blocks. cell_m: size of a cell in metres; None, or a size that would need more than 4 million cells:
    chosen from the number of edges. Raises ValueError when an edge is not finite or cell_m not greater than 0.
    """
    edges = _rows(edges_m, 4, "edges_m")
    edges = edges[(edges[:, 0] != edges[:, 2]) | (edges[:, 1] != edges[:, 3])]
    if cell_m is not None and not (math.isfinite(cell_m) and cell_m > 0):
        raise ValueError(f"cell_m: {cell_m!r} is not allowed; must be a finite number greater than 0")
    ends = edges.reshape(-1, 2)
    low = ends.min(axis=0) if len(ends) else np.zeros(2)
    width, height = (ends.max(axis=0) - low if len(ends) else np.ones(2)) + 1e-6
    cells = min(max(_FEWEST_CELLS, _CELLS_PER_EDGE * len(edges)), _MOST_CELLS)
    own = max(math.sqrt(width * height / cells), max(width, height) / cells)
    cell = own if cell_m is None or (width / cell_m + 2) * (height / cell_m + 2) > _MOST_CELLS else float(cell_m)
    # touching is judged up to TOUCH_M; the rest is room for rounding where a line runs along the border of two cells
    margin = 1e-6 * cell + 4 * kernels.TOUCH_M + 1e-12 * float(np.abs(ends).max(initial=0.0))
    x0, y0 = float(low[0] - 0.5 * cell), float(low[1] - 0.5 * cell)
    nx, ny = int(width / cell) + 2, int(height / cell) + 2
    start, items = kernels.cells_of_edges(edges, x0, y0, cell, nx, ny, margin)
    row_start, row_items = kernels.rows_of_edges(edges, y0, cell, ny, margin)
    start, items = np.concatenate([start, start[-1] + row_start[1:]]), np.concatenate([items, row_items])
    clear = kernels.clearances(edges, x0, y0, cell, nx, ny, start, items)
    return EdgeGrid(x0, y0, cell, nx, ny, start, items, edges, clear)


def points_inside(points_m: Floats, grid: EdgeGrid) -> Flags:
    """Which points (n, 2) in metres lie in the closed space whose border the grid holds."""
    return np.asarray(kernels.points_in_space(_rows(points_m, 2, "points_m"), grid))


def segments_free(a_m: Floats, b_m: Floats, grid: EdgeGrid) -> Flags:
    """Which straight lines from a (n, 2) to b (n, 2) in metres stay in the closed space whose border the grid holds.

    Running along the border and through its corners is allowed. Both ends must lie in the space.
    """
    return np.asarray(kernels.free_segments(*_pairs(a_m, b_m), grid))


def sees(a_m: Floats, b_m: Floats, grid: EdgeGrid) -> Flags:
    """Which points b (n, 2) in metres are seen from points a (n, 2) between the walls of sight in the grid.

    A line of sight may touch obstacles and run along them; a point inside an obstacle neither sees nor is seen.
    """
    return np.asarray(kernels.seen_points(*_pairs(a_m, b_m), grid))


def visibility_polygon(
    point_m: tuple[float, float] | Floats, walls_m: Floats, reach_m: float, *, sides: int = 64
) -> Polygon | MultiPolygon:
    """What the point sees between walls (k, 4), cut to a regular polygon that contains the circle of radius reach_m.

    walls_m: metres x0, y0, x1, y1 with the obstacle on the left, as ``sight_walls`` gives them; they may meet at their
    ends only. sides: of the polygon, at least 3, one of them facing +x; 4 gives the square of half side reach_m. Views
    along a wall and past a corner are open. Exact up to rounding: between neighbouring directions of wall ends one
    wall, or the rim, is nearest.

    Empty when the point lies inside an obstacle; a MultiPolygon when it stands where obstacles touch, with a view on
    either side. Raises ValueError when reach_m is not greater than 0, or anything is not finite.
    """
    if not (math.isfinite(reach_m) and reach_m > 0):
        raise ValueError(f"reach_m: {reach_m!r} is not allowed; must be a finite number greater than 0")
    if sides < 3:
        raise ValueError(f"sides: {sides!r} is not allowed; must be 3 or more")
    viewer = _rows(np.asarray(point_m, dtype=np.float64).reshape(1, -1), 2, "point_m")[0]
    frame, bare = _frame(float(reach_m), sides)
    walls = _rows(walls_m, 4, "walls_m") - np.concatenate([viewer, viewer])
    low, high = np.minimum(walls[:, 1], walls[:, 3]), np.maximum(walls[:, 1], walls[:, 3])
    # walls at other heights are out of reach and cross no ray from the origin to the right
    near = np.ascontiguousarray(walls[(low <= frame[:, 1].max()) & (high >= frame[:, 1].min())])
    swept = _sweep(near, frame)
    ring = bare if swept is None else _corners_of(swept, reach_m)
    if len(ring) < 3:
        return Polygon()
    seen = Polygon(ring + viewer)
    if seen.is_valid:
        return seen
    parts = [part for part in shapely.get_parts(shapely.make_valid(seen)) if part.geom_type.endswith("Polygon")]
    joined = shapely.union_all(parts)
    return joined if isinstance(joined, Polygon | MultiPolygon) else Polygon()


@lru_cache(maxsize=16)
def _frame(reach_m: float, sides: int) -> tuple[Floats, Floats]:
    """The sides (n, 4) of a regular polygon round the circle of this radius, and the corners (k, 2) of a bare view."""
    angles = 2 * math.pi * (np.arange(sides) + 0.5) / sides
    rim = reach_m / math.cos(math.pi / sides) * np.column_stack([np.cos(angles), np.sin(angles)])
    frame = np.hstack([rim, np.roll(rim, -1, axis=0)])
    return frame, _corners_of(_between(frame, np.empty((0, 3))), reach_m)


def _corners_of(ring: Floats, reach_m: float) -> Floats:
    """The points of a border without those that are the ones before them."""
    step = ring - _before(ring)
    return ring[np.hypot(step[:, 0], step[:, 1]) > _SAME_CORNER * reach_m]


def _sweep(walls: Floats, frame: Floats) -> Floats | None:
    """Border (k, 2), turning left, of what the origin sees inside the frame; no rows when it lies in an obstacle.

    None: all within the frame.
    """
    lines, rays = np.empty((len(walls), 4)), np.empty((2 * len(walls), 3))
    count, touching = sight_kernels.lines_in_frame(walls, frame, lines, rays)
    if not touching and sight_kernels.is_inside(walls):
        return np.zeros((0, 2))
    return _between(np.concatenate([lines[:count], frame]), rays[:touching]) if count or touching else None


def _between(lines: Floats, rays: Floats) -> Floats:
    """Border (k, 2) of what the origin sees between lines (n, 4), the frame among them, and rays (m, 3)."""
    begins, ends, borders = _angles(lines[:, :2]), _angles(lines[:, 2:]), _angles(rays[:, :2])
    angles = np.unique(np.concatenate([begins, ends, borders]))
    middles = (angles + np.append(angles[1:], angles[0] + 2 * math.pi)) / 2
    first, last = np.searchsorted(angles, begins), np.searchsorted(angles, ends)
    nearest = sight_kernels.nearest_lines(lines, first, last, np.cos(middles), np.sin(middles))
    if len(rays):
        order = np.lexsort([rays[:, 2], borders])
        past = order[np.searchsorted(borders[order], angles, side="right") - 1]
        nearest[rays[past, 2] == 1] = _HIDDEN
    return _ring(lines, angles, nearest)


def _ring(lines: Floats, angles: Floats, nearest: Ints) -> Floats:
    """Both ends of each run of sectors in which one line is nearest; the origin where an obstacle begins at it."""
    sectors = np.flatnonzero(nearest != -1)  # a sector without a line is narrower than rounding
    seen = nearest[sectors]
    new = np.flatnonzero(seen != _before(seen))
    if not len(new):
        new = np.zeros(1, dtype=np.int64)
    starts, stops = sectors[new], sectors[np.append(new[1:], new[0]) - 1]
    line = seen[new]
    directions = np.stack([angles[starts], angles[(stops + 1) % len(angles)]], axis=1)
    ux, uy = np.cos(directions), np.sin(directions)
    x, y = lines[line, 0, None], lines[line, 1, None]
    wx, wy = lines[line, 2, None] - x, lines[line, 3, None] - y
    along = np.clip((y * ux - x * uy) / (wx * uy - wy * ux), 0.0, 1.0)
    ring = np.stack([x + along * wx, y + along * wy], axis=2)
    ring[line == _HIDDEN] = 0.0
    return ring.reshape(-1, 2)


def _before(values: NDArray[Number]) -> NDArray[Number]:
    """The value, or the row, before each one; the last one before the first."""
    return np.concatenate([values[-1:], values[:-1]])


def _angles(vectors: Floats) -> Floats:
    """Directions in (-pi, pi]; arctan2 alone has two values straight to the left."""
    angles = np.arctan2(vectors[:, 1], vectors[:, 0])
    return np.where(angles == -math.pi, math.pi, angles)


def _pairs(a_m: Floats, b_m: Floats) -> tuple[Floats, Floats]:
    a, b = _rows(a_m, 2, "a_m"), _rows(b_m, 2, "b_m")
    if len(a) != len(b):
        raise ValueError(f"a_m and b_m: {len(a)} and {len(b)} points; as many of one as of the other are needed")
    return a, b


def _rows(values: Floats, columns: int, name: str) -> Floats:
    rows = np.array(values, dtype=np.float64, order="C")
    rows = rows.reshape(-1, columns) if rows.size == 0 else rows
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise ValueError(f"{name}: shape {rows.shape} is not allowed; must be (n, {columns})")
    if not np.isfinite(rows).all():
        raise ValueError(f"{name}: row {int(np.argmin(np.isfinite(rows).all(axis=1)))} is not finite")
    return rows

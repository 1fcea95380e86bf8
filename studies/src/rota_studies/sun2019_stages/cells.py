"""Cells of Section 4.2 of Sun et al. 2019: ground cut into squares, and which of them a virtual sensor sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.errors import NoPlanFound
from rota.geometry import kernels as geometry_kernels
from rota.geometry.free_space import border_segments
from rota.geometry.line_of_sight import edge_grid, sees
from rota.planners.patrol.ground.samples import MOST_CELLS
from rota.planners.patrol.tolerances import TIE
from rota_studies.sun2019_stages import sight_kernels
from rota_studies.sun2019_stages.sight_kernels import CellTable, Ground
from rota_studies.sun2019_stages.stage_settings import BorderCells

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Lattice:
    """Squares of side cell_m, nx columns and ny rows from (x0, y0) on, metres; they contain a mission's area."""

    x0: float
    y0: float
    cell_m: float
    nx: int
    ny: int

    @property
    def points_m(self) -> Floats:
        """Centres and corners of all squares, (nx ny + (nx + 1) (ny + 1), 2): where covers look for places."""
        corners = np.meshgrid(np.arange(self.nx + 1.0), np.arange(self.ny + 1.0))
        centres = np.meshgrid(np.arange(self.nx) + 0.5, np.arange(self.ny) + 0.5)
        both = np.vstack([np.column_stack([x.ravel(), y.ravel()]) for x, y in (centres, corners)])
        return np.asarray(np.array([self.x0, self.y0]) + both * self.cell_m)


@dataclass(frozen=True, kw_only=True)
class Cells:
    """Cells of one zone: (m,) squares of the lattice (column, row), their areas, and what the kernels take of them."""

    lattice: Lattice
    shapes: NDArray[np.object_]
    square: Ints
    table: CellTable

    def __len__(self) -> int:
        return len(self.square)

    @property
    def centres_m(self) -> Floats:
        """The middle of each cell's corners, (m, 2) metres."""
        return np.asarray(self.table.centres)

    def choose(self, keep: Ints) -> Cells:
        """Only the cells of these ascending numbers (k,)."""
        return _cells(self.lattice, self.shapes[keep], self.square[keep])

    def quarter(self, number: Ints) -> Cells:
        """The same cells, but those of these numbers (k,) cut in four across the middle of their bounding boxes."""
        shapes = self.shapes[number]
        x0, y0, x1, y1 = shapely.bounds(shapes).T
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        boxes = np.stack(
            [shapely.box(*box) for box in ((x0, y0, x, y), (x, y0, x1, y), (x0, y, x, y1), (x, y, x1, y1))]
        )
        parts, of = _solid_parts(shapely.intersection(shapes, boxes).ravel(), self.lattice.cell_m)
        kept = np.delete(np.arange(len(self)), number)
        square = np.concatenate([self.square[kept], self.square[np.tile(number, 4)[of]]])
        return _cells(self.lattice, np.concatenate([self.shapes[kept], parts]), square)


def lattice_over(area: BaseGeometry, cell_m: float) -> Lattice:
    """The squares over the bounding box of an area, from its lower left corner on.

    Raises NoPlanFound where they would be more than four million.
    """
    x0, y0, x1, y1 = shapely.bounds(area)
    nx, ny = (max(1, int(np.ceil((high - low) / cell_m - 1e-9))) for low, high in ((x0, x1), (y0, y1)))
    if nx * ny > MOST_CELLS:
        least_m = np.sqrt((x1 - x0) * (y1 - y0) / MOST_CELLS)
        raise NoPlanFound(
            f"cell_m: cells of {cell_m:.6g} m over {x1 - x0:.6g} m by {y1 - y0:.6g} m are {nx * ny}; at most"
            f" {MOST_CELLS} are allowed, so cells of about {least_m:.2g} m or more"
        )
    return Lattice(x0=float(x0), y0=float(y0), cell_m=cell_m, nx=nx, ny=ny)


def cells_of(region: MultiPolygon, lattice: Lattice, *, hidden: MultiPolygon, border: BorderCells) -> Cells:
    """The cells of a zone's ground; ``hidden`` is what hides, obstacles and zones already covered.

    Squares that lie in the ground whole are cells. With border "clipped", the part of a border square in the ground is
    a cell, or each part where there are several, with the corners of the part; all the ground lies in cells. With
    "centre", a border square belongs to the zone in which its centre lies, and is asked for whole but for what is
    hidden. That is the picture of the paper's Figure 4: ground at a border may belong to no cell, and a zone smaller
    than a square may have none.
    """
    i0, j0, i1, j1 = _window(region, lattice)
    column, row = (grid.ravel() for grid in np.meshgrid(np.arange(i0, i1), np.arange(j0, j1)))
    low_x, low_y = lattice.x0 + column * lattice.cell_m, lattice.y0 + row * lattice.cell_m
    squares = shapely.box(low_x, low_y, low_x + lattice.cell_m, low_y + lattice.cell_m)
    shapely.prepare(region)
    if border == "centre":
        middle = lattice.cell_m / 2
        inside = shapely.intersects_xy(region, low_x + middle, low_y + middle)
        ground: BaseGeometry = hidden
        shapely.prepare(ground)
        keep = np.flatnonzero(inside)
        cut = shapely.intersects(ground, squares[keep])
        shapes = squares[keep]
        shapes[cut] = shapely.difference(shapes[cut], ground)
    else:
        keep = np.flatnonzero(shapely.intersects(region, squares))
        shapes = squares[keep]
        cut = ~shapely.covers(region, shapes)
        shapes[cut] = shapely.intersection(shapes[cut], region)
    square = row[keep] * lattice.nx + column[keep]
    parts, of = _solid_parts(shapes, lattice.cell_m)
    return _cells(lattice, parts, square[of].astype(np.int64))


def ground_for(space: MultiPolygon, hidden: MultiPolygon, reach_m: float) -> Ground:
    """Where sensors may be, and the walls round what hides, sorted by the buckets within reach_m of them."""
    walls = edge_grid(border_segments(hidden))
    # the geometry's kernels allocate, which they may not when they are first compiled for a caller that must not
    sees(np.zeros((0, 2)), np.zeros((0, 2)), walls)
    edges = walls.edges
    low = edges.reshape(-1, 2).min(axis=0) if len(edges) else np.zeros(2)
    high = edges.reshape(-1, 2).max(axis=0) if len(edges) else np.ones(2)
    # buckets outside of all walls stand for all that lies beyond them: they must not come near any
    x0, y0 = low - 2 * reach_m
    bucket_m = max(reach_m, float((high - low).max() / 1000))
    columns, rows = (int(np.ceil(wide / bucket_m)) + 1 for wide in high - low + 4 * reach_m)
    start, items = geometry_kernels.cells_of_edges(edges, x0, y0, bucket_m, columns, rows, 1.001 * reach_m)
    return Ground(
        space=edge_grid(border_segments(space)), walls=walls, reach_m=float(reach_m), x0=float(x0), y0=float(y0),
        bucket_m=bucket_m, columns=columns, rows=rows, wall_start=start, wall_item=items,
    )  # fmt: skip


def cells_seen_from(places_m: Floats, cells: Cells, ground: Ground) -> tuple[Ints, Ints]:
    """The cells that a virtual sensor sees from each place (n, 2) metres: starts (n + 1,) and ascending cell numbers.

    A cell is seen when all its corners are within ``ground.reach_m`` and nothing hides them (Section 4.2): a disc that
    holds the corners holds the cell. From inside of what hides nothing is seen. Whether a sensor may be at a place is
    not asked here.
    """
    places = np.ascontiguousarray(places_m, dtype=np.float64).reshape(-1, 2)
    most = sight_kernels.most_in_reach(cells.table, ground.reach_m)
    start, items = sight_kernels.cells_seen_from(places, cells.table, ground, most)
    return start, items


def _solid_parts(shapes: NDArray[np.object_], cell_m: float) -> tuple[NDArray[np.object_], Ints]:
    """The polygons (p,) in geometries of any kind, without slivers of rounding, and the index of its geometry."""
    parts, of = shapely.get_parts(shapes, return_index=True)
    parts, of_part = shapely.get_parts(parts, return_index=True)
    solid = shapely.area(parts) > TIE * cell_m**2
    return parts[solid], np.asarray(of[of_part][solid], dtype=np.int64)


def _cells(lattice: Lattice, shapes: NDArray[np.object_], square: Ints) -> Cells:
    """The cells of polygons (m,), each in the square of the lattice of that number (m,), sorted by their squares."""
    order = np.argsort(square, kind="stable")
    shapes, square = shapes[order], square[order]
    xy, of = shapely.get_coordinates(shapes, return_index=True)
    corners, item = np.unique(xy.reshape(-1, 2), axis=0, return_inverse=True)
    pairs = np.unique(np.column_stack([of, item.ravel()]), axis=0)  # each ring ends where it began
    corner_start = np.searchsorted(pairs[:, 0], np.arange(len(shapes) + 1))
    count = np.maximum(np.diff(corner_start), 1)
    centres = np.zeros((len(shapes), 2))
    np.add.at(centres, pairs[:, 0], corners[pairs[:, 1]])
    table = CellTable(
        x0=lattice.x0, y0=lattice.y0, cell_m=lattice.cell_m, nx=lattice.nx, ny=lattice.ny,
        square_start=np.searchsorted(square, np.arange(lattice.nx * lattice.ny + 1)).astype(np.int64),
        corner_start=corner_start.astype(np.int64), corner_item=np.ascontiguousarray(pairs[:, 1], dtype=np.int64),
        corners=np.ascontiguousarray(corners), centres=centres / count[:, None],
    )  # fmt: skip
    return Cells(lattice=lattice, shapes=shapes, square=square, table=table)


def _window(region: BaseGeometry, lattice: Lattice) -> tuple[int, int, int, int]:
    """First column and row of the squares that the region's bounding box meets, and those after the last square."""
    x0, y0, x1, y1 = shapely.bounds(region)
    i0, j0 = int((x0 - lattice.x0) / lattice.cell_m), int((y0 - lattice.y0) / lattice.cell_m)
    i1, j1 = int((x1 - lattice.x0) / lattice.cell_m) + 1, int((y1 - lattice.y0) / lattice.cell_m) + 1
    return max(i0, 0), max(j0, 0), min(i1, lattice.nx), min(j1, lattice.ny)

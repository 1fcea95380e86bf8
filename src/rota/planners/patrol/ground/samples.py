"""The points that tours are made to see: a lattice over the demanded regions, their borders and their corners."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.geometry import kernels
from rota.geometry.free_space import DemandedRegion
from rota.model.arrays import Flags, Floats, Ints, ShortInts
from rota.model.mission import Robot, inner_reach_m
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.depth_kernels import depths_near_walls
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.wall_kernels import WallCells, walls_that_hide
from rota.planners.patrol.tolerances import ON_LINE_M, SAME_PLACE_M, TO_SPARE

MANY_CORNERS = 12_000  # of borders: of more, points stand for their neighbours
TOGETHER = 2_000  # places or points that one thread looks at
MOST_CELLS = 4_000_000  # of any table: of those into which walls are sorted, or ground is cut, or of pairs of places

Items = TypeVar("Items", Ints, ShortInts)
Rows = tuple[Ints, Ints]  # starts (n + 1,) of n rows, and the items of all


@dataclass(frozen=True, kw_only=True)
class SamplePoints:
    """Points to be seen. All arrays (n,): metres, m2 of ground each stands for, index into the periods, and so on.

    visit_m: 0, or for a zone that asks for visits the distance at which a robot is surely inside. shrink_m: how much
    shorter the sensor is taken for this point, since it stands for the ground round it. region: index of the demand.
    row, column: place in the region's lattice, -1 for points that lie on none.
    """

    xy_m: Floats
    area_m2: Floats
    period: Ints
    visit_m: Floats
    shrink_m: Floats
    region: Ints
    row: Ints
    column: Ints

    def __len__(self) -> int:
        return len(self.area_m2)

    def __getitem__(self, which: Flags | Ints | slice) -> SamplePoints:
        return SamplePoints(
            xy_m=self.xy_m[which],
            area_m2=self.area_m2[which],
            period=self.period[which],
            visit_m=self.visit_m[which],
            shrink_m=self.shrink_m[which],
            region=self.region[which],
            row=self.row[which],
            column=self.column[which],
        )


def join(parts: Sequence[SamplePoints]) -> SamplePoints:
    """All points of the parts, in order; parts may be empty."""
    return SamplePoints(
        xy_m=np.concatenate([p.xy_m for p in parts]).reshape(-1, 2),
        area_m2=np.concatenate([p.area_m2 for p in parts]),
        period=np.concatenate([p.period for p in parts]),
        visit_m=np.concatenate([p.visit_m for p in parts]),
        shrink_m=np.concatenate([p.shrink_m for p in parts]),
        region=np.concatenate([p.region for p in parts]),
        row=np.concatenate([p.row for p in parts]),
        column=np.concatenate([p.column for p in parts]),
    )


def points_of(
    xy_m: Floats, area_m2: float | Floats, period: int, region: int, *, visit_m: float = 0.0, shrink_m: float = 0.0
) -> SamplePoints:
    """Points of one region that share everything but the place (and perhaps the area)."""
    n = len(xy_m)
    return SamplePoints(
        xy_m=np.asarray(xy_m, dtype=np.float64).reshape(-1, 2),
        area_m2=np.broadcast_to(np.asarray(area_m2, dtype=np.float64), n).copy(),
        period=np.full(n, period, dtype=np.int64),
        visit_m=np.full(n, visit_m),
        shrink_m=np.full(n, shrink_m),
        region=np.full(n, region, dtype=np.int64),
        row=np.full(n, -1, dtype=np.int64),
        column=np.full(n, -1, dtype=np.int64),
    )


def thin(points: SamplePoints) -> SamplePoints:
    """Every other point of every other row of the lattices, with four times the area, and all others."""
    lattice = points.row >= 0
    kept = points[np.flatnonzero(~lattice | ((points.row % 2 == 0) & (points.column % 2 == 0)))]
    lattice = kept.row >= 0
    return replace(
        kept,
        row=np.where(lattice, kept.row // 2, kept.row),
        column=np.where(lattice, kept.column // 2, kept.column),
        area_m2=np.where(lattice, 4 * kept.area_m2, kept.area_m2),
    )


def lattice(shape: MultiPolygon, spacing_m: float) -> Floats:
    """Centres (n, 2) of the lattice squares that lie in the shape."""
    return lattice_places(shape, spacing_m)[0]


def lattice_places(shape: MultiPolygon, spacing_m: float) -> tuple[Floats, Ints, Ints]:
    """Centres (n, 2) of the lattice squares that lie in the shape, row by row, with their rows and columns (n,)."""
    x0, y0, x1, y1 = shape.bounds
    columns, rows = int(np.ceil((x1 - x0) / spacing_m)), int(np.ceil((y1 - y0) / spacing_m))
    # centred, so that what is left over is shared by both borders
    xs = (x0 + x1) / 2 + (np.arange(columns) - (columns - 1) / 2) * spacing_m
    ys = (y0 + y1) / 2 + (np.arange(rows) - (rows - 1) / 2) * spacing_m
    shapely.prepare(shape)
    some = max(1, TOGETHER // columns)  # rows that are asked together, of narrow ground
    inside = [
        first * columns + np.flatnonzero(shapely.contains_xy(shape, *np.meshgrid(xs, ys[first : first + some])))
        for first in range(0, rows, some)
    ]
    row, column = np.divmod(np.concatenate(inside).astype(np.int64), columns)
    return np.column_stack([xs[column], ys[row]]), row, column


def border(shape: MultiPolygon, spacing_m: float, inset_m: float) -> Floats:
    """Points (n, 2) along the borders at most ``spacing_m`` apart, corners included, moved ``inset_m`` inwards."""
    inner = shape.buffer(-inset_m, join_style="mitre", mitre_limit=3.0)
    if inner.is_empty:
        inner = shape
    dense = shapely.segmentize(inner.boundary, spacing_m)
    return one_a_cell(np.unique(shapely.get_coordinates(dense), axis=0), spacing_m / 4)


def one_a_cell(xy_m: Floats, cell_m: float) -> Floats:
    """The points (n, 2), or, of very many, the first in each cell of a lattice: ragged walls have a corner a pixel."""
    if len(xy_m) <= MANY_CORNERS:
        return xy_m
    _, first = np.unique(np.floor(xy_m / cell_m).astype(np.int64), axis=0, return_index=True)
    return xy_m[np.sort(first)]


def region_points(
    region: DemandedRegion,
    index: int,
    period: int,
    space: MultiPolygon,
    *,
    spacing_m: float,
    shrink_m: float,
    inset_m: float,
) -> SamplePoints:
    """The points that stand for one demanded region; a zone that asks for visits is one point where robots can be.

    A zone that no robot can be in is no point.
    """
    if region.demand == "visit":
        return visit_point(region.shape, space, index, period, region.shape.area)
    places_m, row, column = lattice_places(region.shape, spacing_m)
    inside = points_of(places_m, spacing_m**2, period, index, shrink_m=shrink_m)
    inside = replace(inside, row=row, column=column)
    edge = points_of(border(region.shape, spacing_m, inset_m), spacing_m**2 / 4, period, index)
    return join([inside, edge])


def visit_point(shape: MultiPolygon, space: MultiPolygon, index: int, period: int, area_m2: float) -> SamplePoints:
    """The middle of the largest circle in the part of a zone where robots can be; within its radius they are inside.

    Where zone and space only touch, any point where they do, with next to no radius; no point where they are apart.
    """
    inside = shapely.intersection(shape, space)
    parts = polygons_of(inside).geoms
    if not parts:
        touched = shapely.get_coordinates(inside.point_on_surface())
        return points_of(touched, area_m2, period, index, visit_m=SAME_PLACE_M)
    ends = shapely.get_coordinates(shapely.maximum_inscribed_circle(max(parts, key=lambda part: float(part.area))))
    radius_m = float(np.hypot(*(ends[1] - ends[0])))
    return points_of(ends[:1], area_m2, period, index, visit_m=max(0.98 * radius_m, SAME_PLACE_M))


def prepare(
    points: SamplePoints,
    walls: Floats,
    *,
    reach_m: float,
    weight: Floats,
    wall_margin_m: float,
    known: Rows | None = None,
) -> tuple[SamplePoints, Samples, Ints]:
    """The points (n) in the order in which the kernels take them, as they take them, and that order (n,).

    walls: (k, 4) segments that block sight, lengthened by ``wall_margin_m`` at both ends so that nothing counts as seen
    by a hair's breadth. Points on lattices stand first, row by row; the others by bins of the size of the reach. Each
    knows the walls within reach. known: the walls of the first points, which need not be found again.
    """
    far_m = max(reach_m, float(points.visit_m.max(initial=0.0)))
    on_lattice = np.flatnonzero(points.row >= 0)
    on_lattice = on_lattice[np.lexsort((points.column[on_lattice], points.row[on_lattice], points.region[on_lattice]))]
    loose = np.flatnonzero(points.row < 0)
    low = points.xy_m.min(axis=0)
    cell_m = max(reach_m / 2, 1e-9)
    places = ((points.xy_m[loose] - low) / cell_m).astype(np.int64)
    bins = places.max(axis=0, initial=0) + 1
    which = places[:, 1] * bins[0] + places[:, 0]
    by_bin = np.argsort(which, kind="stable")
    start = len(on_lattice) + np.searchsorted(which[by_bin], np.arange(bins[0] * bins[1] + 1))
    order = np.concatenate([on_lattice, loose[by_bin]]).astype(np.int64)
    if known is None:
        wall_start, wall_item = walls_in_reach(points[order], walls, reach_m)
    else:
        new = points[np.arange(len(known[0]) - 1, len(points))]
        rows = joined_rows(known, walls_in_reach(new, walls, reach_m))
        wall_start, wall_item = rows_in_order(*rows, order)
    points = points[order]
    along = np.diff(walls.reshape(-1, 2, 2), axis=1)[:, 0]
    along *= wall_margin_m / np.maximum(np.hypot(along[:, :1], along[:, 1:]), 1e-12)
    longer = walls.reshape(-1, 4) + np.hstack([-along, along])
    frames, frame_ints, column_start = lattice_frames(points[: len(on_lattice)])
    depth2, depth_row = depths_near_walls(points.xy_m, wall_start, wall_item, longer)
    samples = Samples(
        x=np.ascontiguousarray(points.xy_m[:, 0]),
        y=np.ascontiguousarray(points.xy_m[:, 1]),
        weight=np.ascontiguousarray(weight[order]),
        period=points.period,
        visit_m=points.visit_m,
        shrink_m=points.shrink_m,
        wall_start=wall_start,
        wall_item=wall_item,
        walls=np.ascontiguousarray(longer),
        depth2=depth2,
        depth_row=depth_row,
        next_walled=next_with_walls(wall_start),
        frames=frames,
        frame_ints=frame_ints,
        column_start=column_start,
        bin_start=start.astype(np.int64),
        origin=np.array([low[0], low[1], cell_m, far_m, 1.001 * wall_margin_m + ON_LINE_M]),
        bins=bins.astype(np.int64),
    )
    return points, samples, order


def lay_out(
    points: SamplePoints, walls: Floats, robot: Robot, *, weight: Floats | None = None, known: Rows | None = None
) -> tuple[SamplePoints, Samples, Ints]:
    """What ``prepare`` makes of points for a robot. weight (n,): what each is worth; None: the area it stands for."""
    return prepare(
        points,
        walls,
        reach_m=robot.sensor.reach_m,
        weight=points.area_m2 if weight is None else weight,
        wall_margin_m=TO_SPARE * inner_reach_m(robot.sensor),
        known=known,
    )


def known_walls(samples: Samples, which: Ints | None = None) -> Rows:
    """The walls of each of the prepared points, or of some of them (k,)."""
    rows = samples.wall_start, samples.wall_item
    return rows if which is None else rows_in_order(*rows, which)


def joined_rows(first: Rows, second: Rows) -> Rows:
    """Two lists of rows, each as starts (n + 1,) and items, as one."""
    start = np.concatenate([first[0], first[0][-1] + second[0][1:]])
    return start, np.concatenate([first[1], second[1]])


def rows_in_order(start: Ints, items: Items, order: Ints) -> tuple[Ints, Items]:
    """Rows of items, given by their starts (n + 1,), in another order (n,)."""
    sizes = np.diff(start)[order]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    which = np.arange(ends[-1]) + np.repeat(start[order] - ends[:-1], sizes)
    return ends.astype(np.int64), items[which]


def lattice_frames(points: SamplePoints) -> tuple[Floats, Ints, NDArray[np.int32]]:
    """Where the lattices of the points, sorted by region, row and column, lie, and where their rows begin.

    Per lattice (f, 4) the place of row 0 and column 0, the spacing, and by how much the sensor is taken shorter;
    (f, 4) the period class, rows, columns, and where its part of the table begins. The table tells for each row and
    column (one past the last included) the first point at or after it; rows that lie between two points are empty.
    """
    frames, ints, tables = [], [], [np.zeros(0, dtype=np.int64)]
    begin = 0
    for region in np.unique(points.region):
        first, end = np.searchsorted(points.region, [region, region + 1])
        own = points[first:end]
        rows, columns = int(own.row.max()) + 1, int(own.column.max()) + 1
        spacing_m = float(np.sqrt(own.area_m2[0]))
        corner_m = own.xy_m[0] - spacing_m * np.array([own.column[0], own.row[0]])
        frames.append([*corner_m, spacing_m, own.shrink_m[0]])
        ints.append([own.period[0], rows, columns, begin])
        place = own.row * (columns + 1) + own.column
        tables.append(first + np.searchsorted(place, np.arange(rows * (columns + 1))))
        begin += rows * (columns + 1)
    return (
        np.array(frames, dtype=np.float64).reshape(-1, 4),
        np.array(ints, dtype=np.int64).reshape(-1, 4),
        np.concatenate(tables).astype(np.int32),
    )


def next_with_walls(wall_start: Ints) -> Ints:
    """For each point (n,) the first one, from itself on, that has walls near it; n when none follows."""
    n = len(wall_start) - 1
    own = np.where(np.diff(wall_start) > 0, np.arange(n), n)
    return np.ascontiguousarray(np.minimum.accumulate(own[::-1])[::-1], dtype=np.int64)


def walls_in_reach(points: SamplePoints, walls: Floats, reach_m: float) -> tuple[Ints, Ints]:
    """For each point the walls within reach that hide anything from it: starts (n + 1,), indices; visits have none."""
    n = len(points)
    if not len(walls):
        return np.zeros(n + 1, dtype=np.int64), np.zeros(0, dtype=np.int64)
    wanted = np.flatnonzero(points.visit_m == 0)
    cells = wall_cells(walls, reach_m / 2)
    some = np.array_split(np.ascontiguousarray(points.xy_m[wanted]), 1 + len(wanted) // TOGETHER)
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        found = list(pool.map(lambda xy_m: walls_that_hide(xy_m, float(reach_m), cells), some))
    sizes = np.zeros(n, dtype=np.int64)
    sizes[wanted] = np.concatenate([np.diff(start) for start, _ in found])
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), np.concatenate([items for _, items in found])


def wall_cells(walls: Floats, cell_m: float) -> WallCells:
    """The walls (k, 4), k at least 1, sorted into cells of about that size."""
    low, high = walls.reshape(-1, 2).min(axis=0), walls.reshape(-1, 2).max(axis=0)
    width_m, height_m = high - low
    cell_m = max(cell_m, float(np.sqrt(width_m * height_m / MOST_CELLS)), float(max(width_m, height_m)) / MOST_CELLS)
    margin_m = 1e-6 * cell_m
    x0, y0 = float(low[0]) - cell_m / 2, float(low[1]) - cell_m / 2
    nx, ny = int(width_m / cell_m) + 2, int(height_m / cell_m) + 2
    edges = np.ascontiguousarray(walls)
    start, items = kernels.cells_of_edges(edges, x0, y0, cell_m, nx, ny, margin_m)
    return WallCells(edges, x0, y0, cell_m, nx, ny, start, items)

"""Exact shortest paths round obstacles: a visibility graph over reflex corners, joined by bitangents only."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry import corner_kernels, kernels
from rota.geometry.corner_kernels import Ends
from rota.geometry.free_space import border_corners, border_segments, standing_parts
from rota.geometry.kernels import EdgeGrid
from rota.geometry.known_links import boxes_of_change, known_links, nothing_known
from rota.geometry.line_of_sight import edge_grid
from rota.geometry.threads import side_by_side
from rota.model.arrays import Floats, Ints

MOST_DENSE = 3_000  # corners: with as many, lengths and ways between all of them take some 100 MB
ROWS_TOGETHER, SOURCES_TOGETHER = 200, 50
FEW_CORNERS = 300  # with more, what corners points see is remembered
MOST_REMEMBERED = 100_000  # points
MANY_STEPPED = 100  # points between which ways from point to point are kept
MOST_MEASURED = 8  # sets of points between which all lengths are kept


class ShortestPaths:
    """Shortest paths in a closed space, exact in the polygons given; the graph is kept between questions.

    A shortest path bends only at reflex corners of the space, and keeps both edges of such a corner on one side
    (de Berg et al., Computational Geometry, 3rd ed., chapter 15), so the graph needs no other corners and no other
    links. Points on borders and at corners are in the space. Parts that only touch are apart: no path leads from one
    to the other. Obstacles that touch in a point leave a way through that point, as the closed space does.

    corners_m: (c, 2) metres. ``corner_lengths_m`` and ``corner_before`` hold the paths between corners; they take
    c * c * 12 bytes and are made when a path first needs a corner. With more than ``most_dense`` corners links alone
    are kept, and every question is searched for along them. like: paths in much the same space, whose links are kept.
    """

    def __init__(self, space: MultiPolygon, *, most_dense: int = MOST_DENSE, like: ShortestPaths | None = None) -> None:
        self.parts = standing_parts(space)
        self.grid = edge_grid(border_segments(space))
        self._part_grids: list[EdgeGrid] = []
        for part in self.parts:
            alone = len(self.parts) == 1
            self._part_grids.append(self.grid if alone else edge_grid(border_segments(MultiPolygon([part]))))
        corners_of_parts = [np.hstack(border_corners(MultiPolygon([part]))) for part in self.parts]
        self._corners = np.ascontiguousarray(np.vstack([np.zeros((0, 6)), *corners_of_parts]))
        self._corner_part = np.repeat(
            np.arange(len(corners_of_parts), dtype=np.int64), [len(corners) for corners in corners_of_parts]
        )
        self.corners_m: Floats = np.ascontiguousarray(self._corners[:, :2])
        self._dense = len(self.corners_m) <= most_dense
        knows_links = like is not None and "_links" in like.__dict__ and not self._dense
        self._like = like if knows_links else None  # until the links are made
        # points between which all lengths were asked for, with these: some of them are often asked for again
        self._measured: tuple[tuple[dict[tuple[float, ...], int], Floats], ...] = ()
        # the corners that points see along tangents, where that takes a look at very many: tours ask again and again
        self._seen_corners: dict[tuple[float, ...], Ints] = {}
        # the last ways from point to point of many points, with these and the step: a tour asks again after its cluster
        self._stepped: tuple[Floats, float, Floats] | None = None

    def __getstate__(self) -> dict[str, object]:
        """What is sent to another process: all but what was asked for before, which other threads may change."""
        return {**self.__dict__, "_measured": (), "_seen_corners": {}, "_like": None, "_stepped": None}

    @cached_property
    def _between(self) -> tuple[Floats, NDArray[np.int32]]:
        """Lengths between all corners and, for each pair, the corner before the last, as dijkstra gives them."""
        graph = self._links.sorted_indices()
        if not graph.nnz:
            lengths = np.where(np.eye(len(self.corners_m), dtype=bool), 0.0, np.inf)
            return lengths, np.full(graph.shape, -9999, dtype=np.int32)
        some = [dijkstra(graph, indices=rows, return_predecessors=True) for rows in _some_rows(len(self.corners_m))]
        lengths, before = (np.ascontiguousarray(np.vstack(parts)) for parts in zip(*some, strict=True))
        return lengths, before

    @cached_property
    def _links(self) -> csr_array:
        """The lengths (c, c) of the links between corners."""
        count = len(self.corners_m)
        known, like = nothing_known(count), self._like
        if like is not None:
            changed_m = boxes_of_change(self.grid.edges, like.grid.edges)
            known = known_links(self._numbered, like._numbered, like._links, changed_m)
        self._like = None

        def link(first: int) -> NDArray[np.int32]:
            last = min(first + ROWS_TOGETHER, count)
            found: NDArray[np.int32] = corner_kernels.bitangents_of(
                first, last, self._corners, self._corner_part, self.grid, known
            )
            return found

        pairs = np.vstack([np.zeros((0, 2), dtype=np.int32), *side_by_side(link, range(0, count, ROWS_TOGETHER))])
        one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
        step = self.corners_m[one] - self.corners_m[other]
        return csr_array((np.hypot(step[:, 0], step[:, 1]), (one, other)), shape=(count, count))

    @property
    def _numbered(self) -> Floats:
        """The corners (c, 7), each with the number of its part."""
        return np.column_stack([self._corners, self._corner_part])

    @property
    def corner_lengths_m(self) -> Floats:
        """Lengths (c, c) of the shortest paths between corners in metres; inf where none leads."""
        return self._between[0]

    @property
    def corner_before(self) -> NDArray[np.int32]:
        """Corner (c, c) before the second on the shortest path from the first; negative where there is none."""
        return self._between[1]

    def part_of(self, points_m: Floats) -> Ints:
        """Index (n,) into ``parts`` of the part that each point (n, 2) lies in, the first of several; -1 outside."""
        points = _points(points_m)
        part = np.full(len(points), -1, dtype=np.int64)
        for index, grid in enumerate(self._part_grids):
            left = np.flatnonzero(part < 0)
            if not len(left):
                break
            part[left[kernels.points_in_space(points[left], grid)]] = index
        return part

    def distances(self, a_m: Floats, b_m: Floats) -> Floats:
        """Lengths (n, m) in metres of the shortest paths from points a (n, 2) to points b (m, 2).

        inf between different parts and from and to points outside.
        """
        a, b = self._alone(a_m), self._alone(b_m)
        path_m = self._lengths(a, b, symmetric=False)  # of the straight ways
        bent = np.isinf(path_m) & (a.part[:, None] == b.part[None]) & (a.part[:, None] >= 0)
        rows, columns = np.flatnonzero(bent.any(axis=1)), np.flatnonzero(bent.any(axis=0))
        if len(rows):
            some = self._bent_lengths(a.points[rows], b.points[columns])
            path_m[np.ix_(rows, columns)] = np.where(bent[np.ix_(rows, columns)], some, path_m[np.ix_(rows, columns)])
        return path_m

    def _bent_lengths(self, a_m: Floats, b_m: Floats) -> Floats:
        """The same for points some of which do not see each other."""
        a, b = self._ends(a_m), self._ends(b_m)
        if not self._dense and len(b.points) < len(a.points):  # each point searched from costs a search
            return np.ascontiguousarray(self._lengths(b, a, symmetric=False).T)
        return self._lengths(a, b, symmetric=False)

    def all_pairs(self, points_m: Floats) -> Floats:
        """Lengths (n, n) in metres of the shortest paths between all points (n, 2); exactly symmetric.

        inf between different parts; points outside have inf everywhere, the diagonal included.
        """
        if self._dense:
            ends = self._ends(points_m)
            return self._lengths(ends, ends, symmetric=True)
        points = _points(points_m)
        keys = list(map(tuple, points.tolist()))
        for row_of, lengths_m in self._measured:
            if all(key in row_of for key in keys):
                rows = [row_of[key] for key in keys]
                return np.ascontiguousarray(lengths_m[np.ix_(rows, rows)])
        ends = self._ends(points)
        lengths_m = self._lengths(ends, ends, symmetric=True)
        latest = (dict(zip(keys, range(len(keys)), strict=True)), lengths_m)
        self._measured = (latest, *self._measured[: MOST_MEASURED - 1])
        return lengths_m.copy()

    def lengths_from_point_to_point(self, points_m: Floats, step_m: float) -> Floats:
        """Lengths (n, n) in metres of ways between all points (n, 2) that lead past others of them, symmetric.

        They are shortest paths where these are no longer than ``step_m``. Longer ones are made of such paths, from one
        point to the next; twice as long steps are tried until all points of a part are reached. So they are hardly too
        long where points lie closer than that, and on ground with very many corners found much sooner. inf between
        different parts.
        """
        if self._dense:
            return self.all_pairs(points_m)
        last = self._stepped
        if last is not None and step_m == last[1] and np.array_equal(points_m, last[0]):
            return last[2].copy()
        lengths_m = self._lengths_by_steps(points_m, step_m)
        if len(lengths_m) > MANY_STEPPED:
            self._stepped = np.array(points_m), step_m, lengths_m.copy()
        return lengths_m

    def _lengths_by_steps(self, points_m: Floats, step_m: float) -> Floats:
        """Lengths between many points: short ones are searched, and long ones are sums of those."""
        ends = self._ends(points_m)
        together = (ends.part[:, None] == ends.part[None]) & (ends.part[:, None] >= 0)
        while True:
            near_m = self._searched_lengths(ends, ends, symmetric=True, most_m=step_m)
            one, other = np.nonzero(np.isfinite(near_m) & (near_m > 0))
            graph = csr_array((near_m[one, other], (one, other)), shape=near_m.shape)
            rows_m = [dijkstra(graph, directed=False, indices=rows) for rows in _some_rows(len(near_m))]
            lengths_m = np.vstack([np.zeros((0, len(near_m))), *rows_m])
            lengths_m[near_m == 0] = 0.0
            if np.isfinite(lengths_m[together]).all():
                return np.asarray(np.minimum(lengths_m, lengths_m.T))
            step_m *= 2

    def path(self, a_m: Floats | tuple[float, float], b_m: Floats | tuple[float, float]) -> Floats:
        """The shortest path (k, 2) in metres from point a (2,) to point b (2,), both included; k is at least 2.

        Equal points give both of them. Raises PlanError when a point lies outside the space, or the two in different
        parts.
        """
        ends = _points(np.array([a_m, b_m], dtype=np.float64))
        line = self._polyline(ends)
        return line if len(line) > 1 else ends

    def paths_along(self, points_m: Floats) -> Floats:
        """The polyline (k, 2) of shortest paths through the points (n, 2) in their order, all of them included.

        A point that repeats the one before is left out. Raises PlanError when a point lies outside the space, or two
        that follow each other in different parts.
        """
        points = _points(points_m)
        if not len(points):
            return points
        return self._polyline(points)

    def _alone(self, points_m: Floats) -> Ends:
        """Points without the corners that they see."""
        points = _points(points_m)
        return _without_corners(Ends(points, self.part_of(points), None, None))

    def _ends(self, points_m: Floats) -> Ends:
        """The points with the corners that each can be led to along a tangent; known ones are remembered."""
        points = _points(points_m)
        part = self.part_of(points)
        if len(self.corners_m) <= FEW_CORNERS:
            linked = corner_kernels.tangents(points, part, self._corners, self._corner_part, self.grid)
            start = np.concatenate([[0], np.cumsum(linked.sum(axis=1))]).astype(np.int64)
            return Ends(points, part, start, np.nonzero(linked)[1].astype(np.int64))
        if len(self._seen_corners) > MOST_REMEMBERED:
            self._seen_corners = {}  # another thread may still be reading the old one
        known = self._seen_corners
        keys = list(map(tuple, points.tolist()))
        new = np.array([k for k, key in enumerate(keys) if key not in known], dtype=np.int64)

        def look(some: Ints) -> None:
            linked = corner_kernels.tangents(points[some], part[some], self._corners, self._corner_part, self.grid)
            known.update((keys[k], np.flatnonzero(row)) for k, row in zip(some, linked, strict=True))

        side_by_side(look, np.array_split(new, 1 + len(new) // SOURCES_TOGETHER))
        items = [known[key] for key in keys]
        start = np.concatenate([[0], np.cumsum([len(corners) for corners in items])]).astype(np.int64)
        return Ends(points, part, start, np.concatenate([np.zeros(0, dtype=np.int64), *items]))

    def _lengths(self, a: Ends, b: Ends, *, symmetric: bool) -> Floats:
        if not len(a.items) or not len(b.items):  # no path bends, and the graph need not be made for it
            a, b = _without_corners(a), _without_corners(b)
        if len(a.items) and not self._dense:
            return self._searched_lengths(a, b, symmetric=symmetric)
        lengths = self.corner_lengths_m if len(a.items) else np.zeros((0, 0))
        return np.asarray(corner_kernels.path_lengths(a, b, self._corners, lengths, self.grid, symmetric))

    def _searched_lengths(self, a: Ends, b: Ends, *, symmetric: bool, most_m: float = np.inf) -> Floats:
        """The same along the links, some points a at a time; ways longer than ``most_m`` need not be found."""
        links = self._links.indptr, self._links.indices, self._links.data

        def rows(first: int) -> Floats:
            last = min(first + SOURCES_TOGETHER, len(a.points))
            found: Floats = corner_kernels.searched_lengths(
                (first, last), a, b, self._corners, links, self.grid, symmetric, most_m
            )
            return found

        path_m = np.vstack(side_by_side(rows, range(0, max(1, len(a.points)), SOURCES_TOGETHER)))
        if symmetric:
            path_m = np.triu(path_m)
            path_m += np.triu(path_m, 1).T
        return path_m

    def _polyline(self, points: Floats) -> Floats:
        """The shortest way through the points in turn; PlanError for points outside or in two parts."""
        part = self.part_of(points)
        for index in np.flatnonzero(part < 0):
            raise PlanError(f"point {points[index].tolist()} lies outside the space where robots can be")
        for index in np.flatnonzero(part[1:] != part[:-1]):
            raise PlanError(
                f"no path leads from {points[index].tolist()} to {points[index + 1].tolist()}: they are in two parts"
            )
        straight = kernels.free_segments(points[:-1], points[1:], self.grid)
        bent = np.flatnonzero(~straight)
        ends = self._ends(np.stack([points[bent], points[bent + 1]], axis=1).reshape(-1, 2)) if len(bent) else None
        pieces = [points[:1]]
        for k in range(len(points) - 1):
            if ends is not None and not straight[k]:
                pieces.append(self.corners_m[self._corners_between(ends, 2 * int(np.searchsorted(bent, k)))])
            pieces.append(points[k + 1 : k + 2])
        line = np.vstack(pieces)
        return line[np.r_[True, (line[1:] != line[:-1]).any(axis=1)]]

    def _corners_between(self, ends: Ends, k: int) -> list[int]:
        """Corners on the shortest path from point k to the next one, which it does not see."""
        (ax, ay), (bx, by) = ends.points[k], ends.points[k + 1]
        from_a, from_b = (
            ends.items[ends.start[k] : ends.start[k + 1]],
            ends.items[ends.start[k + 1] : ends.start[k + 2]],
        )
        if not len(from_a) or not len(from_b):
            raise PlanError(f"no path leads from {[ax, ay]} to {[bx, by]}: one of them sees no corner of the space")
        if not self._dense:
            links = self._links
            chain = corner_kernels.corner_chain(
                ends.points[k], from_a, ends.points[k + 1], from_b, self._corners, links.indptr, links.indices
            )
            if not len(chain):
                raise PlanError(f"no path leads from {[ax, ay]} to {[bx, by]}")
            return [int(k) for k in chain]
        first = np.hypot(self.corners_m[from_a, 0] - ax, self.corners_m[from_a, 1] - ay)
        last = np.hypot(self.corners_m[from_b, 0] - bx, self.corners_m[from_b, 1] - by)
        total = first[:, None] + self.corner_lengths_m[np.ix_(from_a, from_b)] + last
        best = int(np.argmin(total))
        if not np.isfinite(total.flat[best]):
            raise PlanError(f"no path leads from {[ax, ay]} to {[bx, by]}")
        start, corner = int(from_a[best // len(from_b)]), int(from_b[best % len(from_b)])
        chain = [corner]
        while corner != start:
            corner = int(self.corner_before[start, corner])
            chain.append(corner)
        return chain[::-1]


def _some_rows(count: int) -> list[Ints]:
    """The numbers of so many rows, some at a time: scipy lets no other thread run while it searches."""
    return [np.arange(first, min(first + SOURCES_TOGETHER, count)) for first in range(0, count, SOURCES_TOGETHER)]


def _without_corners(ends: Ends) -> Ends:
    return ends._replace(start=np.zeros(len(ends.points) + 1, dtype=np.int64), items=np.zeros(0, dtype=np.int64))


def _points(points_m: Floats) -> Floats:
    points = np.array(points_m, dtype=np.float64, order="C")
    points = points.reshape(-1, 2) if points.size == 0 else points
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points_m: shape {points.shape} is not allowed; must be (n, 2)")
    if not np.isfinite(points).all():
        raise ValueError(f"points_m: row {int(np.argmin(np.isfinite(points).all(axis=1)))} is not finite")
    return points

"""The map that robots share: places all over the ground where bodies have room, and the ways between them."""

from __future__ import annotations

import math

import numpy as np
import shapely
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from rota.cells.importance_cells import ImportanceCells
from rota.model.arrays import Floats, Ints
from rota.planners.swarm.free_ground_kernels import load_with_capacity
from rota.planners.swarm.importance_field import with_worth
from rota.planners.swarm.state import Kinds, PlaceGraph

PLACE_SPACING = 0.5  # of the smallest sensor's radius between places
MOST_PLACES = 2**18  # no more than about that, so that a huge area costs no memory
LONGEST_LINK = 1.95  # of that distance: ways to places so near, which the next but one of a lattice are
LINK_BODY_SHARE = 0.95  # of the body, for ways along walls that the places themselves touch


def empty_place_graph() -> PlaceGraph:
    """A map without places."""
    return _link(np.empty((0, 2)), np.empty((0, 2), np.int64), 1.0, np.zeros(2), (1, 1))


def place_graph_of(walls: Floats, kinds: Kinds, importance: ImportanceCells | None = None) -> PlaceGraph:
    """Places and ways in the ground within walls (m, 4), closed rings, in which the largest body has room.

    importance: of the ground; None: all is worth as much.

    Each square of a lattice has a place, or one for each part into which walls divide it, and so has each corner that
    ways may turn about. Any two places that are near each other are joined where a body can go straight between them.
    """
    sensors = kinds.sensor_m[kinds.sensor_m > 0]
    if not len(sensors):
        return empty_place_graph()
    body_m, sensor_m = float(kinds.body_m.max()), float(sensors.min())
    lines = shapely.linestrings(walls.reshape(-1, 2, 2))
    ground = shapely.build_area(shapely.node(shapely.multilinestrings(lines)))
    room = ground.buffer(-body_m, join_style="mitre")
    if room.is_empty:
        return empty_place_graph()
    low, high = np.array(ground.bounds[:2]), np.array(ground.bounds[2:])
    apart_m = max(
        PLACE_SPACING * sensor_m, math.sqrt(ground.area / MOST_PLACES), float((high - low).max()) / MOST_PLACES
    )
    columns, rows = (int(extent // apart_m) + 1 for extent in high - low)
    pieces, turning = _pieces(room, low, apart_m, 0, 0, _power(max(columns, rows))), _turning_points(room)
    places, area_m2 = np.vstack([pieces[:, :2], turning]), np.concatenate([pieces[:, 2], np.zeros(len(turning))])
    i, j = np.clip(((places - low) / apart_m).astype(np.int64), 0, (columns - 1, rows - 1)).T
    order = np.argsort(j * columns + i, kind="stable")
    places, area_m2 = places[order], area_m2[order]
    pairs = cKDTree(places).query_pairs(LONGEST_LINK * apart_m, output_type="ndarray")
    free = ground.buffer(-LINK_BODY_SHARE * body_m, join_style="mitre")
    shapely.prepare(free)
    pairs = pairs[shapely.covers(free, shapely.linestrings(places[pairs]))]
    graph = _link(places, pairs, apart_m, low, (columns, rows))
    load_with_capacity(area_m2, sensor_m, graph)
    graph = graph._replace(capacity=graph.load.copy())
    return graph if importance is None else with_worth(graph, area_m2 > 0, sensor_m, importance)


def _power(cells: int) -> int:
    """The least power of two that is not below a number of cells."""
    return 1 << (cells - 1).bit_length()


def _pieces(room: BaseGeometry, low: Floats, side_m: float, i: int, j: int, cells: int) -> Floats:
    """One place in each part that squares of a lattice cut a room into: (k, 3) its x and y, and the part's area.

    The squares are those from (i, j) on, ``cells`` a side. low: (2,) where the lattice begins.
    """
    x, y = low + side_m * np.array([i, j])
    width = side_m * cells
    part = shapely.intersection(room, shapely.box(x, y, x + width, y + width))
    if part.is_empty or part.area == 0:
        return np.empty((0, 3))
    if part.area >= width * width * (1 - 1e-12):
        steps = side_m * (np.arange(cells) + 0.5)
        places = np.stack(np.meshgrid(x + steps, y + steps), axis=-1).reshape(-1, 2)
        return np.column_stack([places, np.full(len(places), side_m * side_m)])
    if cells > 1:
        half = cells // 2
        return np.vstack([_pieces(part, low, side_m, i + a, j + b, half) for b in (0, half) for a in (0, half)])
    pieces = [piece for piece in shapely.get_parts(part) if piece.area > 0]
    middles = [piece.centroid if piece.contains(piece.centroid) else piece.representative_point() for piece in pieces]
    return np.column_stack([shapely.get_coordinates(middles), shapely.area(pieces)])


def _turning_points(room: BaseGeometry) -> Floats:
    """Corners (k, 2) of a room that stand out into it."""
    corners = [np.empty((0, 2))]
    for part in shapely.get_parts(room):
        if not isinstance(part, Polygon):
            continue
        for ring in shapely.get_rings(shapely.orient_polygons(part)):  # so that the room is on the left
            points = shapely.get_coordinates(ring)[:-1]
            before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
            corners.append(points[before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0])
    return np.vstack(corners)


def _link(places: Floats, pairs: Ints, cell_m: float, low: Floats, shape: tuple[int, int]) -> PlaceGraph:
    """The graph of places (n, 2) and links, pairs (l, 2) of places; the lattice begins at ``low`` (2,)."""
    n, (columns, rows) = len(places), shape
    both = np.vstack([pairs, pairs[:, ::-1]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    length_m = np.hypot(*(places[both[:, 0]] - places[both[:, 1]]).T)
    links = np.searchsorted(both[:, 0], np.arange(n + 1))
    i, j = np.clip(((places - low) / cell_m).astype(np.int64), 0, (columns - 1, rows - 1)).T
    far_m, news_steps = 1.0, 0
    if n:
        # from any place through one and on to the farthest of its part is as far as ways within the part can be
        graph = csr_matrix((length_m, both[:, 1], links), shape=(n, n))
        far_m = 2.0 * _farthest(graph, unweighted=False) + 1.0
        news_steps = 2 * int(_farthest(graph, unweighted=True)) + 1
    return PlaceGraph(
        x=np.ascontiguousarray(places[:, 0]),
        y=np.ascontiguousarray(places[:, 1]),
        link_start=links.astype(np.int64),
        link_to=np.ascontiguousarray(both[:, 1]),
        link_m=length_m,
        x0=float(low[0]),
        y0=float(low[1]),
        cell_m=cell_m,
        columns=columns,
        rows=rows,
        cell_start=np.searchsorted(j * columns + i, np.arange(columns * rows + 1)).astype(np.int64),
        load=np.zeros(n),
        capacity=np.ones(n),
        away_m=np.full((2, n), far_m),
        far_m=far_m,
        news_steps=news_steps,
        way_m=far_m,
        worth=np.empty(0),
        reach_m=0.0,
        most=0.0,
        dear_m=0.0,
    )


def _farthest(graph: csr_matrix, *, unweighted: bool) -> float:
    """How far it is from one place of a part of the graph to another, at most, each part seen from one of its places.

    The part of the place in the middle of the list is seen from there.
    """
    middle = graph.shape[0] // 2
    _, part = connected_components(graph, directed=False)
    first = np.unique(part, return_index=True)[1]
    first[part[middle]] = middle
    reached = (dijkstra(graph, indices=[place], unweighted=unweighted) for place in first)
    return max(float(lengths[np.isfinite(lengths)].max()) for lengths in reached)

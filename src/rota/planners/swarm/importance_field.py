"""Importance as the compiled loops of a swarm read it: all over the ground, and about the places of the map."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from shapely import MultiPolygon

from rota.cells.importance_cells import ImportanceCells, importance_cells
from rota.model.arrays import Flags, Floats
from rota.model.mission import Mission
from rota.planners.swarm.offer_kernels import LEVELS, most_offered
from rota.planners.swarm.state import ImportanceField, PlaceGraph

CELLS_PER_SENSOR = 16.0  # of the smallest sensor's radius
DEAR = 4.0  # of twice the longest way on the map: so much farther an offer of nothing counts as


def importance_for(mission: Mission, ground: MultiPolygon, sensors_m: Floats) -> ImportanceCells | None:
    """A mission's importance by cells that are small beside its sensors, (n,) radii; None: all ground is worth as much.

    It is a share of the greatest, so that only ratios count.
    """
    seeing = sensors_m[sensors_m > 0]
    cells = importance_cells(mission, ground, float(seeing.min()) / CELLS_PER_SENSOR) if len(seeing) else None
    return None if cells is None else cells.scale(1.0 / cells.values.max())


def field_of(cells: ImportanceCells | None) -> ImportanceField:
    """The field that compiled loops read; an empty one where all ground is worth as much."""
    if cells is None:
        none = np.zeros((0, 0))
        return ImportanceField(none, none, none, 0.0, 0.0, 1.0)
    side_m, values = cells.side_m, np.ascontiguousarray(cells.values)
    middles = side_m * (np.arange(values.shape[1]) + 0.5)
    sums, moments = (np.pad(np.cumsum(side_m * each, axis=1), ((0, 0), (1, 0))) for each in (values, values * middles))
    left, bottom = (low - side_m / 2 for low in cells.low_m)
    return ImportanceField(values, sums, moments, left, bottom, side_m)


def with_worth(graph: PlaceGraph, with_ground: Flags, sensor_m: float, cells: ImportanceCells) -> PlaceGraph:
    """The graph with the importance of the ground about each place; each cell of ground belongs to the nearest place.

    with_ground: (k,) which places stand for ground. Ground farther than a place's cell from any of them is left out.
    """
    rows, columns = np.nonzero(cells.ground_m2 > 0)
    middles = np.stack([cells.low_m[0] + cells.side_m * columns, cells.low_m[1] + cells.side_m * rows], axis=1)
    places = np.flatnonzero(with_ground)
    tree = cKDTree(np.stack([graph.x, graph.y], axis=1)[places])
    away_m, nearest = tree.query(middles, distance_upper_bound=graph.cell_m)
    near = np.isfinite(away_m)
    worth = np.zeros(len(graph.x))
    told = (cells.values * cells.ground_m2)[rows[near], columns[near]]
    np.add.at(worth, places[nearest[near]], told)
    far_m = LEVELS * graph.way_m
    graph = graph._replace(
        worth=worth,
        load=np.ones(len(worth)),
        reach_m=sensor_m,
        dear_m=DEAR * graph.way_m,
        far_m=far_m,
        away_m=np.full_like(graph.away_m, far_m),
    )
    return graph._replace(most=most_offered(graph))

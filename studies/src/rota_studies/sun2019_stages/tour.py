"""The frame: a closed path past all deployed sensors (Sun et al. 2019, Section 4.3).

Distances between sensors are those of the proximity graph (Eq. 14), in which every change of sub-region counts as alpha
more metres; the travelling salesman's tour over them is found by an algorithm of ``algorithms``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.geometry.line_of_sight import segments_free
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019_stages.algorithms import FrameTour
from rota_studies.sun2019_stages.frame import Frame
from rota_studies.sun2019_stages.graph import (
    ProximityGraph,
    changes_zone,
    graph_distances,
    proximity_graph,
    shortest_sequence,
)
from rota_studies.sun2019_stages.stage_settings import AStarWeights

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def find_frame(
    positions_m: Floats,
    zone: Ints,
    paths: ShortestPaths,
    *,
    virtual_radius_m: float,
    algorithm: FrameTour | None = None,
    seed: int,
) -> Frame:
    """The frame past the sensors at positions_m (n, 2) metres, deployed in sub-regions zone (n,), n >= 1.

    zone: numbers, the sub-region with the smallest period first. paths: of the space in which robots travel.
    virtual_radius_m: r_v. The frame begins where it leaves another sub-region for the first one (if it does), in the
    direction in which it then goes on to the sensor with the smaller number, so that the same tour is told in one way.

    Raises ValueError for no sensors, PlanError for a sensor outside the space, NoPlanFound when they lie in two parts
    of it. Source: Section 4.3.
    """
    algorithm = algorithm or FrameTour()
    if len(positions_m) == 0:
        raise ValueError("positions_m: no sensors; a frame needs at least one")
    if not (math.isfinite(virtual_radius_m) and virtual_radius_m > 0):
        raise ValueError(f"virtual_radius_m: {virtual_radius_m!r} is not allowed; must be greater than 0")
    graph = proximity_graph(
        positions_m,
        zone,
        paths,
        neighbour_range_m=algorithm.neighbour_range * virtual_radius_m,
        alpha=algorithm.alpha_m,
    )
    straight_m = straight_distances(graph.positions_m)
    distance = graph_distances(graph) if algorithm.distance == "graph" else straight_m
    order, history = algorithm.order(distance, straight_m, seed)
    order = canonical_order(order, graph.zone)
    if algorithm.distance == "euclidean":
        legs = [np.array([a, b]) for a, b in zip(order, np.roll(order, -1), strict=True)]
        pieces_m = [graph.positions_m[leg] for leg in legs]
        changes = sum(int(changes_zone(graph.zone[a], graph.zone[b])) for a, b in legs)
    else:
        pieces_m, changes = travel(graph, order, algorithm.a_star)
    blocked = [not bool(segments_free(piece[:-1], piece[1:], paths.grid).all()) for piece in pieces_m]
    return Frame(
        order=order,
        path_m=np.vstack([pieces_m[0][:1], *(piece[1:] for piece in pieces_m)]),
        leg_start=np.cumsum([0, *(len(piece) - 1 for piece in pieces_m)]).astype(np.int64),
        legs_m=np.array([float(np.hypot(*np.diff(piece, axis=0).T).sum()) for piece in pieces_m]),
        tour_length=float(distance[order, np.roll(order, -1)].sum()),
        zone_crossings=changes,
        blocked_legs=sum(blocked),
        history=history,
    )


def travel(graph: ProximityGraph, order: Ints, weights: AStarWeights) -> tuple[list[Floats], int]:
    """The polyline (k, 2) of each leg of the closed tour, by A* on the graph, and changes of sub-region in all.

    Where the graph is torn the leg is the exact shortest path round obstacles.
    """
    pieces_m, changes = [], 0
    for a, b in zip(order.tolist(), np.roll(order, -1).tolist(), strict=True):
        sequence = shortest_sequence(graph, a, b, weights)
        if sequence is None:
            pieces_m.append(graph.paths.path(graph.positions_m[a], graph.positions_m[b]))
            sequence = np.array([a, b])
        else:
            # a frame of one sensor has one leg, which stays there
            pieces_m.append(graph.positions_m[sequence if len(sequence) > 1 else [a, b]])
        changes += int(changes_zone(graph.zone[sequence[:-1]], graph.zone[sequence[1:]]).sum())
    return pieces_m, changes


def straight_distances(positions_m: Floats) -> Floats:
    """Euclidean distances (n, n) between positions (n, 2)."""
    return np.asarray(np.hypot(*(positions_m[:, None] - positions_m[None]).transpose(2, 0, 1)))


def canonical_order(order: Ints, zone: Ints) -> Ints:
    """The same closed tour (n,), begun where it goes over into the first sub-region, or else at sensor 0.

    The paper's path begins at sensor s_1 and its first segment right behind it, so that a cut lies there. Of several
    such places, and of the two directions, the one with the smallest numbers of sensors behind the cut is taken.
    """
    forms = []
    for way in (order, order[::-1]):
        inside = zone[way] == zone.min()
        begins = np.flatnonzero(inside & ~np.roll(inside, 1))
        if not len(begins):
            begins = np.flatnonzero(np.roll(way, 1) == 0)
        forms += [np.roll(way, 1 - int(at)) for at in begins]
    return np.ascontiguousarray(min(forms, key=lambda way: np.roll(way, -1).tolist()))

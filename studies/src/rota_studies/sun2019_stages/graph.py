"""The proximity graph over deployed sensors and distances on it (Sun et al. 2019, Section 4.3, Eqs. 12-17).

Readings. Straight lines that a robot cannot travel are no edges: that is the obstacle term P_obs of Eq. 16, infinite
there and 0 elsewhere. In Eq. 16 the cost before the current point is g(M-1), which the paper prints as f(M-1). With the
weights tau at 1 Eqs. 15-17 are ordinary A*, and the heuristic, the straight distance, never says too much. Reference 44
of the paper promises a connected graph only where nothing is in the way; what obstacles tear apart is joined by
exact shortest paths round them (``rota.geometry.shortest_path``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from rota.errors import NoPlanFound, PlanError
from rota.geometry.line_of_sight import segments_free
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019_stages.graph_kernels import Frontier, Steps, search, search_from_each
from rota_studies.sun2019_stages.stage_settings import AStarWeights

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class ProximityGraph:
    """Waypoints, and the straight lines between those no more than ``neighbour_range_m`` apart that can be travelled.

    positions_m: (n, 2) metres. zone: (n,) the sub-region each sensor was deployed in. alpha: metres that a change of
    sub-region counts as, in Eq. 12. Edges from waypoint k lead to items[start[k] : start[k + 1]] and are edge_m long.
    part: (n,) which connected piece of the graph each waypoint lies in. paths: where robots can travel.
    """

    positions_m: Floats
    zone: Ints
    alpha: float
    neighbour_range_m: float
    start: Ints
    items: Ints
    edge_m: Floats
    part: Ints
    paths: ShortestPaths

    @cached_property
    def steps(self) -> Steps:
        """The graph as the kernels hold it, alpha in the costs."""
        x, y = np.ascontiguousarray(self.positions_m.T)
        ends = np.repeat(np.arange(len(x)), np.diff(self.start))
        cost = self.edge_m + self.alpha * changes_zone(self.zone[ends], self.zone[self.items])
        return Steps(x, y, self.start, self.items, np.ascontiguousarray(cost))

    @cached_property
    def frontier(self) -> Frontier:
        """Room for searches; one at a time."""
        n, room = len(self.positions_m), len(self.items) + 1
        return Frontier(
            np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.bool_), np.zeros(room), np.zeros(room, np.int64)
        )


def proximity_graph(
    positions_m: Floats, zone: Ints, paths: ShortestPaths, *, neighbour_range_m: float, alpha: float
) -> ProximityGraph:
    """The proximity graph (Section 4.3) over sensors at positions_m (n, 2), deployed in sub-regions zone (n,).

    neighbour_range_m: r_n of the paper, r_n >= 2 r_v. alpha: metres, 0 or more. paths: of the space robots travel in.
    Raises PlanError when a sensor lies outside that space, NoPlanFound when they lie in two parts of it: then no
    closed path leads past all of them.
    """
    positions_m, zone = checked_waypoints(positions_m, zone)
    for name, value in (("neighbour_range_m", neighbour_range_m), ("alpha", alpha)):
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{name}: {value!r} is not allowed; must be a finite number, 0 or more")
    part = paths.part_of(positions_m)
    for k in np.flatnonzero(part < 0):
        raise PlanError(f"waypoint {k} at {positions_m[k].tolist()} lies outside the space where robots can be")
    for k in np.flatnonzero(part != part[:1]):
        raise NoPlanFound(
            f"no closed path leads past waypoint 0 at {positions_m[0].tolist()} and waypoint {k} at "
            f"{positions_m[k].tolist()}: they are in two parts of the space where robots can be"
        )
    n = len(positions_m)
    pairs = cKDTree(positions_m).query_pairs(neighbour_range_m, output_type="ndarray") if n else np.zeros((0, 2))
    pairs = pairs.astype(np.int64)
    pairs = pairs[segments_free(positions_m[pairs[:, 0]], positions_m[pairs[:, 1]], paths.grid)]
    ends = np.vstack([pairs, pairs[:, ::-1]])
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    step_m = positions_m[ends[:, 0]] - positions_m[ends[:, 1]]
    links = csr_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    return ProximityGraph(
        positions_m=positions_m,
        zone=zone,
        alpha=float(alpha),
        neighbour_range_m=float(neighbour_range_m),
        start=np.searchsorted(ends[:, 0], np.arange(n + 1)).astype(np.int64),
        items=np.ascontiguousarray(ends[:, 1]),
        edge_m=np.hypot(step_m[:, 0], step_m[:, 1]),
        part=connected_components(links, directed=False)[1].astype(np.int64),
        paths=paths,
    )


def changes_zone(zone: Ints, next_zone: Ints) -> NDArray[np.bool_]:
    """Eq. 13: whether two sensors (arrays of any shape) are deployed in different sub-regions."""
    return np.asarray(zone != next_zone)


def graph_distances(graph: ProximityGraph) -> Floats:
    """Eq. 14 for all pairs: (n, n) lengths of the shortest paths on the graph, alpha included; symmetric and finite.

    Where the graph is torn, the exact shortest path between the two sensors counts, plus alpha if their sub-regions
    differ: no path through other sensors could be shorter. A search from each sensor without a goal (the heuristic 0)
    gives what A* gives for each pair, in far less time.
    """
    distances = np.empty((len(graph.zone), len(graph.zone)))
    search_from_each(graph.steps, graph.frontier, distances)
    distances = np.minimum(distances, distances.T)  # the two directions add up the same steps in another order
    torn = graph.part[:, None] != graph.part[None]
    if torn.any():
        apart = graph.paths.all_pairs(graph.positions_m)
        apart += graph.alpha * changes_zone(graph.zone[:, None], graph.zone[None])
        distances[torn] = apart[torn]
    return distances


def shortest_sequence(graph: ProximityGraph, first: int, last: int, weights: AStarWeights | None = None) -> Ints | None:
    """The sensors (k,) along the shortest path from one to another, both included, by A* (Eqs. 15-17).

    None where the graph does not lead from one to the other. ``weights`` other than 1 may give another path than the
    shortest.
    """
    w = weights or AStarWeights()
    search(first, last, w.before, w.step, w.rest, graph.steps, graph.frontier)
    before = graph.frontier.before
    chain = [last]
    while chain[-1] != first:
        chain.append(int(before[chain[-1]]))
        if chain[-1] < 0:
            return None
    return np.array(chain[::-1], dtype=np.int64)


def checked_waypoints(positions_m: Floats, zone: Ints) -> tuple[Floats, Ints]:
    """Positions (n, 2) and sub-regions (n,) as the kernels want them; ValueError names what is wrong with them."""
    positions_m = np.ascontiguousarray(np.asarray(positions_m, dtype=np.float64).reshape(-1, 2))
    zone = np.ascontiguousarray(zone, dtype=np.int64)
    if zone.shape != (len(positions_m),):
        raise ValueError(f"zone: shape {zone.shape} is not allowed; {len(positions_m)} waypoints need as many")
    return positions_m, zone

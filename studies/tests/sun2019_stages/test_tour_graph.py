"""The proximity graph and Eqs. 12-17 against lengths worked out by hand, and A* against scipy's Dijkstra."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from shapely import MultiPolygon, box

from rota.errors import MissionError, NoPlanFound, PlanError
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019_stages.graph import (
    ProximityGraph,
    changes_zone,
    graph_distances,
    proximity_graph,
    shortest_sequence,
)
from rota_studies.sun2019_stages.graph_kernels import search
from rota_studies.sun2019_stages.stage_settings import AStarWeights

Floats = NDArray[np.float64]
OPEN = ShortestPaths(MultiPolygon([box(0, 0, 100, 100)]))


def path_length(positions_m: Floats, zone: NDArray[np.int64], sequence: NDArray[np.int64], alpha: float) -> float:
    """Eq. 12: the length of the path through sensors ``sequence`` (k,), and alpha for each change of sub-region."""
    step_m = np.diff(positions_m[sequence], axis=0)
    changes = changes_zone(zone[sequence[:-1]], zone[sequence[1:]])
    return float(np.hypot(step_m[:, 0], step_m[:, 1]).sum() + alpha * changes.sum())


def graph_over(
    places: list[tuple[float, float]] | Floats,
    zone: list[int] | None = None,
    *,
    paths: ShortestPaths = OPEN,
    reach_m: float = 20,
    alpha: float = 0,
) -> ProximityGraph:
    zones = np.zeros(len(places), np.int64) if zone is None else np.array(zone)
    return proximity_graph(np.array(places), zones, paths, neighbour_range_m=reach_m, alpha=alpha)


def edges(graph: ProximityGraph) -> set[tuple[int, int]]:
    ends = np.repeat(np.arange(len(graph.zone)), np.diff(graph.start))
    return {(int(a), int(b)) for a, b in zip(ends, graph.items, strict=True) if a < b}


def test_neighbours_are_those_within_range() -> None:
    graph = graph_over([(0, 0), (20, 0), (40.001, 0), (20, 20)])
    assert edges(graph) == {(0, 1), (1, 3)}
    assert graph.part.tolist() == [0, 0, 1, 0]
    assert sorted(graph.edge_m) == [20, 20, 20, 20]


def test_no_edge_leads_through_an_obstacle_but_one_may_touch_it() -> None:
    block = ShortestPaths(MultiPolygon([box(0, 0, 100, 100).difference(box(8, 5, 12, 15))]))
    graph = graph_over([(2, 10), (18, 10), (2, 5), (18, 5), (2, 16)], paths=block)
    # 0-1 is cut; along y = 5 one runs along the block's border; 4-1 passes above its corner? no: it cuts it
    assert edges(graph) == {(0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (2, 3), (2, 4), (3, 4)} - {(0, 3), (1, 2), (3, 4)}


def test_equations_12_and_13_by_hand() -> None:
    places, zone = np.array([[0, 0], [3, 4], [3, 10], [0, 10]]), np.array([1, 1, 2, 1])
    assert changes_zone(zone[:-1], zone[1:]).tolist() == [False, True, True]
    assert path_length(places, zone, np.array([0, 1]), 100) == 5
    assert path_length(places, zone, np.array([0, 1, 2]), 100) == 5 + 6 + 100
    assert path_length(places, zone, np.array([0, 1, 2, 3]), 100) == 5 + 6 + 3 + 200
    assert path_length(places, zone, np.array([2]), 100) == 0


def test_equation_14_goes_round_another_sub_region_when_alpha_makes_that_shorter() -> None:
    places, zone = [(10.0, 10.0), (25, 10), (40, 10), (25, 22)], [0, 1, 0, 0]
    detour = 2 * math.hypot(15, 12)  # 38.4 m instead of 30
    for alpha, through, expected in ((1, 1, 32), (4.2, 1, 38.4), (4.3, 3, detour), (10_000, 3, detour)):
        graph = graph_over(places, zone, alpha=alpha)
        found = graph_distances(graph)
        assert found[0, 2] == pytest.approx(expected)
        assert found[2, 0] == found[0, 2]
        chain = shortest_sequence(graph, 0, 2)
        assert chain is not None
        assert chain.tolist() == [0, through, 2]
        assert path_length(graph.positions_m, graph.zone, chain, alpha) == pytest.approx(expected)
    assert found[0, 1] == 15 + 10_000
    assert np.diag(found).tolist() == [0] * 4


def test_equations_15_to_17_by_hand() -> None:
    graph = graph_over([(0, 0), (10, 0), (20, 10), (40, 0)], reach_m=15)
    slant = math.hypot(10, 10)
    # ordinary: g = 10, then 10 + 14.1; the fourth sensor is out of reach
    search(0, 2, 1.0, 1.0, 1.0, graph.steps, graph.frontier)
    assert graph.frontier.cost[:3] == pytest.approx([0, 10, 10 + slant])
    assert graph.frontier.cost[3] == math.inf
    # g(M) = tau_1 g(M-1) + tau_2 D_cur: 2 * 10 = 20, then 20 / 2 + 2 * 14.1
    search(0, 2, 0.5, 2.0, 1.0, graph.steps, graph.frontier)
    assert graph.frontier.cost[:3] == pytest.approx([0, 20, 10 + 2 * slant])


def test_the_estimate_spares_work_and_changes_no_length() -> None:
    rng = np.random.default_rng(3)
    places = rng.uniform(0, 100, (300, 2))
    graph = graph_over(places, rng.integers(0, 3, 300).tolist(), reach_m=12, alpha=7)
    ends = np.repeat(np.arange(300), np.diff(graph.start))
    cost = graph.edge_m + 7 * (graph.zone[ends] != graph.zone[graph.items])
    expected = dijkstra(csr_array((cost, (ends, graph.items)), shape=(300, 300)))
    assert np.isfinite(expected).all()
    assert graph_distances(graph) == pytest.approx(expected)
    with_estimate = without = 0
    for first, last in rng.integers(0, 300, (200, 2)):
        chain = shortest_sequence(graph, int(first), int(last))
        assert chain is not None
        assert path_length(graph.positions_m, graph.zone, chain, 7) == pytest.approx(expected[first, last])
        with_estimate += search(first, last, 1.0, 1.0, 1.0, graph.steps, graph.frontier)
        without += search(first, last, 1.0, 1.0, 0.0, graph.steps, graph.frontier)
    assert with_estimate < 0.8 * without


def test_a_torn_graph_is_joined_by_exact_paths_round_obstacles() -> None:
    # a wall from the bottom up to y = 30: nobody sees across it within range
    walled = ShortestPaths(MultiPolygon([box(0, 0, 100, 100).difference(box(48, 0, 52, 30))]))
    graph = graph_over([(45, 0), (55, 0), (45, 10)], [0, 1, 0], paths=walled, alpha=500)
    assert edges(graph) == {(0, 2)}
    found = graph_distances(graph)
    over_it = 2 * math.hypot(3, 30) + 4
    assert found[0, 1] == pytest.approx(over_it + 500)
    assert found[2, 1] == pytest.approx(math.hypot(3, 20) + 4 + math.hypot(3, 30) + 500)
    assert found[0, 2] == 10
    assert shortest_sequence(graph, 0, 1) is None


def test_a_heavy_estimate_of_the_way_that_remains_prefers_what_looks_near() -> None:
    # f = g + tau_4 D_res: the upper way looks nearer, but changes the sub-region twice, at 9 m each
    places = [(0.0, 20.0), (14, 22), (28, 22), (10, 10), (22, 6), (33, 11), (40, 20)]
    graph = graph_over(places, [0, 0, 1, 0, 0, 0, 0], reach_m=16, alpha=9)
    upper = math.hypot(14, 2) + 14 + math.hypot(12, 2) + 18
    lower = math.hypot(10, 10) + math.hypot(12, 4) + math.hypot(11, 5) + math.hypot(7, 9)
    for rest, through, length in ((1, [0, 3, 4, 5, 6], lower), (50, [0, 1, 2, 6], upper)):
        chain = shortest_sequence(graph, 0, 6, AStarWeights(rest=rest))
        assert chain is not None
        assert chain.tolist() == through
        assert path_length(graph.positions_m, graph.zone, chain, 9) == pytest.approx(length)
    assert graph_distances(graph)[0, 6] == pytest.approx(lower)


def test_what_cannot_be_used_is_refused() -> None:
    with pytest.raises(PlanError, match=r"waypoint 1 at \[101.0, 3.0\] lies outside"):
        graph_over([(0, 0), (101, 3)])
    apart = ShortestPaths(MultiPolygon([box(0, 0, 10, 10), box(20, 0, 25, 10)]))
    with pytest.raises(NoPlanFound, match=r"waypoint 1 at \[21.0, 3.0\]: they are in two parts"):
        graph_over([(3, 3), (21, 3)], paths=apart)
    with pytest.raises(ValueError, match=r"zone: shape \(2,\) is not allowed; 1 waypoints"):
        graph_over([(3, 3)], [0, 1])
    with pytest.raises(ValueError, match="alpha: -1"):
        graph_over([(3, 3)], alpha=-1)
    with pytest.raises(MissionError, match=r"a_star\.rest: \.nan is not allowed; a finite number is needed"):
        AStarWeights(rest=math.nan)

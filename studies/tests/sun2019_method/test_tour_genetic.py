"""Algorithm 2: the operators on Figure 1's positions, and tours whose shortest length is known."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_3
from numpy.typing import NDArray
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019 import figure_13
from rota_studies.sun2019_method.algorithms import TourSettings
from rota_studies.sun2019_method.genetic import genetic_tour
from rota_studies.sun2019_method.genetic_kernels import closed_length, reversal_gain, reverse, slide, swap
from rota_studies.sun2019_stages.deploy import deploy_sensors
from rota_studies.sun2019_stages.tour import find_frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def apart(places_m: Floats) -> Floats:
    return np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))


def evolved(d: Floats, *, generations: int, seed: int = 0, **changes: int) -> tuple[Ints, Floats]:
    chosen = {"population": 40, "regroup_every": 50, "reversal_tries": 5} | changes
    return genetic_tour(d, generations=generations, seed=seed, **chosen)


# ---------------------------------------------------------------- Figure 1: seven genes, positions counted from 1


def test_mutation_exchanges_the_genes_at_2_and_6() -> None:
    genes = np.array([1, 2, 3, 4, 5, 6, 7], dtype=np.int32)
    swap(genes, 2 - 1, 6 - 1)
    assert genes.tolist() == [1, 6, 3, 4, 5, 2, 7]


def test_reversal_sorts_the_genes_from_3_to_6_in_reverse_order() -> None:
    genes = np.array([1, 2, 3, 4, 5, 6, 7], dtype=np.int32)
    reverse(genes, 3 - 1, 6 - 1)
    assert genes.tolist() == [1, 2, 6, 5, 4, 3, 7]


def test_slide_rotates_the_genes_from_2_to_5_one_position_to_the_left() -> None:
    genes = np.array([1, 2, 3, 4, 5, 6, 7], dtype=np.int32)
    slide(genes, 2 - 1, 5 - 1)
    assert genes.tolist() == [1, 3, 4, 5, 2, 6, 7]


def test_one_position_alone_changes_nothing() -> None:
    for operator in (swap, reverse, slide):
        genes = np.array([3, 1, 2], dtype=np.int32)
        operator(genes, 1, 1)
        assert genes.tolist() == [3, 1, 2]


def test_the_gain_of_every_reversal_is_what_it_shortens() -> None:
    d = apart(np.random.default_rng(5).uniform(0, 10, (7, 2)))
    genes = np.array([4, 0, 6, 2, 1, 5, 3], dtype=np.int32)
    for z1, z2 in itertools.combinations_with_replacement(range(7), 2):
        turned = genes.copy()
        reverse(turned, z1, z2)
        assert reversal_gain(genes, z1, z2, d) == pytest.approx(closed_length(genes, d) - closed_length(turned, d))


# ---------------------------------------------------------------- the algorithm


def test_few_places_against_all_permutations() -> None:
    for seed in range(5):
        d = apart(np.random.default_rng(seed).uniform(0, 100, (8, 2)))
        orders = [(0, *rest) for rest in itertools.permutations(range(1, 8))]
        shortest = min(float(d[order, np.roll(order, -1)].sum()) for order in orders)
        order, history = evolved(d, generations=300, seed=seed)
        assert sorted(order.tolist()) == list(range(8))
        assert history[-1] == pytest.approx(shortest)
        assert d[order, np.roll(order, -1)].sum() == pytest.approx(shortest)


def test_places_on_a_ring_are_visited_round_it() -> None:
    angles = np.random.default_rng(1).permutation(30) * 2 * np.pi / 30
    d = apart(np.column_stack([np.cos(angles), np.sin(angles)]))
    _, history = evolved(d, generations=3000)
    assert history[-1] == pytest.approx(2 * 30 * np.sin(np.pi / 30))


def test_the_history_is_that_of_the_best_and_only_falls() -> None:
    d = apart(np.random.default_rng(2).uniform(0, 100, (40, 2)))
    order, history = evolved(d, generations=500)
    assert history.shape == (500,)
    assert (np.diff(history) <= 0).all()
    assert history[0] > 1.5 * history[-1]
    assert history[-1] == pytest.approx(d[order, np.roll(order, -1)].sum())


def test_the_seed_decides() -> None:
    d = apart(np.random.default_rng(2).uniform(0, 100, (40, 2)))
    one, again, other = (evolved(d, generations=200, seed=seed) for seed in (7, 7, 8))
    assert one[0].tolist() == again[0].tolist()
    assert one[1].tolist() == again[1].tolist()
    assert one[1].tolist() != other[1].tolist()


def test_families_kept_apart_for_a_while_end_with_shorter_tours() -> None:
    # drawing the groups anew in each generation leaves one family after a few
    d = apart(np.random.default_rng(4).uniform(0, 100, (60, 2)))
    runs = {
        every: np.mean([evolved(d, generations=3000, seed=s, regroup_every=every)[1][-1] for s in range(6)])
        for every in (1, 300)
    }
    assert runs[300] < 0.99 * runs[1]


def ring() -> Floats:
    """Twenty-four places on a circle of 30 m, in any order."""
    angles = np.random.default_rng(1).permutation(24) * 2 * np.pi / 24
    return 30 * np.column_stack([np.cos(angles), np.sin(angles)])


def test_a_frame_past_a_ring_of_sensors_is_as_short_as_can_be_and_the_seed_decides() -> None:
    places, paths = ring(), ShortestPaths(MultiPolygon([box(-100, -100, 100, 100)]))
    asked = TourSettings(method="genetic", generations=2000, population=80)
    one, again = (
        find_frame(places, np.zeros(24, np.int64), paths, virtual_radius_m=10, algorithm=asked, seed=0)
        for _ in range(2)
    )
    assert one.length_m == pytest.approx(2 * 30 * 24 * np.sin(np.pi / 24))
    assert one.history.shape == (2000,)
    assert one.history[-1] == pytest.approx(one.tour_length)
    assert one.path_m.tolist() == again.path_m.tolist()
    assert one.history.tolist() == again.history.tolist()


def test_on_figure_13_it_comes_within_3_per_cent_of_the_local_search() -> None:
    mission = figure_13()
    found = deploy_sensors(mission)
    paths = ShortestPaths(standing_space(mission, 0.0))
    genetic, local = (
        find_frame(found.positions_m, found.zone_of, paths, virtual_radius_m=10, algorithm=algorithm, seed=0)
        for algorithm in (TourSettings(method="genetic", generations=5000), TourSettings())
    )
    assert genetic.zone_crossings == local.zone_crossings
    assert local.length_m - 1e-6 <= genetic.length_m <= 1.03 * local.length_m


def test_its_settings_are_refused_by_name() -> None:
    for wrong in ({"method": "ants"}, {"population": 30}, {"reversal_tries": 0}):
        with pytest.raises(MissionError, match=next(iter(wrong))):
            TourSettings(**wrong)


def test_table_3() -> None:
    assert (TABLE_3.method, TABLE_3.generations, TABLE_3.population) == ("genetic", 10_000, 600)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_hardly_any_places(n: int) -> None:
    order, history = evolved(apart(np.eye(3)[:n, :2]), generations=4)
    assert order.tolist() == list(range(n))
    assert history.tolist() == [pytest.approx([0, 2 * 2**0.5, 2 + 2**0.5][n - 1])] * 4


def test_what_cannot_be_used_is_refused() -> None:
    d = apart(np.random.default_rng(2).uniform(0, 100, (5, 2)))
    with pytest.raises(ValueError, match="population: 6 is not allowed; must be a multiple of 4"):
        evolved(d, generations=5, population=6)
    with pytest.raises(ValueError, match="regroup_every: 0"):
        evolved(d, generations=5, regroup_every=0)
    d[0, 1] = np.inf
    with pytest.raises(ValueError, match="reachable"):
        evolved(d, generations=5)

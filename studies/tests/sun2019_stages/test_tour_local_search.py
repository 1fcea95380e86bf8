"""The local search against brute force, tours whose length is known, and a published instance with its optimum."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from rota_studies.sun2019_stages import local_search
from rota_studies.sun2019_stages.local_search import locally_shortest_tour, neighbours, tour_length
from rota_studies.sun2019_stages.local_search_kernels import improve, kicks

Floats = NDArray[np.float64]

# TSPLIB's berlin52 (Reinelt, ORSA Journal on Computing 3(4):376, 1991): shortest tour 7542, legs rounded to integers
BERLIN52 = """565 575 25 185 345 750 945 685 845 655 880 660 25 230 525 1000 580 1175 650 1130 1605 620 1220 580 1465
200 1530 5 845 680 725 370 145 665 415 635 510 875 560 365 300 465 520 585 480 415 835 625 975 580 1215 245 1320 315
1250 400 660 180 410 250 420 555 575 665 1150 1160 700 580 685 595 685 610 770 610 795 645 720 635 760 650 475 960
95 260 875 920 700 500 555 815 830 485 1170 65 830 610 605 625 595 360 1340 725 1740 245"""


def apart(places_m: Floats) -> Floats:
    return np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))


def test_a_published_instance_is_solved() -> None:
    d = np.rint(apart(np.array(BERLIN52.split(), dtype=np.float64).reshape(52, 2)))
    for seed in range(3):
        order, history = locally_shortest_tour(d, kicks_per_waypoint=50, seed=seed)
        assert sorted(order.tolist()) == list(range(52))
        assert tour_length(d, order) == history[-1] == 7542


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6, 7, 8, 9])
def test_few_places_against_all_permutations(n: int) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        d = apart(rng.uniform(0, 100, (n, 2))) if seed % 2 else rng.uniform(1, 10, (n, n))
        d = d + d.T
        np.fill_diagonal(d, 0)
        orders = np.array([(0, *rest) for rest in itertools.permutations(range(1, n))])
        shortest = d[orders, np.roll(orders, -1, axis=1)].sum(axis=1).min()
        order, history = locally_shortest_tour(d, kicks_per_waypoint=40, seed=seed)
        assert sorted(order.tolist()) == list(range(n))
        assert tour_length(d, order) == pytest.approx(shortest)
        assert history[-1] == pytest.approx(shortest)


@pytest.mark.parametrize("n", [8, 41, 300])
def test_places_on_a_ring_are_visited_round_it(n: int) -> None:
    angles = np.random.default_rng(n).permutation(n) * 2 * np.pi / n
    d = apart(np.column_stack([np.cos(angles), np.sin(angles)]))
    order, _ = locally_shortest_tour(d, kicks_per_waypoint=5, seed=0)
    assert tour_length(d, order) == pytest.approx(2 * n * math.sin(math.pi / n))


def test_a_lattice_with_an_even_side_needs_no_diagonal() -> None:
    places = np.random.default_rng(1).permutation(np.array(list(itertools.product(range(12), range(9)))) * 12.0)
    order, _ = locally_shortest_tour(apart(places), kicks_per_waypoint=50, seed=0)
    assert tour_length(apart(places), order) == pytest.approx(12 * 9 * 12.0)


@pytest.mark.parametrize("penalty", [0.0, 10_000.0])
def test_every_gain_told_is_a_gain_made(penalty: float) -> None:
    # equal legs and large penalties: moves of all kinds, in both directions of the tour
    rng = np.random.default_rng(6)
    places = rng.permutation(np.array(list(itertools.product(range(9), range(8)))) * 10.0)
    near = apart(places)
    zone = (places[:, 0] > 35).astype(int) + (places[:, 1] > 45)
    d = near + penalty * (zone[:, None] != zone[None])
    search = local_search._lay_out(d, neighbours(d, near), 3)
    before = tour_length(d, search.order)
    gain = improve(1e-6, search)
    assert gain > 0
    for _ in range(60):
        assert before - tour_length(d, search.order) == pytest.approx(gain, abs=1e-5)
        assert sorted(search.order.tolist()) == list(range(72))
        assert search.order[search.place].tolist() == list(range(72))
        before = tour_length(d, search.order)
        gain = kicks(20, 20, 1e-6, search)


def test_neighbours_are_the_nearest_by_either_measure() -> None:
    near = apart(np.array([[float(k), 0] for k in range(30)]))
    zone = np.arange(30) // 15
    d = near + 1000 * (zone[:, None] != zone[None])
    found = neighbours(d, near)
    assert found.shape == (30, 12)
    assert set(found[0]) == set(range(1, 13))
    # at the border: eight of its own sub-region, and the four nearest of those left
    assert set(found[14]) == {6, 7, 8, 9, 10, 11, 12, 13, 15, 16, 17, 18}
    assert found[14, 8:].tolist() == [15, 16, 17, 18]
    assert neighbours(near, None).shape == (30, 8)


def test_the_history_only_falls_and_the_seed_decides() -> None:
    d = apart(np.random.default_rng(2).uniform(0, 100, (200, 2)))
    order, history = locally_shortest_tour(d, kicks_per_waypoint=3, seed=5)
    assert history.shape == (101,)
    assert (np.diff(history) <= 1e-9).all()
    assert history[-1] < 0.99 * history[0]
    assert locally_shortest_tour(d, kicks_per_waypoint=3, seed=5)[0].tolist() == order.tolist()
    assert locally_shortest_tour(d, kicks_per_waypoint=3, seed=6)[1].tolist() != history.tolist()


def test_what_cannot_be_used_is_refused() -> None:
    d = apart(np.random.default_rng(2).uniform(0, 100, (9, 2)))
    with pytest.raises(ValueError, match="kicks_per_waypoint: -1"):
        locally_shortest_tour(d, kicks_per_waypoint=-1, seed=0)
    d[3, 4] = math.nan
    with pytest.raises(ValueError, match="reachable"):
        locally_shortest_tour(d, kicks_per_waypoint=1, seed=0)

"""Short closed tours against brute force over all permutations and against rings whose best order is known."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from rota.planners.patrol.initial.first_tours import lane_order
from rota.planners.patrol.tours.order_kernels import improve_once, nearest_neighbour_tour, reverse_places
from rota.planners.patrol.tours.visiting_order import nearest_places, order_of_pairs, short_order

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def apart(places_m: Floats) -> Floats:
    return np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))


def length(d: Floats, order: Ints) -> float:
    return float(d[order, np.roll(order, -1)].sum())


def shortest(d: Floats) -> float:
    rest = np.array(list(itertools.permutations(range(1, len(d)))), dtype=np.int64)
    orders = np.hstack([np.zeros((len(rest), 1), dtype=np.int64), rest])
    return float(d[orders, np.roll(orders, -1, axis=1)].sum(axis=1).min())


@pytest.mark.parametrize("n", [4, 5, 6, 7, 8])
def test_against_all_permutations(n: int) -> None:
    rng = np.random.default_rng(n)
    ratios = []
    for _ in range(30):
        d = apart(rng.uniform(0, 100, (n, 2)))
        order = short_order(d)
        assert sorted(order.tolist()) == list(range(n))
        ratios.append(length(d, order) / shortest(d))
    assert min(ratios) >= 1 - 1e-12
    assert max(ratios) < 1.15
    assert np.mean(ratios) < 1.01
    assert sum(ratio < 1 + 1e-9 for ratio in ratios) >= 24


@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_hardly_any_places(n: int) -> None:
    assert sorted(short_order(np.zeros((n, n))).tolist()) == list(range(n))


@pytest.mark.parametrize("n", [8, 40, 300])
def test_places_on_a_ring_are_visited_round_it(n: int) -> None:
    angles = np.random.default_rng(n).permutation(n) * 2 * np.pi / n
    d = apart(np.column_stack([np.cos(angles), np.sin(angles)]))
    # no closed tour is shorter than the convex polygon that it visits the corners of
    assert length(d, short_order(d)) == pytest.approx(2 * n * np.sin(np.pi / n))


def test_a_lattice_is_toured_without_much_detour() -> None:
    # an even lattice of unit cells has a tour of length n; local search comes within a tenth
    places = np.array(list(itertools.product(range(12), range(12))), dtype=np.float64)
    places = np.random.default_rng(1).permutation(places)
    d = apart(places)
    assert 144 - 1e-9 <= length(d, short_order(d)) < 1.1 * 144


def test_shapes_other_than_the_plane() -> None:
    # distances round obstacles are no straight ones: any symmetric ones will do
    rng = np.random.default_rng(9)
    for _ in range(20):
        d = rng.uniform(1, 10, (7, 7))
        d = (d + d.T) / 2
        np.fill_diagonal(d, 0)
        order = short_order(d)
        assert sorted(order.tolist()) == list(range(7))
        assert length(d, order) <= 1.4 * shortest(d)


@pytest.fixture
def _passes_that_end(monkeypatch: pytest.MonkeyPatch) -> None:
    passes = itertools.count()

    def improve(*places: Floats) -> bool:
        assert next(passes) < 50, "it goes on without gain"
        return bool(improve_once(*places))

    monkeypatch.setattr(f"{short_order.__module__}.improve_once", improve)


@pytest.mark.usefixtures("_passes_that_end")
def test_rounding_of_large_distances_is_no_gain() -> None:
    # ends of lanes in pairs that must stay together, 22 km of them: 1e-9 m is less than sums of such distances are off
    x = np.repeat(np.arange(367) * 60.0 + 0.1, 2)
    d = np.abs(x[:, None] - x[None])
    pairs = np.arange(0, len(x), 2)
    d[pairs, pairs + 1] = d[pairs + 1, pairs] = -1e3 * (1 + d.max())
    order = short_order(d)
    assert length(d, order) == pytest.approx(2 * x.max() - 0.2 + 367 * d.min())


@pytest.mark.usefixtures("_passes_that_end")
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("lines", [4, 10])
def test_orders_of_lines_end_however_much_their_ends_are_kept_together(lines: int, seed: int) -> None:
    """Lines in 10 km, half of the ways between them far longer than straight ones."""
    chance = np.random.default_rng(seed)
    ends_m = 1e4 * chance.random((2 * lines, 2))
    d = np.hypot(*(ends_m[:, None] - ends_m[None]).transpose(2, 0, 1)) * chance.choice([1.0, 10.0], (2 * lines,) * 2)
    order = order_of_pairs(np.maximum(d, d.T))
    assert sorted(line for line, _ in order) == list(range(lines))


def test_places_on_one_spot() -> None:
    places = np.repeat([[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]], 6, axis=0)
    d = apart(np.random.default_rng(2).permutation(places))
    assert length(d, short_order(d)) == pytest.approx(10 + 5 * 2**0.5)


def test_unreachable_places_are_refused() -> None:
    d = apart(np.random.default_rng(3).uniform(0, 1, (5, 2)))
    d[1, 3] = d[3, 1] = np.inf
    with pytest.raises(ValueError, match="reachable"):
        short_order(d)


def test_improving_keeps_a_permutation_and_never_lengthens() -> None:
    rng = np.random.default_rng(6)
    for n in (4, 5, 6, 9, 17, 60):
        for neighbours in (1, 3, n - 1):
            d = apart(rng.uniform(0, 100, (n, 2)))
            far = d.copy()
            np.fill_diagonal(far, np.inf)
            near = np.ascontiguousarray(np.argsort(far, axis=1, kind="stable")[:, :neighbours].astype(np.int64))
            order = rng.permutation(n).astype(np.int64)
            before = length(d, order)
            while improve_once(d, near, 1e-9, order):
                assert length(d, order) < before
            assert sorted(order.tolist()) == list(range(n))
            after = length(d, order)
            assert after <= before + 1e-9
            assert not improve_once(d, near, 1e-9, order)
            assert length(d, order) == after  # nothing more to gain


def test_no_exchange_of_two_edges_and_no_moved_stretch_shortens_the_outcome() -> None:
    rng = np.random.default_rng(8)
    for n in (7, 10, 12):
        d = apart(rng.uniform(0, 100, (n, 2)))
        order = short_order(d)  # so few places that each knows all others
        best = length(d, order)
        for i, j in itertools.combinations(range(n), 2):
            assert length(d, np.concatenate([order[:i], order[i : j + 1][::-1], order[j + 1 :]])) > best - 1e-6
        for turn, size in itertools.product(range(n), (1, 2, 3)):
            turned = np.roll(order, -turn)
            stretch, rest = turned[:size], turned[size:]
            for at in range(len(rest)):
                for piece in (stretch, stretch[::-1]):
                    assert length(d, np.concatenate([rest[:at], piece, rest[at:]])) > best - 1e-6


def test_nearest_neighbour_by_hand() -> None:
    places = np.array([[0.0, 0], [10, 0], [1, 0], [-2, 0], [4, 0]])
    assert nearest_neighbour_tour(apart(places)).tolist() == [0, 2, 3, 4, 1]


def test_flipping_a_stretch_over_the_seam() -> None:
    for first, last in itertools.product(range(6), repeat=2):
        order = np.array([3, 1, 4, 0, 5, 2], dtype=np.int64)
        place = np.argsort(order).astype(np.int64)
        cycle = order.tolist()
        reverse_places(first, last, order, place)
        assert place[order].tolist() == list(range(6))
        # the stretch first..last, going round, stands reversed; the rest stands as it was
        stretch = [(first + k) % 6 for k in range((last - first) % 6 + 1)]
        expected = list(cycle)
        for i, j in zip(stretch, reversed(stretch), strict=True):
            expected[i] = cycle[j]
        assert order.tolist() == expected


def test_lanes_go_to_and_fro() -> None:
    xs, ys = np.meshgrid(np.arange(5.0), np.array([0.5, 2.5, 4.5]))
    places = np.column_stack([xs.ravel(), ys.ravel()])
    shuffled = np.random.default_rng(0).permutation(places)
    ordered = shuffled[lane_order(shuffled, 2.0)]
    assert ordered[:, 1].tolist() == [0.5] * 5 + [2.5] * 5 + [4.5] * 5
    assert ordered[:, 0].tolist() == [0, 1, 2, 3, 4, 4, 3, 2, 1, 0, 0, 1, 2, 3, 4]


@pytest.mark.parametrize("n", [2, 13, 600])
def test_nearest_places_are_those_of_all_sorted_the_first_of_several_as_near(n: int) -> None:
    d = apart(np.random.default_rng(n).integers(0, 12, (n, 2)).astype(np.float64))  # most distances come several times
    others = d.copy()
    np.fill_diagonal(others, np.inf)
    assert np.array_equal(nearest_places(d, 12), np.argsort(others, axis=1, kind="stable")[:, : min(12, n - 1)])

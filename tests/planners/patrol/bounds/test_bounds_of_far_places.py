"""Bounds from places far apart: against brute force over robots' orders, and against teams that are known to do."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from rota.planners.patrol.bounds.chain_bound import best_chain, chain_robots, straight_chain
from rota.planners.patrol.bounds.forest_bound import shortest_tree, travel_robots


def ways(xy: np.ndarray) -> np.ndarray:
    return np.hypot(*(xy[:, None] - xy[None, :]).transpose(2, 0, 1))


def robots_for_one_window(way_m: np.ndarray, travel_m: float) -> int:
    """The fewest paths of at most so long that pass all points, by dynamic programming over subsets."""
    n = len(way_m)
    shortest = np.full((1 << n, n), math.inf)
    for i in range(n):
        shortest[1 << i, i] = 0
    for seen in range(1 << n):
        for i, j in itertools.product(range(n), range(n)):
            if seen >> i & 1 and not seen >> j & 1:
                more = seen | 1 << j
                shortest[more, j] = min(shortest[more, j], shortest[seen, i] + way_m[i, j])
    one = shortest.min(axis=1) <= travel_m
    fewest = [0] + [n] * ((1 << n) - 1)
    for seen in range(1, 1 << n):
        part = seen
        while part:
            if one[part]:
                fewest[seen] = min(fewest[seen], 1 + fewest[seen & ~part])
            part = (part - 1) & seen
    return fewest[-1]


def robots_on_a_graph(edges: list[tuple[int, int]], periods: tuple[int, ...]) -> int:
    """The fewest robots that walk an edge (or wait) a second and visit each node in any window of its period.

    Searches all states (places, seconds since each node was visited) for those from which one can go on for ever.
    """
    n = len(periods)
    steps = [[i, *(b for a, b in edges if a == i), *(a for a, b in edges if b == i)] for i in range(n)]
    for robots in range(1, n + 1):
        places = list(itertools.combinations_with_replacement(range(n), robots))
        ages = list(itertools.product(*(range(t) for t in periods)))
        alive = {(p, a) for p in places for a in ages if all(a[i] == 0 for i in p)}

        def goes_on(state: tuple[tuple[int, ...], tuple[int, ...]], alive: set[object] = alive) -> bool:
            here, age = state
            for there in itertools.product(*(steps[i] for i in here)):
                later = tuple(0 if i in there else a + 1 for i, a in enumerate(age))
                if (tuple(sorted(there)), later) in alive:
                    return True
            return False

        while True:
            dead = {state for state in alive if not goes_on(state)}
            if not dead:
                break
            alive -= dead
        if alive:
            return robots
    raise AssertionError("a robot at every node is enough")


def all_bounds(way: np.ndarray, periods: np.ndarray, speed: float, reach: float = 0.0) -> list[int]:
    n = len(way)
    apart = np.maximum(0, way - 2 * reach)
    np.fill_diagonal(apart, 0)
    found = [best_chain(way, np.full(n, reach), periods, speed)]
    for window in np.unique(periods):
        asked = np.flatnonzero(periods <= window)
        found.append(travel_robots(apart[np.ix_(asked, asked)], float(window), speed)[0])
    return found


def test_never_above_the_best_team_on_small_graphs() -> None:
    rng = np.random.default_rng(4)
    sharp = 0
    for _ in range(30):
        n = int(rng.integers(3, 5))
        edges = [(i, int(rng.integers(i))) for i in range(1, n)]
        if rng.random() < 0.3:
            edges.append((0, n - 1))
        periods = tuple(int(t) for t in rng.integers(1, 6, n))
        way = np.full((n, n), np.inf)
        np.fill_diagonal(way, 0)
        for a, b in edges:
            way[a, b] = way[b, a] = 1
        for k in range(n):
            way = np.minimum(way, way[:, k, None] + way[None, k])
        best = robots_on_a_graph(edges, periods)
        bounds = all_bounds(way, np.array(periods, dtype=float), 1.0)
        assert max(bounds) <= best, (edges, periods)
        sharp += max(bounds) == best
    assert sharp >= 20


def test_two_robots_on_a_triangle_serve_three_points() -> None:
    # a ring of 60 m: two robots half a ring apart pass each point every 30 s at 1 m/s, though a round trip between two
    # of the three points takes 40 s: nothing may ask for three
    way = np.where(np.eye(3, dtype=bool), 0.0, 20.0)
    bounds = all_bounds(way, np.full(3, 30.0), 1.0)
    assert max(bounds) == 2


def test_a_window_of_travel_against_all_orders() -> None:
    rng = np.random.default_rng(8)
    sharp = 0
    for _ in range(60):
        n = int(rng.integers(2, 8))
        apart = ways(rng.uniform(0, 1, (n, 2)))
        travel = float(rng.uniform(0.2, 1.5))
        best = robots_for_one_window(apart, travel)
        found, shown = travel_robots(apart, travel, 1.0)
        assert found <= best
        assert found == 1 or len(shown) >= found
        sharp += found == best
    assert sharp >= 40


def test_a_corridor_has_its_closed_form() -> None:
    # k robots to and fro, each over V T / 2, see k (V T / 2 + 2 r) of a corridor, and k - 1 cannot see more than
    # (k - 1)(V T / 2 + 2 r): a chain shows it
    r, speed, period = 2.0, 3.0, 20.0
    each = speed * period / 2 + 2 * r
    for k in range(1, 8):
        for length, expected in ((k * each, k), (k * each * 1.01, k + 1)):
            x = np.linspace(0, length, 2001)
            xy = np.column_stack([x, np.zeros(2001)])
            assert straight_chain(xy, r, np.full(2001, period), speed) == expected
            way = ways(xy[::20])
            assert best_chain(way, np.full(len(way), r), np.full(len(way), period), speed) in (expected - 1, expected)


def test_a_chain_with_periods_of_its_own_for_each_place() -> None:
    # heights 0, 10, 20 with reach 1 at 1 m/s: whoever serves the first within 16 s is never above 1 + 8 = 9 < 10 - 1...
    low, high = np.array([-1.0, 9.5, 19.0]), np.array([1.0, 10.5, 21.0])
    assert chain_robots(low, high, np.array([16.0, 16.0, 16.0]), 1.0)[0] == 3
    # ... but within 17.1 s it is at 9.55, where the second is served
    assert chain_robots(low, high, np.array([17.1, 16.0, 16.0]), 1.0)[0] == 2
    # a patient place in between asks for nobody of its own
    assert chain_robots(low, high, np.array([16.0, 1000.0, 16.0]), 1.0)[0] == 2
    assert chain_robots(np.zeros(0), np.zeros(0), np.zeros(0), 1.0)[0] == 0


def test_a_ring_is_no_corridor() -> None:
    # robots that follow each other round a ring of length L pass every point each L / (k V): k are enough, and a
    # corridor as long would take twice as many
    speed, length = 1.0, 120.0
    s = length * np.arange(60) / 60
    gap = np.abs(s[:, None] - s[None, :])
    way = np.minimum(gap, length - gap)
    for k in range(1, 9):
        bounds = all_bounds(way, np.full(60, length / (k * speed)), speed)
        assert max(bounds) <= k
    assert max(all_bounds(way, np.full(60, length / 8 * 0.99), speed)) >= 8


def test_the_shortest_tree_against_scipy() -> None:
    from scipy.sparse.csgraph import minimum_spanning_tree

    rng = np.random.default_rng(1)
    for n in (1, 2, 5, 40):
        length = ways(rng.uniform(0, 1, (n, 2)))
        one, other, edges = shortest_tree(length)
        assert edges.sum() == pytest.approx(minimum_spanning_tree(length).sum())
        assert np.allclose(length[one, other], edges)
        assert set(one) | set(other) == (set(range(n)) if n > 1 else set())


def test_longer_periods_never_raise_chains() -> None:
    rng = np.random.default_rng(6)
    for _ in range(20):
        way = ways(rng.uniform(0, 100, (30, 2)))
        periods = rng.uniform(1, 30, 30)
        longer = periods * rng.uniform(1, 2, 30)
        chains = [best_chain(way, np.zeros(30), t, 1.0) for t in (periods, longer)]
        assert chains[1] <= chains[0]

"""Greedy and exact set cover against brute force."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from rota.planners.patrol.methods.sun2019.sensors import exact_cover, greedy_cover, leave_out_dominated


def lists(sees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.append(0, np.cumsum(sees.sum(axis=1))), np.nonzero(sees)[1]


def random_instance(seed: int, places: int = 12, cells: int = 14) -> np.ndarray:
    rng = np.random.default_rng(seed)
    sees = rng.random((places, cells)) < 0.3
    sees[rng.integers(places, size=cells), np.arange(cells)] = True
    return sees


def fewest(sees: np.ndarray) -> int:
    """The least number of rows that together have every column that any has."""
    wanted = sees.any(axis=0)
    for k in range(len(sees) + 1):
        for rows in combinations(range(len(sees)), k):
            if (sees[list(rows)].any(axis=0) | ~wanted).all():
                return k
    raise AssertionError


def greedily(sees: np.ndarray) -> list[int]:
    left, chosen = sees.any(axis=0), []
    while left.any():
        chosen.append(int(np.argmax((sees & left).sum(axis=1))))
        left &= ~sees[chosen[-1]]
    return chosen


@pytest.mark.parametrize("seed", range(8))
def test_greedy_takes_what_sees_most_of_the_rest(seed: int) -> None:
    sees = random_instance(seed)
    assert greedy_cover(*lists(sees), sees.shape[1]).tolist() == greedily(sees)


@pytest.mark.parametrize("seed", range(8))
def test_exact_is_as_few_as_brute_force_finds(seed: int) -> None:
    sees = random_instance(seed)
    chosen, least = exact_cover(*lists(sees), sees.shape[1], node_limit=1000)
    assert (len(chosen), least) == (fewest(sees), fewest(sees))
    assert sees[chosen].any(axis=0).all()


@pytest.mark.parametrize("seed", range(8))
def test_dominance_keeps_a_least_cover(seed: int) -> None:
    sees = random_instance(seed, cells=25)
    places, cells = leave_out_dominated(csr_matrix(sees.astype(float)))
    assert fewest(sees[np.ix_(places, cells)]) == fewest(sees)


def test_greedy_may_need_more_than_the_exact_cover() -> None:
    # two rows of three cells; greedy takes the middle four first and then both ends
    sees = np.array([[1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 1], [0, 1, 1, 1, 1, 0]], dtype=bool)
    assert len(greedy_cover(*lists(sees), 6)) == 3
    assert len(exact_cover(*lists(sees), 6, node_limit=1)[0]) == 2


def test_cells_that_nothing_sees_and_no_cells_at_all() -> None:
    sees = np.array([[1, 0, 0], [1, 0, 1]], dtype=bool)
    assert exact_cover(*lists(sees), 3, node_limit=1)[0].tolist() == [1]
    assert greedy_cover(*lists(sees), 3).tolist() == [1]
    chosen, least = exact_cover(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), 0, node_limit=1)
    assert (len(chosen), least) == (0, 0)

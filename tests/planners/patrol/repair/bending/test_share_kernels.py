"""How legs share samples: against weights from a grid, and lanes that move aside together."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from rota.planners.patrol.repair.bending.share_kernels import share_out


def shares_of(deficit_m: np.ndarray, towards: np.ndarray, alone: bool = False) -> np.ndarray:
    """The shares (3,) of one sample."""
    shares = np.full((1, 3), np.nan)
    share_out(deficit_m[None], towards[None], np.array([alone]), shares)
    return shares[0]


def directions(*angles: float) -> np.ndarray:
    return np.column_stack([np.cos(angles), np.sin(angles)])


def shortest_mean(towards: np.ndarray, legs: int) -> float:
    """The length of the shortest mean of two or three directions, by trying all weights in hundredths."""
    steps = np.linspace(0, 1, 101)
    weights = np.array([(a, b, 1 - a - b) for a, b in itertools.product(steps, steps) if a + b <= 1 + 1e-9])
    if legs == 2:
        weights = weights[np.abs(weights[:, 2]) < 1e-9]
    return float(np.hypot(*(weights @ towards).T).min())


@pytest.mark.parametrize("legs", [2, 3])
@pytest.mark.parametrize("seed", range(8))
def test_the_mean_of_directions_is_as_short_as_can_be(legs: int, seed: int) -> None:
    towards = directions(*np.random.default_rng(seed).uniform(0, 2 * math.pi, 3))
    shares = shares_of(np.array([0.0, 0.0, 0.0 if legs == 3 else math.inf]), towards)
    assert shares.sum() == pytest.approx(1)
    assert (shares >= 0).all()
    assert np.hypot(*(shares @ towards)) == pytest.approx(shortest_mean(towards, legs), abs=0.02)


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_asked_for_that_is_not_short(seed: int) -> None:
    rng = np.random.default_rng(seed)
    towards, deficit_m = directions(*rng.uniform(0, 2 * math.pi, 3)), np.sort(rng.uniform(-0.3, 0.3, 3))
    shares = shares_of(deficit_m, towards)
    assert shares.sum() == pytest.approx(1)
    assert (shares >= 0).all()
    assert shares @ deficit_m <= max(0.0, deficit_m[0]) + 1e-12


def test_who_alone_sees_a_sample_keeps_it() -> None:
    apart = directions(0.0, math.pi, 1.0)
    assert shares_of(np.array([-0.1, math.inf, math.inf]), apart).tolist() == [1, 0, 0]
    assert shares_of(np.array([-0.1, -0.1, -0.1]), apart, alone=True).tolist() == [1, 0, 0]

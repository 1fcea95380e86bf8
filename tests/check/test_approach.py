"""The closest approach of two that accelerate: closed forms, and shares of the time tried one by one."""

from __future__ import annotations

import numpy as np
import pytest
from tests.seeds import seeds

from rota.check.approach import gaps_at, nearest_shares


def test_even_motions_are_nearest_where_their_line_is() -> None:
    gap, drift = np.array([[3.0, 4.0], [1.0, 0.0], [1.0, 0.0]]), np.array([[0.0, -8.0], [1.0, 0.0], [0.0, 0.0]])
    assert nearest_shares(gap, drift, np.zeros((3, 2))).tolist() == [0.5, 0.0, 0.0]


def test_a_robot_from_rest_is_nearest_where_its_parabola_is() -> None:
    """1 m beside a post on its way: it gets there, 2.25 m of 9 m along, in half of the time."""
    shares = nearest_shares(np.array([[2.25, 1.0]]), np.array([[-9.0, 0.0]]), np.array([[-9.0, 0.0]]))
    assert shares == pytest.approx([0.5], abs=1e-12)
    assert gaps_at(np.array([[2.25, 1.0]]), np.array([[-9.0, 0.0]]), np.array([[-9.0, 0.0]]), shares)[0] == (
        pytest.approx([0.0, 1.0], abs=1e-12)
    )


@pytest.mark.parametrize("seed", seeds(4, at_once=2))
def test_no_share_that_is_tried_is_nearer(seed: int) -> None:
    """Vectors of all sizes and directions, bows much larger and much smaller than what they bend, some parallel."""
    rng = np.random.default_rng(seed)
    n = 2000
    gap, drift, bow = (rng.normal(size=(n, 3)) * 10 ** rng.uniform(-4, 2, (n, 1)) for _ in range(3))
    along = rng.random(n) < 0.3
    drift[along], bow[along] = gap[along] * rng.normal(size=(n, 1))[along], gap[along] * rng.normal(size=(n, 1))[along]
    bow[rng.random(n) < 0.1] = 0.0
    found = np.linalg.norm(gaps_at(gap, drift, bow, nearest_shares(gap, drift, bow)), axis=1)
    for share in np.linspace(0, 1, 1001):
        tried = np.linalg.norm(gaps_at(gap, drift, bow, np.full(n, share)), axis=1)
        assert (found <= tried + 1e-12 * (1 + np.abs(gap).max(axis=1))).all()

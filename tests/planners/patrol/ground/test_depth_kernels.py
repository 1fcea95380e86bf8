"""Depths of sight only save time: what a leg sees with them is what it sees without, wall by wall."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rota.planners.patrol.ground.depth_kernels import depths
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.samples import points_of, prepare
from rota.planners.patrol.ground.sight_kernels import DEPTH_SECTORS, sectors_from_x

Floats = NDArray[np.float64]


def rooms(rng: np.random.Generator, count: int) -> Floats:
    """Walls (n, 4) of blocks on whole and half metres, so that many line up, and of blocks turned by any angle."""
    walls = []
    for k in range(count):
        low = rng.integers(0, 20, 2) / 2
        size = rng.integers(1, 5, 2) / 2
        corners = low + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        if k % 3 == 0:
            turn = rng.uniform(0, np.pi)
            corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        walls.append(np.hstack([corners, np.roll(corners, -1, axis=0)]))
    return np.vstack(walls)


def runs(leg: Floats, square: int, samples: Samples) -> list[int]:
    out = np.empty(2 * len(samples.x), dtype=np.int32)
    return out[: leg_sees(Leg(*leg, 3.0, square), 0, samples, out)].tolist()


@pytest.mark.parametrize("seed", range(6))
def test_legs_see_the_same_with_depths_and_without(seed: int) -> None:
    rng = np.random.default_rng(seed)
    walls = rooms(rng, 12)
    # also points on walls, on their ends, and in line with them
    places = np.vstack([rng.uniform(0, 12, (400, 2)), rng.integers(0, 25, (400, 2)) / 2, walls[:, :2]])
    points = points_of(places, 1.0, 0, 0)
    _, samples, _ = prepare(points, walls, reach_m=3.0, weight=np.ones(len(points)), wall_margin_m=0.003 * (seed % 2))
    unknown = np.zeros_like(samples.depth2)
    unknown[:, 1] = np.inf
    blind = samples._replace(depth2=unknown)
    decided = 0
    for k in range(300):
        ends = rng.uniform(0, 12, 4) if k % 2 else rng.integers(0, 25, 4) / 2
        leg = ends if k % 5 else np.append(ends[:2], ends[:2])
        assert runs(leg, k % 2, samples) == runs(leg, k % 2, blind)
        decided += len(runs(leg, k % 2, samples))
    assert decided > 1_000


def test_depths_of_a_point_before_a_wall() -> None:
    wall = np.array([[-10.0, 2.0, 10.0, 2.0]])
    start, item = np.array([0, 1]), np.array([0])
    clear, blocked = np.sqrt(depths(np.zeros((1, 2)), start, item, wall)[0])
    up = int(sectors_from_x(0.0, 1.0))  # the sector that begins straight ahead
    assert clear[up] == pytest.approx(2.0, rel=1e-4)
    width = np.pi / 2 - np.arctan2(1 - 4 / DEPTH_SECTORS, 4 / DEPTH_SECTORS)
    assert blocked[up] == pytest.approx(2 / np.cos(width), rel=1e-4)
    down = int(sectors_from_x(0.0, -1.0))
    assert np.isinf([clear[down], blocked[down]]).all()


def test_nothing_is_clear_round_a_point_on_a_wall_and_all_before_a_wall_seen_from_its_end() -> None:
    start, item = np.array([0, 1]), np.array([0])
    on, beside = (depths(np.zeros((1, 2)), start, item, np.array([[x, 0.0, 3.0, 0.0]]))[0] for x in (-1.0, 1.0))
    assert not on[0].any()
    assert np.isinf(on[1]).all()
    assert np.isinf(beside).all()

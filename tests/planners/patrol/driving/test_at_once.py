"""What moves of vertices cost robots that turn on the spot, against differences of whole rounds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from rota.model.mission import DiscSensor, Fleet
from rota.planners.patrol.driving.driving import driving_of

PLAIN = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=3.0)).equal_robot("r")
TURNING = replace(PLAIN, turn_rate_rad_s=0.5)


def differences(vertices_m: np.ndarray, step_m: float) -> np.ndarray:
    """By how much a round grows for each metre (n, 2) that a vertex moves along an axis."""
    round_m, found = driving_of(TURNING).round_m, np.zeros_like(vertices_m)
    for place in np.ndindex(vertices_m.shape):
        moved_m = vertices_m.copy()
        moved_m[place] += step_m
        found[place] = (round_m(moved_m) - round_m(vertices_m)) / step_m
    return found


@pytest.mark.parametrize("corners", [2, 3, 9])
def test_slopes_are_differences_of_rounds(corners: int) -> None:
    vertices_m = np.random.default_rng(corners).uniform(0, 40, (corners, 2))
    slopes = driving_of(TURNING).slopes
    assert slopes is not None
    growth, bends = slopes(vertices_m)
    if corners > 2:  # a way there and back turns by pi at either end, as much as there is
        between = (differences(vertices_m, 1e-6) + differences(vertices_m, -1e-6)) / 2
        assert growth == pytest.approx(between, abs=1e-4)
    assert (bends == 0).all()


def test_a_round_of_one_place_has_no_slopes() -> None:
    slopes = driving_of(TURNING).slopes
    assert slopes is not None
    growth, bends = slopes(np.array([[3.0, 4.0]]))
    assert (growth == 0).all()
    assert (bends == 0).all()


def test_a_straight_way_takes_longer_whichever_way_it_bends() -> None:
    vertices_m = np.array([[0.0, 0.0], [10.0, 0.0], [14.0, 0.0], [20.0, 0.0], [20.0, 12.0], [0.0, 12.0]])
    slopes = driving_of(TURNING).slopes
    assert slopes is not None
    growth, bends = slopes(vertices_m)
    up, down = differences(vertices_m, 1e-6)[1:3, 1], -differences(vertices_m, -1e-6)[1:3, 1]
    assert bends[1:3, 1] + growth[1:3, 1] == pytest.approx(up, abs=1e-4)
    assert bends[1:3, 1] - growth[1:3, 1] == pytest.approx(down, abs=1e-4)
    assert (bends[[0, 3, 4, 5]] == 0).all()
    assert (bends[:, 0] == 0).all()


def test_what_needs_no_slopes_has_none() -> None:
    assert driving_of(PLAIN).slopes is None
    assert driving_of(replace(PLAIN, turn_radius_m=1.0)).slopes is None


def test_the_round_of_a_square() -> None:
    square_m = 30 * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert driving_of(TURNING).round_m(square_m) == pytest.approx(120 + 2 * math.pi / 0.5 * 2.0)

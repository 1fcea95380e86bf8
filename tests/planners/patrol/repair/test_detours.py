"""A detour leaves a long leg beside the place it leads to, so that what the rest of the leg sees stays seen."""

from __future__ import annotations

import numpy as np

from rota.planners.patrol.repair.detours import LONG_LEG, left_near

REACH_M = 5.0


def test_a_long_leg_is_left_and_come_back_to_beside_the_place() -> None:
    kept = left_near(np.array([0.0, 0.0]), np.array([100.0, 0.0]), np.array([[40.0, 3.0]]), REACH_M)
    np.testing.assert_allclose(kept, [[40.0, 0.0], [40.0, 0.0]])


def test_it_is_left_on_the_leg_itself() -> None:
    kept = left_near(np.array([0.0, 0.0]), np.array([0.0, 30.0]), np.array([[4.0, 1.0], [4.0, 29.0]]), REACH_M)
    np.testing.assert_allclose(kept, [[0.0, 1.0], [0.0, 29.0]])


def test_a_short_leg_is_led_past_as_a_whole() -> None:
    end = np.array([0.99 * LONG_LEG * REACH_M, 0.0])
    assert left_near(np.zeros(2), end, np.array([[10.0, 3.0]]), REACH_M).shape == (0, 2)

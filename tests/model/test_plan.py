"""Trajectories of accelerated legs."""

from __future__ import annotations

import numpy as np
import pytest

from rota.errors import PlanError
from rota.model.plan import Trajectory


def test_a_leg_from_rest_to_rest_of_its_end_is_a_parabola_in_time() -> None:
    there_and_back = {"times_s": [0, 2, 4], "positions_m": [[0, 0], [4, 0], [0, 0]], "accelerations_m_s2": [2, -2]}
    trajectory = Trajectory(robot="a", **there_and_back)
    assert trajectory.bends.tolist() == [1, -1]
    at_s = np.array([0.5, 1, 2, 3, 5])
    assert trajectory.at(at_s)[:, 0] == pytest.approx([0.25, 1, 4, 1, 1])  # a t^2 / 2; 4 - 4 u + u^2 on the way back
    assert trajectory.at(1).tolist() == [1, 0]


def test_a_leg_that_would_begin_backwards_is_refused() -> None:
    with pytest.raises(PlanError, match=r"accelerations_m_s2\[0\] = 2.1; on this leg at most 2 m/s2"):
        Trajectory(robot="a", times_s=[0, 2], positions_m=[[0, 0], [4, 0]], accelerations_m_s2=[2.1], loop_start_s=2)
    with pytest.raises(PlanError, match="one per leg"):
        Trajectory(robot="a", times_s=[0, 2], positions_m=[[0, 0], [4, 0]], accelerations_m_s2=[0, 0], loop_start_s=2)


def test_far_away_a_leg_may_begin_at_rest_as_rounding_leaves_it() -> None:
    """At the northings of UTM, where places are told to 1e-9 m: from rest at 0.999 m/s2, over 2 to 8 cm."""
    for k in range(200):
        lasts_s = 0.2 + k / 1000
        far_m = 5.5e6 + k
        places_m = np.array([[5e5, far_m], [5e5, far_m + 0.999 * lasts_s**2 / 2]])
        told = {"positions_m": places_m, "accelerations_m_s2": [0.999], "loop_start_s": lasts_s}
        trajectory = Trajectory(robot="a", times_s=[0, lasts_s], **told)
        assert trajectory.bends[0] == pytest.approx(1, abs=1e-7)
        with pytest.raises(PlanError, match="backwards"):
            Trajectory(robot="a", times_s=[0, lasts_s * (1 + 1e-6)], **told | {"loop_start_s": lasts_s * (1 + 1e-6)})

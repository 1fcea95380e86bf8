"""Shares of a leg's way as times: the inverse of what a trajectory does."""

from __future__ import annotations

import numpy as np
import pytest

from rota.check.timing_kernels import time_along
from rota.model.plan import Trajectory


@pytest.mark.parametrize("bend", [-1.0, -0.999999, -0.3, -1e-12, 0.0, 1e-12, 0.5, 0.999999, 1.0])
def test_the_robot_is_there_at_that_time(bend: float) -> None:
    way = Trajectory(
        robot="a", times_s=[0, 4, 20], positions_m=[(0, 0), (0, 0), (8, 6)],
        accelerations_m_s2=[0, 2 * bend * 10 / 16**2], loop_start_s=20,
    )  # fmt: skip
    for share in (0.0, 1e-9, 0.01, 0.3, 0.5, 0.99, 1 - 1e-12, 1.0):
        at_s = time_along(4.0, 20.0, way.bends[1], share)
        assert 4 <= at_s <= 20
        assert way.at(at_s) == pytest.approx([8 * share, 6 * share], abs=1e-12)
    assert (time_along(4.0, 20.0, bend, 0.0), time_along(4.0, 20.0, bend, 1.0)) == (4.0, 20.0)


def test_later_places_are_reached_later() -> None:
    for bend in (-1.0, 1.0, 0.7):
        at_s = np.array([time_along(0.0, 1.0, bend, share) for share in np.linspace(0, 1, 1001)])
        assert (np.diff(at_s) > 0).all()
    assert time_along(0.0, 2.0, 1.0, 0.25) == 1.0  # from rest: half of the time for a quarter of the way
    assert time_along(0.0, 2.0, -1.0, 0.75) == 1.0

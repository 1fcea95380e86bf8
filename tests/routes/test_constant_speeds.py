"""Legs with accelerations beside the shorter ones at constant speeds that stand for them."""

from __future__ import annotations

import numpy as np
import pytest
from tests.routes.test_passed_stops import TOP, A, drawn, rounded

from rota.model.plan import Trajectory
from rota.routes.constant_speeds import at_constant_speeds


@pytest.mark.parametrize("within_m", [0.05, 0.5, 1e-3])
@pytest.mark.parametrize("seed", range(8))
def test_at_any_moment_it_is_as_near_as_asked(seed: int, within_m: float) -> None:
    whole = rounded(*drawn(seed), top=TOP, a=A)
    straight = at_constant_speeds(whole, within_m)
    assert straight.accelerations_m_s2 is None
    assert straight.loop_start_s == whole.loop_start_s
    assert set(whole.times_s.tolist()) <= set(straight.times_s.tolist())
    moments = np.linspace(0, whole.times_s[-1], 20_011)
    told = np.column_stack([np.interp(moments, straight.times_s, axis) for axis in straight.positions_m.T])
    off_m = np.linalg.norm(told - whole.at(moments), axis=1)
    assert off_m.max() <= within_m * (1 + 1e-9)
    assert off_m.max() > within_m / 5  # no more points than it takes


def test_constant_speeds_stay_as_they_are() -> None:
    even = Trajectory(robot="a", times_s=[0, 1, 2], positions_m=[[0, 0], [1, 0], [0, 0]])
    assert at_constant_speeds(even) is even


def test_a_leg_that_hardly_takes_time_stays_one() -> None:
    quick = Trajectory(
        robot="a",
        times_s=[0, 1, 1 + 3e-16, 2],
        positions_m=[[0, 0], [1, 0], [2, 0], [0, 0]],
        headings_rad=[0, 1, 2, 3],
        accelerations_m_s2=[2, 1e30, 0],
    )
    straight = at_constant_speeds(quick)
    assert (np.diff(straight.times_s) > 0).all()
    assert straight.positions_m[-3:].tolist() == [[1, 0], [2, 0], [0, 0]]
    assert straight.headings_rad is not None
    assert straight.headings_rad.shape == straight.times_s.shape

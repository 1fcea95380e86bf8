"""Plans without points on straight ways: where robots are at any moment, and what becomes of waits and rounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.vehicles.small_plans import square, winding

from rota.errors import RotaError
from rota.model.plan import Floats, Trajectory
from rota.vehicles.straight_ways import straighten_ways


def at(trajectory: Trajectory, times_s: Floats) -> Floats:
    return np.column_stack([np.interp(times_s, trajectory.times_s, axis) for axis in trajectory.positions_m.T])


@pytest.mark.parametrize(("off_m", "within_m", "points"), [(0, 0.01, 6), (0.3, 0.5, 6), (0.3, 0.1, 26)])
def test_points_on_straight_ways_go_and_corners_and_waits_stay(off_m: float, within_m: float, points: int) -> None:
    plan = winding(off_m)
    (before,), (after,) = plan.trajectories, straighten_ways(plan, within_m).trajectories
    assert len(after.times_s) == pytest.approx(points, abs=2 * (off_m > within_m))
    times_s = np.linspace(0, before.times_s[-1], 5000)
    assert np.linalg.norm(at(before, times_s) - at(after, times_s), axis=1).max() <= within_m + 1e-9
    assert (after.loop_duration_s, after.loop_start_s) == (before.loop_duration_s, 0)
    steps_s, steps_m = np.diff(after.times_s), np.linalg.norm(np.diff(after.positions_m, axis=0), axis=1)
    assert steps_s[steps_m == 0] == pytest.approx([7.5])
    assert (steps_m / steps_s).max() <= 8 * (1 + 1e-9)


def test_robots_whose_legs_have_accelerations_keep_their_points() -> None:
    plan = winding(0.3)
    (way,) = plan.trajectories
    driven = Trajectory(
        robot="robot-2",
        times_s=[0.0, 4.0, 8.0, 12.0, 16.0],
        positions_m=[[0, 0], [8, 0], [16, 0], [8, 0], [0, 0]],
        accelerations_m_s2=[1.0, -1.0, 1.0, -1.0],
    )
    straight, kept = straighten_ways(replace(plan, trajectories=(way, driven)), 0.5)
    assert len(straight.times_s) < len(way.times_s)
    assert kept is driven
    with pytest.raises(RotaError, match="of its 5 points rota export writes 3 stops, the corners and waits alone"):
        straighten_ways(replace(plan, trajectories=(driven,)), 0.5)


def test_lengths_that_are_none_are_refused() -> None:
    for within_m in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(RotaError, match="is not allowed; must be greater than 0"):
            straighten_ways(square(100), within_m)

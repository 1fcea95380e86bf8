"""Robots that set out in turn: closed forms on a crossing, and stepping in time beside it."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from rota import Trajectory
from rota.planners.patrol.traffic.starts.one_by_one import set_out_in_turn
from rota.routes.moments import delay

EAST = Trajectory(robot="a", times_s=[0, 20], positions_m=[[0, 10], [20, 10]], loop_start_s=20)
NORTH = Trajectory(robot="b", times_s=[0, 21], positions_m=[[10, -1], [10, 20]], loop_start_s=21)
BODIES_M = {"a": 0.5, "b": 0.5}


def units(*ways: Trajectory) -> list[partial[list[Trajectory]]]:
    """Each on its own, later by as much as is asked."""
    return [partial(lambda way, by_s: [delay(way, by_s)], way) for way in ways]


def least_apart_m(one: Trajectory, other: Trajectory) -> float:
    """By steps of a thousandth of a second."""
    moments_s = np.arange(0, 40, 1e-3)
    return float(np.hypot(*(one.at(moments_s) - other.at(moments_s)).T).min())


def test_the_second_one_waits_for_the_first_step_by_which_bodies_pass() -> None:
    # at 1 m/s and right angles they come within (lag / sqrt 2) of each other; 1 s behind already, b needs sqrt 2 s
    east, north = set_out_in_turn(units(EAST, NORTH), BODIES_M, 0.2)
    assert east.loop_start_s == 20
    assert north.loop_start_s == pytest.approx(21 + 0.6)
    assert least_apart_m(east, north) >= 1.0
    assert least_apart_m(east, delay(NORTH, 0.4)) < 1.0


def test_whoever_stands_in_the_way_goes_first() -> None:
    ahead = Trajectory(robot="b", times_s=[0, 40], positions_m=[[5, 10], [5, 50]], loop_start_s=40)
    east, gone = sorted(set_out_in_turn(units(EAST, ahead), BODIES_M, 1.0), key=lambda one: one.robot)
    assert least_apart_m(east, gone) >= 1.0
    assert gone.loop_start_s == 40


def test_nobody_sets_out_where_somebody_stays_in_the_way_or_cannot_go_at_all() -> None:
    stays = Trajectory(robot="b", times_s=[0.0], positions_m=[[10, 10]], loop_start_s=0)
    assert set_out_in_turn(units(EAST, stays), BODIES_M, 1.0) == []
    assert set_out_in_turn([*units(EAST), lambda _: []], BODIES_M, 1.0) == []

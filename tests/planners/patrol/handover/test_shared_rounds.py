"""Rounds that robots share, are joined and led past obstacles: lengths in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from tests.replanning.rings import on_the_ring

from rota.geometry.shortest_path import ShortestPaths
from rota.model.fleet import DiscSensor, Robot
from rota.model.motion_limits import AT_ONCE
from rota.planners.patrol.driving.at_once import timed_line
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.handover.rounds import Round, distances_between, is_clear, join_rounds, lead_round, rounds_of
from rota.planners.patrol.handover.shares import Share, sharings

ROBOT = Robot(
    name="a", speed_m_s=1, sensor=DiscSensor(radius_m=1), body_radius_m=0.0, turn_rate_rad_s=None, turn_radius_m=0.0,
    motion=AT_ONCE,
)  # fmt: skip
OPEN = shapely.MultiPolygon([shapely.box(-10, -10, 60, 20)])


def square(x: float) -> TimedLine:
    """A round of 40 m."""
    corners = np.array([[x, 0], [x + 10, 0], [x + 10, 10], [x, 10], [x, 0]], float)
    return timed_line(corners, np.zeros(4), ROBOT)


def test_robots_on_one_round_are_told_apart_by_how_far_they_are_ahead() -> None:
    rounds = rounds_of([on_the_ring("a", 0), on_the_ring("b", 13.5), on_the_ring("c", 31)])
    assert len(rounds) == 1
    ahead = [round(ahead_s % 40, 6) for ahead_s in rounds[0].ahead_s.values()]
    assert ahead == [0.0, 13.5, 31.0]


def test_two_rounds_are_joined_by_the_way_between_there_and_back() -> None:
    joined = join_rounds([square(0), square(25)], ROBOT, ShortestPaths(OPEN))
    assert joined.duration_s == pytest.approx(40 + 40 + 2 * 15, abs=0.1)
    for x in (0, 10, 25, 35):
        assert np.hypot(*(joined.places_m - [x, 10]).T).min() < 1e-3
    rounds = [Round(line=square(0), ahead_s={"a": 0.0}), Round(line=square(25), ahead_s={"b": 0.0})]
    between = distances_between(rounds, ShortestPaths(OPEN))
    assert between[0, 1] == pytest.approx(15, abs=0.5)
    assert sharings(rounds, ["a"], between, 1.0, 9) == [(Share((0, 1), 1),)]
    first = sharings(rounds, ["a", "b"], between, 1.0, 9)[0]
    assert {share.rounds for share in first} == {(0,), (1,)}


def test_the_round_that_would_be_driven_too_seldom_gets_the_robot_to_spare() -> None:
    rounds = [
        Round(line=square(0), ahead_s={"a": 0.0, "b": 20.0, "c": 10.0}),
        Round(line=square(25), ahead_s={"d": 0.0}),
    ]
    best = sharings(rounds, ["a", "b", "c"], distances_between(rounds, ShortestPaths(OPEN)), 1.0, 9)[0]
    assert {share.rounds: share.robots for share in best} == {(0,): 2, (1,): 1}


def test_a_round_goes_past_what_is_in_its_way_now() -> None:
    pole = shapely.box(4, -1, 6, 1)
    ground = shapely.MultiPolygon([OPEN.difference(pole)])
    assert is_clear(square(0).places_m, OPEN, 0.0)
    assert not is_clear(square(0).places_m, ground, 0.0)
    led = lead_round(square(0), ROBOT, ShortestPaths(ground))
    assert led is not None
    assert is_clear(led.places_m, ground, 0.0)
    # straight to the corners of the pole on one side, along it, and back to the way
    assert led.duration_s == pytest.approx(30 + 2 * np.hypot(4, 1) + 2, rel=1e-5)

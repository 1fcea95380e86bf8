"""Poses of small trajectories, worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.files.two_robots import two_robots, with_heights

from rota.errors import PlanError
from rota.files.ros.names import namespaces
from rota.files.ros.poses import MOST_BETWEEN, Motion, own_tracks, sampled_tracks
from rota.model.plan import Plan, Trajectory

SQUARE = Trajectory(
    robot="a",
    times_s=[0, 2, 4, 5, 7, 9, 11],
    positions_m=[[-2, 0], [0, 0], [2, 0], [2, 0], [2, 2], [0, 2], [0, 0]],
    loop_start_s=2,
)


def test_a_robot_faces_its_way_and_keeps_facing_it_while_it_waits() -> None:
    positions_m, yaws_rad = Motion(SQUARE).at(np.array([0, 1, 2, 4.5, 5, 6, 8, 10, 11.5, 20.5, 92.5]))
    assert positions_m[:, :2].tolist() == pytest.approx(
        np.array([[-2, 0], [-1, 0], [0, 0], [2, 0], [2, 0], [2, 1], [1, 2], [0, 1], [0.5, 0], [0.5, 0], [0.5, 0]])
    )
    assert not positions_m[:, 2].any()
    half = math.pi / 2
    assert yaws_rad == pytest.approx([0, 0, 0, 0, half, half, 2 * half, -half, 0, 0, 0])


def test_headings_turn_the_shorter_way() -> None:
    spinning = Trajectory(robot="a", times_s=[0, 1], positions_m=[[0, 0], [0, 0]], headings_rad=[3, -3])
    _, yaws_rad = Motion(spinning).at(np.array([0.5]))
    assert math.cos(yaws_rad[0]) == pytest.approx(-1)


def test_what_never_moves_faces_nowhere_and_is_still() -> None:
    plan = two_robots(robots=("a", "b"))
    standing = Trajectory(robot="a", times_s=[0], positions_m=[[1, 2]])
    positions_m, yaws_rad = Motion(standing).at(np.array([0, 5.0]))
    assert positions_m.tolist() == [[1, 2, 0], [1, 2, 0]]
    assert yaws_rad.tolist() == [0, 0]
    assert Motion(standing).still
    assert [track.still for track in own_tracks(plan)] == [False, False]


def test_a_path_has_the_timed_points_and_samples_have_them_too() -> None:
    plan = two_robots(robots=("a", "b"))
    own, sampled = own_tracks(plan), sampled_tracks(plan, 130.0)
    for trajectory, track, long in zip(plan, own, sampled, strict=True):
        np.testing.assert_array_equal(track.times_s, trajectory.times_s)
        np.testing.assert_array_equal(track.positions_m[:, :2], trajectory.positions_m)
        assert np.isin(trajectory.times_s, long.times_s).all()
        assert (long.times_s[0], long.times_s[-1]) == (0, 130)
        assert np.diff(long.times_s).min() > 0
        assert np.diff(long.times_s).max() <= 0.1 + 1e-9
    # the second round, too, has its corners
    assert 24 + plan.trajectories[0].loop_duration_s in sampled[0].times_s


def test_long_plans_have_longer_steps() -> None:
    tracks = sampled_tracks(two_robots(robots=("a", "b")), 1e6)
    assert all(np.diff(track.times_s).max() <= 2e6 / MOST_BETWEEN + 1e-9 for track in tracks)
    assert len(tracks[1].times_s) <= MOST_BETWEEN / 2 + 3


def test_short_loops_beside_long_ones_are_refused_before_memory_is_full() -> None:
    plan = two_robots(robots=("a", "b"))
    trembling = Trajectory(robot="a", times_s=[0, 1e-6, 2e-6], positions_m=[[0, 0], [0, 1e-9], [0, 0]])
    with pytest.raises(PlanError, match=r"a bag of 30 s has 4.5e\+07 timed points, .*; at most 2,000,000 are allowed"):
        sampled_tracks(Plan(mission=plan.mission, trajectories=(trembling,)), 30.0)


def test_heights_are_told_where_the_plan_has_them() -> None:
    climbing, flat = own_tracks(with_heights())
    assert climbing.positions_m[:, 2].tolist() == [30, 40.125, 30]
    assert not flat.positions_m[:, 2].any()


@pytest.mark.parametrize(
    ("robot", "name"),
    [("robot-1", "robot_1"), ("1", "robot_1"), ("_a__b ", "a_b"), ("Zoë", "Zo"), ("机", "robot"), ("a/b", "a_b")],
)
def test_names_become_what_ros_takes(robot: str, name: str) -> None:
    assert namespaces(two_robots(robots=(robot, "other"))) == (name, "other")


def test_names_that_ros_cannot_tell_apart_are_refused() -> None:
    with pytest.raises(PlanError, match="robot a_b: ROS knows it as a_b, as it does robot a-b; rename one of them"):
        namespaces(two_robots(robots=("a-b", "a_b")))
    with pytest.raises(PlanError, match=r"a name of 201 letters; at most 200 are allowed"):
        namespaces(two_robots(robots=("a" * 201, "b")))

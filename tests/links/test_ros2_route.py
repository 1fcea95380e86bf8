"""Routes by the clock, worked out by hand."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.files.with_mass import with_mass
from tests.links.fleets import ALTITUDE_M, loop_of, plan_of, routes_of, staying

from rota.errors import RotaError
from rota.links.link_settings import make_link
from rota.links.ros2_route import TimedPath, path_differences, timed_path
from rota.routes.route import route_of

LOOP = timed_path(routes_of(plan_of(loop_of("a", 0.0)))[0])


def test_a_path_has_the_plans_times_and_its_loop() -> None:
    trajectory = loop_of("a", 0.0)
    assert [time_ns / 1e9 for time_ns in LOOP.times_ns] == pytest.approx(trajectory.times_s)
    assert [place[:2] for place in LOOP.places_m] == [tuple(place) for place in trajectory.positions_m.tolist()]
    assert {place[2] for place in LOOP.places_m} == {ALTITUDE_M}
    assert LOOP.loop_ns == 2_000_000_000


def test_a_path_of_a_robot_with_motion_is_its_way_and_not_its_corners() -> None:
    plan = with_mass()
    moving = plan.trajectories[0]
    path = timed_path(route_of(moving, ALTITUDE_M))
    times_s = np.array(path.times_ns) / 1e9
    assert len(times_s) > len(moving.times_s)
    assert path.loop_ns == pytest.approx(moving.loop_start_s * 1e9, abs=1)
    np.testing.assert_allclose(
        np.array(path.places_m)[:, :2], moving.at(np.minimum(times_s, moving.times_s[-1])), atol=1e-6
    )
    assert {place[2] for place in path.places_m} == {ALTITUDE_M}


def test_a_robot_that_stays_ends_where_its_loop_begins() -> None:
    path = timed_path(routes_of(plan_of(staying("a")))[0])
    assert path.times_ns == (0, 4_000_000_000)
    assert path.places_m[-1] == (20, 60, ALTITUDE_M)
    assert path.loop_ns == 4_000_000_000


@pytest.mark.parametrize(
    ("held", "said"),
    [
        (LOOP, []),
        (replace(LOOP, places_m=((-10, 0.0009, ALTITUDE_M), *LOOP.places_m[1:])), []),
        (TimedPath(places_m=(), times_ns=(), loop_ns=0), ["it holds no route"]),
        (replace(LOOP, places_m=LOOP.places_m[:3], times_ns=LOOP.times_ns[:3]), ["it holds 3 poses of 7"]),
        (
            replace(LOOP, places_m=((-10, 0.01, ALTITUDE_M), *LOOP.places_m[1:])),
            ["pose 1: it holds (-10, 0.01, 25.0); (-10.0, 0.0, 25.0) was sent"],
        ),
        (
            replace(LOOP, places_m=((math.nan, 0, ALTITUDE_M), *LOOP.places_m[1:])),
            ["pose 1: it holds (nan, 0, 25.0); (-10.0, 0.0, 25.0) was sent"],
        ),
        (
            replace(LOOP, times_ns=(*LOOP.times_ns[:-1], 44_000_000_000)),
            ["pose 7: it holds 44 s; 45 s was sent"],
        ),
        (replace(LOOP, loop_ns=0), ["its loop begins at 0 s; 2 s was sent"]),
    ],
)
def test_differences_are_told_pose_by_pose(held: TimedPath, said: list[str]) -> None:
    assert list(path_differences(LOOP, held)) == said


def test_without_rclpy_no_link_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    with pytest.raises(RotaError, match=r"ROS 2 cannot be reached: .*rclpy.* or pip install ros-kilted-rclpy"):
        make_link("ros2", plan_of(staying("a")))

"""The messages of a plan as it is played, decoded by the MCAP project's reader of ROS 2."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.small_plans import patrolling, spreading
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore
from tests.files.two_robots import two_robots

from rota.errors import PlanError
from rota.files.ros.wire import Messages
from rota.model.plan import Plan, Trajectory
from rota.ros2.player import Player

BEGIN_NS = 1_777_636_800_000_000_000


@cache
def decoder(kind: str) -> Any:
    definition, _ = get_typestore(Stores.ROS2_KILTED).generate_msgdef(kind, ros_version=2)
    return DecoderFactory().decoder_for("cdr", Schema(id=1, name=kind, encoding="ros2msg", data=definition.encode()))


def decoded(messages: list[Messages]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for each in messages:
        assert each.size == len(each.data)
        found.setdefault(each.topic, []).append(decoder(each.kind)(each.data))
    return found


def at(stamp: Any) -> int:
    return int(stamp.sec * 10**9 + stamp.nanosec - BEGIN_NS)


def test_the_beginning_tells_ground_and_paths_with_times_of_the_clock() -> None:
    plan = two_robots(robots=("robot-1", "b"))
    first = decoded(Player(plan, speed=2.0).begin(BEGIN_NS))
    assert set(first) == {"/map", "/robot_1/path", "/b/path"}
    (path,) = first["/robot_1/path"]
    times_s = plan.trajectories[0].times_s
    assert [at(each.header.stamp) for each in path.poses] == np.round(times_s / 2 * 1e9).tolist()
    (ground,) = first["/map"]
    cells = np.array(ground.data).reshape(ground.info.height, ground.info.width)
    assert set(np.unique(cells)) == {-1, 0, 100}
    row, column = ((155 + 300) / ground.info.resolution, (155 + 300) / ground.info.resolution)
    assert cells[int(row), int(column)] == 100


def test_poses_go_round_the_loop_for_ever_at_the_plans_speed() -> None:
    plan = two_robots(robots=("a", "b"))
    player = Player(plan, speed=4.0)
    player.begin(BEGIN_NS)
    for rounds in (0, 1, 1000):
        time_s = 14 + rounds * plan.trajectories[0].loop_duration_s
        told = decoded(player.poses(time_s))
        (pose,) = told["/a/pose"]
        assert (pose.pose.position.x, pose.pose.position.y) == pytest.approx((50, 1 / 6), abs=1e-6)
        assert at(pose.header.stamp) == pytest.approx(time_s / 4 * 1e9, abs=1)
        (resting,) = told["/b/pose"]
        assert resting.pose.position.y == pytest.approx(200 - 110 / 30 * 14 if rounds == 0 else 90)
        assert {one.child_frame_id for each in told["/tf"] for one in each.transforms} == {"a/base_link", "b/base_link"}


def test_with_a_clock_of_its_own_stamps_are_the_plans_time() -> None:
    plan = two_robots(robots=("a", "b"))
    player = Player(plan, speed=4.0, own_clock=True)
    (path,) = decoded(player.begin(BEGIN_NS))["/a/path"]
    assert [at(each.header.stamp) for each in path.poses] == np.round(plan.trajectories[0].times_s * 1e9).tolist()
    (told,) = decoded(player.clock(14.0))["/clock"]
    (pose,) = decoded(player.poses(14.0))["/a/pose"]
    assert at(told.clock) == at(pose.header.stamp) == 14_000_000_000


def test_robots_that_never_move_are_told_once() -> None:
    plan = two_robots(robots=("a", "b"))
    standing = Trajectory(robot="b", times_s=[0], positions_m=[[7, 8]])
    player = Player(Plan(mission=plan.mission, trajectories=(plan.trajectories[0], standing)), speed=1.0)
    (static,) = decoded(player.begin(BEGIN_NS))["/tf_static"]
    assert [one.child_frame_id for one in static.transforms] == ["b/base_link"]
    assert static.transforms[0].transform.translation.x == 7
    told = decoded(player.poses(3.0))
    assert [one.child_frame_id for each in told["/tf"] for one in each.transforms] == ["a/base_link"]
    assert len(told["/b/pose"]) == 1


def test_ages_grow_in_percent_of_each_places_period_until_it_is_seen_again() -> None:
    player = Player(patrolling(), speed=1.0)
    player.begin(BEGIN_NS)

    def age_at(time_s: float, x_m: float, y_m: float) -> int:
        (grid,) = decoded(player.ages(time_s))["/time_since_seen"]
        cells = np.array(grid.data).reshape(grid.info.height, grid.info.width)
        corner, size = grid.info.origin.position, grid.info.resolution
        return int(cells[int((y_m - corner.y) / size), int((x_m - corner.x) / size)])

    # robot b, at (16, 3) with a square of 9 m, sees (19, 6.5) in the first second; the area's period is 50 s
    assert age_at(1.0, 19, 6.5) == 0
    assert age_at(1.0, 26, 11) == 100
    assert age_at(4.0, 13, 2) <= 100 * 4 / 50
    # nothing is asked at the desk but visits
    assert age_at(5.0, 26, 3) == -1
    assert age_at(6.0, 7, 6) == -1  # inside the block
    # robot a leaves the gate's corner (2.5, 1.5) behind, whose period is 12 s
    before = age_at(8.0, 2.5, 1.5)
    assert before > 0
    assert age_at(9.2, 2.5, 1.5) == pytest.approx(before + 10, abs=1)


def test_where_nothing_is_asked_ages_tell_what_is_in_range() -> None:
    plan = spreading()
    bare = replace(plan.mission, zones=(), moving_obstacles=(), obstacles=())
    nothing = Plan(mission=bare, trajectories=plan.trajectories)
    player = Player(nothing, speed=1.0)
    player.begin(BEGIN_NS)
    (grid,) = decoded(player.ages(5.0))["/time_since_seen"]
    share = np.mean(np.array(grid.data) == 0)
    assert set(grid.data) == {0, 100}
    # discs of 4 m round (2, 5), (5, 3.5) and (9, 2.5)
    assert 0.3 < share < 0.6


def test_footprints_are_outlines_of_what_is_seen() -> None:
    player = Player(patrolling(), speed=1.0)
    player.begin(BEGIN_NS)
    (told,) = decoded(player.footprints(0.0))["/footprints"]
    disc, square = told.markers
    assert [(marker.ns, marker.id, marker.type, marker.action) for marker in told.markers] == [
        ("a", 0, 5, 0),
        ("b", 0, 5, 0),
    ]
    assert {(round(p.x, 6), round(p.y, 6)) for p in square.points} == {
        (11.5, -1.5),
        (20.5, -1.5),
        (20.5, 7.5),
        (11.5, 7.5),
    }
    assert len(square.points) == 8
    # the block's corner nearest to robot a cuts its disc of 6 m
    away_m = np.array([math.hypot(p.x - 2, p.y - 2) for p in disc.points])
    assert away_m.max() == pytest.approx(6, abs=0.01)
    assert away_m.min() < 5.9
    assert disc.color != square.color


def test_robots_that_take_no_part_have_no_footprint() -> None:
    player = Player(spreading(), speed=1.0)
    player.begin(BEGIN_NS)
    (told,) = decoded(player.footprints(0.5))["/footprints"]
    assert [(marker.ns, marker.action, len(marker.points) > 0) for marker in told.markers] == [
        ("r0", 0, True),
        ("r1", 2, False),
        ("r2", 0, True),
    ]


def test_paths_beyond_the_clock_of_ros_are_refused() -> None:
    plan = two_robots(robots=("a", "b"))
    slow = Trajectory(robot="a", times_s=[0, 1e9], positions_m=[[0, 0], [9, 0]], loop_start_s=1e9)
    long = Plan(mission=plan.mission, trajectories=(slow,))
    with pytest.raises(PlanError, match="robot a: its path ends after the year 2038; play it faster"):
        Player(long, speed=1.0).begin(BEGIN_NS)
    assert Player(long, speed=100.0).begin(BEGIN_NS)


def test_the_layout_for_foxglove_shows_what_is_played() -> None:
    layout = json.loads((Path(__file__).parents[2] / "examples" / "foxglove-layout.json").read_text())
    panel = layout["configById"][layout["layout"]]
    player = Player(two_robots(robots=("robot-1", "robot-8")), speed=1.0)
    told = {each.topic for each in (*player.begin(BEGIN_NS), *player.poses(0), *player.footprints(0), *player.ages(0))}
    assert told - {"/tf"} <= set(panel["topics"])
    robots = {f"/robot_{k}/{what}" for k in range(1, 9) for what in ("path", "pose")}
    assert set(panel["topics"]) == robots | {"/map", "/footprints", "/time_since_seen", "/worst_gaps"}
    assert all(settings["visible"] for settings in panel["topics"].values())
    assert panel["followTf"] == "map"

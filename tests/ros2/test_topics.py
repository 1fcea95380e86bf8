"""Plans on topics and bags in SQLite as rclpy, the client library of ROS 2, reads them; on loopback."""

from __future__ import annotations

import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.files.two_robots import two_robots

from rota.cells.cell_map import cell_map_of
from rota.draw.sightings import Sightings
from rota.files.plan_file import write_plan
from rota.files.ros.bags import write_rosbag2
from rota.files.ros.grids import GroundGrid, percent_of_period
from rota.files.ros.poses import Motion
from rota.ros2.node import CHOSEN_BY, LOOPBACK_PROFILE
from rota.ros2.player import AGE_CELLS

pytestmark = pytest.mark.ros

PLAN = two_robots(robots=("robot-1", "b"))
SPEED = 5.0
PATIENCE_S = 60.0


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A domain that no other program on this machine is likely to use, and loopback."""
    pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    for name in CHOSEN_BY:
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def playing(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """`rota ros2` in a process of its own, once it says that it plays."""
    write_plan(PLAN, tmp_path / "plan.json")
    command = [sys.executable, "-m", "rota", "ros2", str(tmp_path / "plan.json"), "--speed", str(SPEED)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert "playing 2 robots on this machine" in process.stderr.readline()
    yield process
    process.kill()
    process.wait()
    process.stderr.close()


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Callable[[Any], bool]], dict[str, list[Any]]]]:
    """A subscriber to all topics; called with a condition, it listens until that holds of what it heard."""
    import rclpy
    from geometry_msgs.msg import PoseStamped
    from nav_msgs.msg import OccupancyGrid, Path as PathMessage
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from visualization_msgs.msg import MarkerArray

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("FASTDDS_DEFAULT_PROFILES_FILE", str(LOOPBACK_PROFILE))
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node("listener", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    found: dict[str, list[Any]] = defaultdict(list)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    for kind, quality, topics in (
        (PathMessage, latched, ("/robot_1/path", "/b/path")),
        (OccupancyGrid, latched, ("/map", "/time_since_seen")),
        (PoseStamped, 10, ("/robot_1/pose", "/b/pose")),
        (MarkerArray, 10, ("/footprints",)),
    ):
        for topic in topics:
            node.create_subscription(kind, topic, found[topic].append, quality)

    def listen(enough: Callable[[Any], bool]) -> dict[str, list[Any]]:
        end = time.monotonic() + PATIENCE_S
        while not enough(found):
            assert time.monotonic() < end, {topic: len(messages) for topic, messages in found.items()}
            executor.spin_once(timeout_sec=0.1)
        return found

    yield listen
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def ns(stamp: Any) -> int:
    return int(stamp.sec * 10**9 + stamp.nanosec)


def test_a_subscriber_that_comes_late_sees_the_plan_go_on(playing: Any, heard: Any) -> None:
    def enough(some: dict[str, list[Any]]) -> bool:
        """Twenty poses, all else, and a place that was seen and left: at the beginning there is none."""
        left = any(0 < age < 100 for ages in some["/time_since_seen"][-1:] for age in ages.data)
        return len(some["/robot_1/pose"]) >= 20 and all(some.values()) and left

    found = heard(enough)
    (path,) = found["/robot_1/path"]
    begin_ns = ns(path.header.stamp)
    told_s = np.array([ns(each.header.stamp) - begin_ns for each in path.poses]) * 1e-9 * SPEED
    robot = PLAN.trajectories[0]
    assert told_s == pytest.approx(robot.times_s, abs=1e-6)
    assert [(each.pose.position.x, each.pose.position.y) for each in path.poses] == [
        tuple(place) for place in robot.positions_m.tolist()
    ]
    for topic, trajectory in zip(("/robot_1/pose", "/b/pose"), PLAN, strict=True):
        poses = found[topic]
        times_s = np.array([(ns(each.header.stamp) - begin_ns) * 1e-9 * SPEED for each in poses])
        assert (np.diff(times_s) > 0).all()
        places_m = [(each.pose.position.x, each.pose.position.y, each.pose.position.z) for each in poses]
        np.testing.assert_allclose(places_m, Motion(trajectory).at(times_s)[0], atol=1e-5)
    told = found["/time_since_seen"][-1]
    ages, at_s = np.array(told.data), (ns(told.header.stamp) - begin_ns) * 1e-9 * SPEED
    sightings = Sightings(PLAN, cell_map_of(PLAN.mission, AGE_CELLS))
    sightings.advance(0.0, at_s)
    expected = percent_of_period(sightings.age_in_periods(at_s)).ravel()
    # the player looked at other moments in between
    assert np.mean(np.abs(ages - expected) <= 5) > 0.98
    assert ages.min() == -1
    assert ((ages > 0) & (ages < 100)).any()
    assert len(found["/footprints"][-1].markers) == 2
    assert 100 in found["/map"][0].data


def test_ctrl_c_ends_it_cleanly(playing: Any, heard: Any) -> None:
    heard(lambda some: bool(some["/b/pose"]))
    playing.send_signal(signal.SIGINT)
    _, said = playing.communicate(timeout=PATIENCE_S)
    assert playing.returncode == 130
    assert "stopping; Ctrl-C again ends at once" in said
    assert "Traceback" not in said
    assert "tf2_msgs is not installed: its messages are left out" in said


def test_it_listens_on_loopback_alone(playing: Any, heard: Any) -> None:
    heard(lambda some: bool(some["/b/pose"]))
    own = {os.readlink(file) for file in Path(f"/proc/{playing.pid}/fd").iterdir() if file.exists()}
    domain = int(os.environ["ROS_DOMAIN_ID"])
    bound = []
    for line in Path("/proc/net/udp").read_text().splitlines()[1:]:
        fields = line.split()
        if f"socket:[{fields[9]}]" in own:
            address, port = fields[1].split(":")
            bound.append((bytes.fromhex(address)[::-1], int(port, 16)))
    # the ports that DDS gives a domain (DDSI-RTPS 2.5, Section 9.6.2.3); on others it only sends
    listening = [(address, port) for address, port in bound if 7400 <= port - 250 * domain < 7650]
    assert listening
    assert {address for address, _ in listening} == {bytes([127, 0, 0, 1])}


def test_the_end_can_be_given(tmp_path: Path) -> None:
    write_plan(PLAN, tmp_path / "plan.json")
    command = [sys.executable, "-m", "rota", "ros2", str(tmp_path / "plan.json"), "--speed", "100", "--until", "60"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert (done.returncode, done.stdout) == (0, "")
    assert re.fullmatch(r"rota: playing 2 robots .*\nrota: tf2_msgs is not .*\n", done.stderr)


def test_rclpy_reads_what_bags_hold(tmp_path: Path) -> None:
    from geometry_msgs.msg import PoseStamped
    from nav_msgs.msg import OccupancyGrid, Path as PathMessage
    from rclpy.serialization import deserialize_message

    kinds = {"nav_msgs/msg/Path": PathMessage, "geometry_msgs/msg/PoseStamped": PoseStamped,
             "nav_msgs/msg/OccupancyGrid": OccupancyGrid}  # fmt: skip
    values = np.array([[-1, 0, 100]], np.int8)
    grid = GroundGrid(x_m=np.array([1.0, 2.0, 3.0]), y_m=np.array([5.0]), cell_m=1.0, values=values)
    start = datetime(2026, 5, 1, tzinfo=UTC)
    _, storage = write_rosbag2(PLAN, tmp_path / "bag", start, 30.0, {"/map": grid}, "sqlite3")
    with sqlite3.connect(storage) as base:
        rows = base.execute(
            "select name, type, data from messages join topics on topic_id = topics.id order by timestamp"
        ).fetchall()
    base.close()
    read = defaultdict(list)
    for topic, kind, data in rows:
        if kind in kinds:
            read[topic].append(deserialize_message(data, kinds[kind]))
    assert read["/map"][0].data.tolist() == [-1, 0, 100]
    (path,) = read["/b/path"]
    assert [ns(each.header.stamp) - ns(path.header.stamp) for each in path.poses] == [0, 30 * 10**9]
    assert [each.pose.position.y for each in path.poses] == [200, 90]
    poses = read["/robot_1/pose"]
    times_s = np.array([(ns(each.header.stamp) - ns(path.header.stamp)) * 1e-9 for each in poses])
    assert len(times_s) > 300
    places_m = [(each.pose.position.x, each.pose.position.y, each.pose.position.z) for each in poses]
    np.testing.assert_allclose(places_m, Motion(PLAN.trajectories[0]).at(times_s)[0], atol=1e-5)

"""Files for Nav2 as PyYAML reads them, which ROS 2's tools use, and as messages of the types that rosbags knows."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.typesys import Stores, get_typestore
from tests.files.two_robots import two_robots, with_heights

from rota.errors import PlanError
from rota.files.nav2_waypoints import write_nav2_waypoints, yaml_number
from rota.model.plan import Plan, Trajectory

STORE = get_typestore(Stores.ROS2_HUMBLE)


def written(plan: Plan, folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in write_nav2_waypoints(plan, folder / "nav2")}


def panel_poses(text: str) -> list[tuple[list[float], float]]:
    """Places and headings as Nav2's panel loads them: by its order, with the quaternion's w first."""
    loaded = []
    for number, (name, entry) in enumerate(yaml.safe_load(text)["waypoints"].items()):
        assert name == f"waypoint{number}"
        assert len(entry["pose"]) == 3
        w, x, y, z = entry["orientation"]
        assert all(isinstance(value, float) for value in (*entry["pose"], w, x, y, z))
        assert (x, y) == (0, 0)
        assert math.hypot(w, z) == pytest.approx(1)
        loaded.append((entry["pose"], 2 * math.atan2(z, w)))
    return loaded


def message(kind: str, values: dict[str, Any]) -> Any:
    """A message of ROS 2 of plain values, each field there and no other."""
    _, fields = STORE.fielddefs[kind]
    assert set(values) == {name for name, _ in fields}, kind
    made = {}
    for name, (node, detail) in fields:
        value = values[name]
        if isinstance(value, dict):
            value = message(detail, value)
        elif isinstance(value, list):
            value = [message(detail[0][1], item) for item in value]
        made[name] = value
        assert node is not None
    return STORE.types[kind](**made)


def test_the_panel_loads_approach_and_loop(tmp_path: Path) -> None:
    plan = two_robots(robots=("a", "b"))
    files = written(plan, tmp_path)
    assert list(files) == [f"{robot}.{what}.yaml" for robot in "ab" for what in ("approach", "loop", "path")]
    east = math.atan2(1 / 3, 100)
    assert panel_poses(files["a.approach.yaml"]) == [
        ([-20, 0, 0], 0),
        ([0, 0, 0], pytest.approx(east)),
    ]
    assert panel_poses(files["a.loop.yaml"]) == [
        ([100, 1 / 3, 0], pytest.approx(math.pi / 2)),
        ([100, 50, 0], pytest.approx(math.pi)),
        ([0, 50, 0], pytest.approx(-math.pi / 2)),
        ([0, 0, 0], pytest.approx(east)),
    ]
    loop = yaml.safe_load(files["a.loop.yaml"])["waypoints"].values()
    assert [entry["wait_s"] for entry in loop] == pytest.approx([4 / 3, 0, 0, 0])
    assert [entry["speed_m_s"] for entry in loop] == pytest.approx(
        [math.hypot(100, 1 / 3) / 20, (50 - 1 / 3) / (35.5 - 76 / 3), 5, 50 / 10.0004]
    )
    assert panel_poses(files["b.loop.yaml"]) == [([200, 90, 0], pytest.approx(-math.pi / 2))]
    assert [place for place, _ in panel_poses(files["b.approach.yaml"])] == [[200, 200, 0], [200, 90, 0]]


@pytest.mark.parametrize("plan", [two_robots(robots=("a", "b")), with_heights()], ids=["flat", "with heights"])
def test_the_path_is_a_message_of_ros(plan: Plan, tmp_path: Path) -> None:
    files = written(plan, tmp_path)
    for trajectory in plan:
        path = message("nav_msgs/msg/Path", yaml.safe_load(files[f"{trajectory.robot}.path.yaml"]))
        read = STORE.deserialize_cdr(STORE.serialize_cdr(path, "nav_msgs/msg/Path"), "nav_msgs/msg/Path")
        assert read.header.frame_id == "map"
        assert {pose.header.frame_id for pose in read.poses} == {"map"}
        stamps_s = [pose.header.stamp.sec + pose.header.stamp.nanosec * 1e-9 for pose in read.poses]
        np.testing.assert_allclose(stamps_s, trajectory.times_s, atol=1e-9)
        places = [[pose.pose.position.x, pose.pose.position.y, pose.pose.position.z] for pose in read.poses]
        assert np.array_equal(np.array(places)[:, : trajectory.positions_m.shape[1]], trajectory.positions_m)
        for pose, place, next_place in zip(read.poses, places, places[1:], strict=False):
            turned = pose.pose.orientation
            ahead = [2 * turned.w**2 - 1, 2 * turned.w * turned.z]
            step = np.subtract(next_place, place)[:2]
            assert np.dot(ahead, step) == pytest.approx(np.linalg.norm(step))


def test_headings_of_their_own_are_kept_and_digits_are_never_lost(tmp_path: Path) -> None:
    turning = Trajectory(
        robot="a", times_s=[0, 1e-7, 10], positions_m=[[1e-7, 0], [1e-7, 0], [5, 1e-300]], headings_rad=[3, -3, 0.5],
        loop_start_s=10,
    )  # fmt: skip
    files = written(replace(two_robots(robots=("a", "b")), trajectories=(turning,)), tmp_path)
    poses = yaml.safe_load(files["a.path.yaml"])["poses"]
    angles = [2 * math.atan2(p["pose"]["orientation"]["z"], p["pose"]["orientation"]["w"]) for p in poses]
    assert angles == pytest.approx([3, -3, 0.5])
    assert poses[2]["pose"]["position"] == {"x": 5.0, "y": 1e-300, "z": 0.0}
    assert poses[1]["header"]["stamp"] == {"sec": 0, "nanosec": 100}
    for value in (0.0, -1e-7, 1e16, 1.5e22, 1 / 3, 5e-324):
        read = yaml.safe_load(yaml_number(value))
        assert isinstance(read, float)
        assert read == value


def test_times_that_ros_cannot_count_are_refused(tmp_path: Path) -> None:
    late = Trajectory(robot="a", times_s=[0, 2.2e9], positions_m=[[0, 0], [5, 0]], loop_start_s=2.2e9)
    with pytest.raises(PlanError, match=r"robot a: its route takes 2\.2e\+09 s; ROS 2 counts at most 2147483647 s"):
        written(replace(two_robots(robots=("a", "b")), trajectories=(late,)), tmp_path)
    assert not (tmp_path / "nav2").exists()

"""Bags as others read them: MCAP by mcap-ros2-support, SQLite by sqlite3, ROS 1 record by record."""

from __future__ import annotations

import math
import sqlite3
import struct
from collections import defaultdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from ruamel.yaml import YAML
from shapely import box
from tests.files.two_robots import two_robots

from rota.errors import PlanError, RotaError
from rota.files.ros.bags import write_rosbag1, write_rosbag2
from rota.files.ros.grids import GroundGrid, free_space, percent_of_period, usual_cells
from rota.files.ros.poses import sampled_tracks
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory

START = datetime(2026, 5, 1, 12, tzinfo=UTC)
START_S = 1_777_636_800
SPAN_S = 70.0
PLAN = two_robots(robots=("robot-1", "b"))
GRID = GroundGrid(
    x_m=np.array([1.0, 3.0, 5.0]), y_m=np.array([10.0, 12.0]), cell_m=2.0,
    values=np.array([[-1, 0, 100], [7, 8, 9]], np.int8),
)  # fmt: skip
TOPICS = {"/map", "/robot_1/path", "/robot_1/pose", "/b/path", "/b/pose", "/tf"}


def bag2(folder: Path, plan: Plan = PLAN, **options: Any) -> tuple[Path, ...]:
    return write_rosbag2(plan, folder, START, SPAN_S, {"/map": GRID}, **options)


def by_topic(path: Path) -> dict[str, list[Any]]:
    found = defaultdict(list)
    with path.open("rb") as file:
        for _, channel, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            found[channel.topic].append(message)
    return found


def seconds(stamp: Any) -> float:
    return float(stamp.sec - START_S + stamp.nanosec * 1e-9)


def yaw_of(turn: Any) -> float:
    assert (turn.x, turn.y) == (0, 0)
    return 2 * math.atan2(turn.z, turn.w)


def test_an_mcap_reader_finds_paths_poses_transforms_and_the_grid(tmp_path: Path) -> None:
    _, storage = bag2(tmp_path / "night")
    assert storage == tmp_path / "night" / "night.mcap"
    found = by_topic(storage)
    assert set(found) == TOPICS
    for trajectory, track in zip(PLAN, sampled_tracks(PLAN, SPAN_S), strict=True):
        name = track.namespace
        (path,) = found[f"/{name}/path"]
        assert path.header.frame_id == "map"
        assert [seconds(each.header.stamp) for each in path.poses] == pytest.approx(trajectory.times_s, abs=1e-9)
        places = [[each.pose.position.x, each.pose.position.y] for each in path.poses]
        assert places == trajectory.positions_m.tolist()
        poses = found[f"/{name}/pose"]
        assert [seconds(each.header.stamp) for each in poses] == pytest.approx(track.times_s, abs=1e-9)
        places = [[each.pose.position.x, each.pose.position.y, each.pose.position.z] for each in poses]
        assert places == track.positions_m.tolist()
        assert [yaw_of(each.pose.orientation) for each in poses] == pytest.approx(track.yaws_rad)
        moved = [one for each in found["/tf"] for one in each.transforms
                 if one.child_frame_id == f"{name}/base_link"]  # fmt: skip
        assert [each.transform.translation.x for each in moved] == [each.pose.position.x for each in poses]
        assert [seconds(each.header.stamp) for each in moved] == [seconds(each.header.stamp) for each in poses]
    (grid,) = found["/map"]
    assert list(grid.data) == [-1, 0, 100, 7, 8, 9]
    info = grid.info
    assert (info.width, info.height, info.resolution, info.origin.position.x, info.origin.position.y) == (3, 2, 2, 0, 9)


def test_messages_come_in_time_and_the_metadata_counts_them(tmp_path: Path) -> None:
    metadata, storage = bag2(tmp_path / "night")
    with storage.open("rb") as file:
        logged = [message.log_time for *_, message in make_reader(file).iter_messages(log_time_order=False)]
    assert logged == sorted(logged)
    assert logged[0] == START_S * 10**9
    about = YAML(typ="safe").load(metadata)["rosbag2_bagfile_information"]
    assert about["storage_identifier"] == "mcap"
    assert about["relative_file_paths"] == ["night.mcap"]
    assert about["message_count"] == len(logged)
    assert about["duration"]["nanoseconds"] == SPAN_S * 1e9
    kept = {topic["topic_metadata"]["name"]: topic["topic_metadata"] for topic in about["topics_with_message_count"]}
    assert set(kept) == TOPICS
    (latched,) = YAML(typ="safe").load(kept["/map"]["offered_qos_profiles"])
    (passing,) = YAML(typ="safe").load(kept["/tf"]["offered_qos_profiles"])
    assert (latched["durability"], passing["durability"]) == (1, 2)  # rmw: transient local, volatile


def test_robots_that_never_move_are_static(tmp_path: Path) -> None:
    standing = Trajectory(robot="b", times_s=[0], positions_m=[[200, 200]])
    plan = Plan(mission=PLAN.mission, trajectories=(PLAN.trajectories[0], standing))
    found = by_topic(bag2(tmp_path / "bag", plan)[1])
    (told,) = found["/tf_static"]
    assert [each.child_frame_id for each in told.transforms] == ["b/base_link"]
    assert {each.child_frame_id for one in found["/tf"] for each in one.transforms} == {"robot_1/base_link"}


def test_sqlite_holds_the_same_messages(tmp_path: Path) -> None:
    _, mcap = bag2(tmp_path / "a")
    _, storage = bag2(tmp_path / "b", storage="sqlite3")
    assert storage.name == "b.db3"
    with sqlite3.connect(storage) as base:
        rows = base.execute(
            "select name, type, timestamp, data from messages join topics on topic_id = topics.id order by messages.id"
        ).fetchall()
        kinds = dict(base.execute("select topic_type, encoded_message_definition from message_definitions"))
    base.close()
    assert [row[2] for row in rows] == sorted(row[2] for row in rows)
    with mcap.open("rb") as file:
        others = [(each[1].topic, each[2].log_time, each[2].data) for each in make_reader(file).iter_messages()]
    assert sorted(others) == sorted((topic, stamp, data) for topic, _, stamp, data in rows)
    schema = Schema(id=1, name="nav_msgs/msg/Path", encoding="ros2msg", data=kinds["nav_msgs/msg/Path"].encode())
    (path,) = (row[3] for row in rows if row[0] == "/b/path")
    decode = DecoderFactory().decoder_for("cdr", schema)
    assert decode is not None
    assert [each.pose.position.x for each in decode(path).poses] == [200, 200]


def records(data: bytes) -> list[tuple[dict[str, bytes], bytes]]:
    """Header fields and data of each record of a bag of ROS 1, as its format 2.0 has them."""
    found, at = [], 0
    while at < len(data):
        (size,) = struct.unpack_from("<I", data, at)
        fields, inner, end = {}, at + 4, at + 4 + size
        while inner < end:
            (length,) = struct.unpack_from("<I", data, inner)
            name, _, value = data[inner + 4 : inner + 4 + length].partition(b"=")
            fields[name.decode()] = value
            inner += 4 + length
        (size,) = struct.unpack_from("<I", data, end)
        found.append((fields, data[end + 4 : end + 4 + size]))
        at = end + 4 + size
    return found


# as rosmsg md5 tells of ROS 1 Noetic
MD5 = {
    b"/tf": b"94810edda583a504dfda3829e70d7eec",
    b"/map": b"3381f2d731d4076ec5c71b0759edbe4e",
    b"/b/path": b"6227e2b7e9cce15051f669a5e197bbf7",
    b"/b/pose": b"d3812c3cbc69362b77dc0b19b345f8f5",
}


def test_a_bag_of_ros_1_has_its_records_in_order(tmp_path: Path) -> None:
    (path,) = write_rosbag1(PLAN, tmp_path / "night.bag", START, SPAN_S, {"/map": GRID})
    data = path.read_bytes()
    magic = b"#ROSBAG V2.0\n"
    assert data.startswith(magic)
    top = records(data[len(magic) :])
    assert top[0][0]["op"] == b"\x03"
    inside = [record for fields, chunk in top if fields["op"] == b"\x05" for record in records(chunk)]
    topics, sums = {}, {}
    for fields, body in (record for record in inside if record[0]["op"] == b"\x07"):
        topics[fields["conn"]] = fields["topic"]
        about = dict(line.partition(b"=")[::2] for line in split(body))
        sums[fields["topic"]] = about[b"md5sum"]
        assert about[b"latching"] == (b"0" if fields["topic"].endswith((b"pose", b"/tf")) else b"1")
    assert set(topics.values()) == {topic.encode() for topic in TOPICS}
    assert {topic: sums[topic] for topic in MD5} == MD5
    told = [(topics[fields["conn"]], fields["time"], body) for fields, body in inside if fields["op"] == b"\x02"]
    times = [struct.unpack("<II", time) for _, time, _ in told]
    assert times == sorted(times)
    assert times[0] == (START_S, 0)
    # header: number, time, frame; then the place
    places = [struct.unpack_from("<2d", body, 19) for topic, _, body in told if topic == b"/b/pose"]
    assert places[0] == (200, 200)
    assert places[-1] == (200, 90)
    (corner,) = (body for topic, _, body in told if topic == b"/map")
    assert corner[-6:] == bytes([255, 0, 100, 7, 8, 9])
    with Reader1(path) as reader:
        assert reader.message_count == len(told)


def split(body: bytes) -> list[bytes]:
    fields, at = [], 0
    while at < len(body):
        (length,) = struct.unpack_from("<I", body, at)
        fields.append(body[at + 4 : at + 4 + length])
        at += 4 + length
    return fields


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_the_same_plan_gives_the_same_bytes_over_an_older_bag(tmp_path: Path, storage: Any) -> None:
    (tmp_path / "one").mkdir()
    files = bag2(tmp_path / "one" / "bag", storage=storage)
    before = [file.read_bytes() for file in files]
    assert bag2(tmp_path / "one" / "bag", storage=storage) == files
    assert [file.read_bytes() for file in files] == before
    assert [entry.name for entry in (tmp_path / "one").iterdir()] == ["bag"]
    with Reader2(tmp_path / "one" / "bag") as reader:
        assert reader.message_count > 1000


def test_nothing_is_lost_and_nothing_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "thesis.txt").write_text("all of it")
    with pytest.raises(RotaError, match=r"bag: holds 'thesis.txt', which would be lost; name another folder"):
        bag2(tmp_path / "bag")
    assert (tmp_path / "bag" / "thesis.txt").read_text() == "all of it"

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("rosbags.rosbag2.storage_mcap.McapWriter.write", full)
    with pytest.raises(RotaError, match="other: cannot be written: No space left on device"):
        bag2(tmp_path / "other")
    monkeypatch.setattr("rosbags.rosbag1.Writer.write", full)
    with pytest.raises(RotaError, match=r"x.bag: cannot be written: No space left on device"):
        write_rosbag1(PLAN, tmp_path / "x.bag", START, SPAN_S, {})
    assert [entry.name for entry in tmp_path.iterdir()] == ["bag"]


def test_what_cannot_be_a_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="a plan without robots makes no bag"):
        bag2(tmp_path / "bag", Plan(mission=PLAN.mission, trajectories=()))
    with pytest.raises(RotaError, match=r"x.zip: '.zip' is no format for a bag of ROS 1"):
        write_rosbag1(PLAN, tmp_path / "x.zip", START, SPAN_S, {})
    assert list(tmp_path.iterdir()) == []


def test_free_space_is_what_robots_may_drive_on() -> None:
    obstacles = (
        Obstacle(shape=box(0.9, 1.9, 1.1, 2.1)),
        Obstacle(shape=box(3, 0, 4, 1), blocks="motion"),
        Obstacle(shape=box(0, 3, 1, 4), blocks="sight"),
    )
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    mission = Mission(
        name="m", area=box(0, 0, 4, 4).difference(box(3, 3, 4, 4)), obstacles=obstacles, period_s=9, fleet=fleet
    )
    centres = np.arange(-0.5, 4.5)
    grid = free_space(mission, centres, centres[1:], 1.0)
    assert grid.values[::-1].tolist() == [
        [-1, 0, 0, 0, -1],
        [-1, 100, 100, 0, 0],
        [-1, 100, 100, 0, 0],
        [-1, 0, 0, 0, 100],
    ]
    assert grid.corner_m == (-1, 0)


@pytest.mark.parametrize(
    ("width_m", "height_m", "cell_m", "shape"),
    [(12.32, 7, 0.05, (140, 247)), (50, 50, 0.05, (1000, 1000)), (51, 50, 0.1, (500, 510)), (330, 280, 0.5, (560, 660)),
     (0.01, 0.01, 0.05, (1, 1)), (100_000, 3000, 20, (150, 5000))],
)  # fmt: skip
def test_maps_have_cells_as_robots_maps_have(
    width_m: float, height_m: float, cell_m: float, shape: tuple[int, int]
) -> None:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    mission = Mission(name="m", area=box(3, -2, 3 + width_m, -2 + height_m), period_s=9, fleet=fleet)
    grid = free_space(mission, *usual_cells(mission))
    assert (grid.cell_m, grid.values.shape) == (cell_m, shape)
    assert grid.corner_m == pytest.approx((3, -2))


def test_shares_of_the_period_are_rounded_down_and_a_whole_one_is_100() -> None:
    periods = np.array([[0, 0.005, 0.999, 1, 1.0001], [7, np.inf, np.nan, 0.5, 0.29]])
    assert percent_of_period(periods).tolist() == [[0, 0, 99, 100, 100], [100, 100, -1, 50, 29]]

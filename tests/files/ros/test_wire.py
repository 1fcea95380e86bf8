"""Bytes made by the thousand beside those that the rosbags serialisers make of one message."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rota.errors import PlanError
from rota.files.ros.poses import Track
from rota.files.ros.wire import (
    Generation,
    Messages,
    path_message,
    pose_messages,
    stamps_ns,
    transform_messages,
)

START = datetime(2026, 5, 1, 12, 0, 0, 250_000, tzinfo=UTC)
START_NS = 1_777_636_800_250_000_000
TRANSFORMS = "tf2_msgs/msg/TFMessage"


def track(name: str, count: int = 3) -> Track:
    rng = np.random.default_rng(1)
    times_s = np.cumsum(rng.uniform(0, 1e3, count))
    return Track(
        namespace=name, times_s=times_s, positions_m=rng.normal(size=(count, 3)), yaws_rad=rng.uniform(-9, 9, count)
    )


class Library:
    """The same messages, built one by one of the library's types."""

    def __init__(self, generation: Generation) -> None:
        self.generation = generation
        self.types = get_typestore(Stores.ROS1_NOETIC if generation == 1 else Stores.ROS2_KILTED)
        if generation == 1:
            self.types.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def header(self, stamp: int) -> Any:
        time = self.make("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
        counted = {"seq": 0} if self.generation == 1 else {}
        return self.make("std_msgs/msg/Header", **counted, stamp=time, frame_id="map")

    def turned(self, yaw: float) -> Any:
        turn = dict(zip("xyzw", (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)), strict=True))
        return self.make("geometry_msgs/msg/Quaternion", **turn)

    def pose(self, stamp: int, place: Any, yaw: float) -> Any:
        point = self.make("geometry_msgs/msg/Point", **dict(zip("xyz", place, strict=True)))
        pose = self.make("geometry_msgs/msg/Pose", position=point, orientation=self.turned(yaw))
        return self.make("geometry_msgs/msg/PoseStamped", header=self.header(stamp), pose=pose)

    def transform(self, stamp: int, child: str, place: Any, yaw: float) -> Any:
        shift = self.make("geometry_msgs/msg/Vector3", **dict(zip("xyz", place, strict=True)))
        whole = self.make("geometry_msgs/msg/Transform", translation=shift, rotation=self.turned(yaw))
        kind = "geometry_msgs/msg/TransformStamped"
        one = self.make(kind, header=self.header(stamp), child_frame_id=child, transform=whole)
        return self.make(TRANSFORMS, transforms=[one])

    def written(self, kind: str, message: Any) -> bytes:
        write = self.types.serialize_ros1 if self.generation == 1 else self.types.serialize_cdr
        return bytes(write(message, kind))


def each(messages: Messages) -> list[bytes]:
    return [messages.data[k * messages.size : (k + 1) * messages.size] for k in range(len(messages.stamps_ns))]


@pytest.mark.parametrize("generation", [1, 2])
@pytest.mark.parametrize("name", ["a", "ab", "abc", "robot", "robot_1", "longer_names", "four_four"])
def test_poses_and_transforms_are_the_serialisers_bytes(generation: Generation, name: str) -> None:
    library, some = Library(generation), track(name)
    stamps = stamps_ns(some, START, generation)
    poses, transforms = pose_messages(some, stamps, generation), transform_messages(some, stamps, generation)
    rows = list(zip(stamps.tolist(), some.positions_m.tolist(), some.yaws_rad.tolist(), strict=True))
    assert each(poses) == [library.written(poses.kind, library.pose(*row)) for row in rows]
    child = f"{name}/base_link"
    wanted = [library.transform(stamp, child, place, yaw) for stamp, place, yaw in rows]
    assert each(transforms) == [library.written(TRANSFORMS, message) for message in wanted]


@pytest.mark.parametrize("generation", [1, 2])
@pytest.mark.parametrize("count", [1, 2, 50])
def test_a_path_is_the_serialisers_bytes(generation: Generation, count: int) -> None:
    library, some = Library(generation), track("a", count)
    stamps = stamps_ns(some, START, generation)
    path = path_message(some, stamps, generation)
    poses = [library.pose(*row) for row in zip(stamps.tolist(), some.positions_m, some.yaws_rad, strict=True)]
    wanted = library.make(path.kind, header=library.header(int(stamps[0])), poses=poses)
    assert path.data == library.written(path.kind, wanted)


def test_stamps_are_nanoseconds_of_the_start_and_the_time() -> None:
    some = Track(namespace="a", times_s=np.array([0, 1e-9, 1.5]), positions_m=np.zeros((3, 3)), yaws_rad=np.zeros(3))
    assert (stamps_ns(some, START, 2) - START_NS).tolist() == [0, 1, 1_500_000_000]


@pytest.mark.parametrize(
    ("start", "generation", "most"),
    [
        (datetime(1969, 12, 31, tzinfo=UTC), 1, 4294967295),
        (datetime(2038, 1, 19, 3, 14, 7, tzinfo=UTC), 2, 2147483647),
        (datetime(2106, 2, 7, 6, 28, 15, tzinfo=UTC), 1, 4294967295),
    ],
)
def test_instants_beyond_ros_are_refused(start: datetime, generation: Generation, most: int) -> None:
    with pytest.raises(PlanError, match=rf"robot a: its times run .* ROS {generation} counts from 0 to {most}"):
        stamps_ns(track("a"), start, generation)

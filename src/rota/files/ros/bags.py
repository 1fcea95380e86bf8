"""Plan -> a bag: rosbag2 (MCAP or SQLite) for ROS 2, or one file for ROS 1, as Foxglove and the ros tools play them.

For each robot ``/ROBOT/path`` (the approach and one round) and ``/ROBOT/pose``; for all of them ``/tf`` (map to
ROBOT/base_link; ``/tf_static`` for those that never move) and the grids.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from rota.errors import PlanError, RotaError
from rota.files.atomic_write import replaced_file, replaced_folder, require_suffix
from rota.files.ros.grids import GroundGrid
from rota.files.ros.library import grid_message, require_rosbags, types_of
from rota.files.ros.poses import own_tracks, sampled_tracks
from rota.files.ros.wire import (
    Generation,
    Messages,
    path_message,
    pose_messages,
    stamps_ns,
    transform_messages,
)
from rota.model.plan import Plan

if TYPE_CHECKING:
    from rosbags.interfaces import Qos
    from rosbags.typesys.store import Typestore

Storage = Literal["mcap", "sqlite3"]
SUFFIXES = {"mcap": ".mcap", "sqlite3": ".db3"}
METADATA = "metadata.yaml"
BAG2_VERSION: Literal[8] = 8  # as Iron writes it; older and newer readers take it


def write_rosbag2(
    plan: Plan,
    folder: str | os.PathLike[str],
    start: datetime,
    span_s: float,
    grids: Mapping[str, GroundGrid],
    storage: Storage = "mcap",
) -> tuple[Path, ...]:
    """Write a bag of ROS 2 into ``folder``, which appears whole or not at all; returns the paths of its files.

    start: the instant of the plan's time 0. span_s: how long poses go on. grids: by topic. A folder that is there is
    replaced where it is such a bag. Raises PlanError for instants that ROS has no seconds for and for names that ROS
    cannot tell apart, RotaError without the extra ``ros`` and when the folder cannot be written.
    """
    require_rosbags("a rosbag2")
    from rosbags.rosbag2 import StoragePlugin, Writer

    types = types_of(2)
    messages = _all_messages(plan, start, span_s, grids, 2, types)
    name = Path(os.path.realpath(folder)).name
    files = (METADATA, *(name + suffix for suffix in SUFFIXES.values()))
    with replaced_folder(folder, files.__contains__) as partial:
        plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
        try:
            with Writer(partial, version=BAG2_VERSION, storage_plugin=plugin) as bag:
                connections = {
                    each.topic: bag.add_connection(
                        each.topic, each.kind, typestore=types, offered_qos_profiles=[_quality(each.latched)]
                    )
                    for each in _one_a_topic(messages)
                }
                for topic, stamp, data in _in_time(messages):
                    bag.write(connections[topic], stamp, data)
        except sqlite3.Error as error:
            raise RotaError(f"{folder}: cannot be written: {error}") from error
    return Path(folder) / METADATA, Path(folder) / (name + SUFFIXES[storage])


def write_rosbag1(
    plan: Plan, path: str | os.PathLike[str], start: datetime, span_s: float, grids: Mapping[str, GroundGrid]
) -> tuple[Path, ...]:
    """Write a bag of ROS 1 to ``path`` (.bag), which appears whole or not at all; all else as ``write_rosbag2``."""
    require_rosbags("a rosbag1")
    from rosbags.rosbag1 import Writer

    require_suffix(path, (".bag",), "a bag of ROS 1")
    types = types_of(1)
    messages = _all_messages(plan, start, span_s, grids, 1, types)
    with replaced_file(path) as partial:
        if not partial.is_file():
            raise RotaError(f"{path}: is no file; a bag of ROS 1 needs one")
        partial.unlink()  # the writer wants to make it
        with Writer(partial) as bag:
            connections = {
                each.topic: bag.add_connection(each.topic, each.kind, typestore=types, latching=int(each.latched))
                for each in _one_a_topic(messages)
            }
            for topic, stamp, data in _in_time(messages):
                bag.write(connections[topic], stamp, data)
    return (Path(path),)


def _all_messages(
    plan: Plan,
    start: datetime,
    span_s: float,
    grids: Mapping[str, GroundGrid],
    generation: Generation,
    types: Typestore,
) -> list[Messages]:
    """What is told once first, then what is told again and again."""
    tracks, sampled = own_tracks(plan), sampled_tracks(plan, span_s)
    if not tracks:
        raise PlanError("a plan without robots makes no bag")
    begin = stamps_ns(tracks[0], start, generation)[:1]
    once = [grid_message(topic, grid, begin, generation, types) for topic, grid in grids.items()]
    once += [path_message(track, stamps_ns(track, start, generation), generation) for track in tracks]
    often = []
    for track in sampled:
        stamps = stamps_ns(track, start, generation)
        often += [pose_messages(track, stamps, generation), transform_messages(track, stamps, generation)]
    return [*once, *sorted(often, key=lambda each: not each.latched)]


def _one_a_topic(messages: Iterable[Messages]) -> Iterable[Messages]:
    """One of each topic's; those told often first, since the writers look for a message's connection in a list."""
    return {
        each.topic: each for each in sorted(messages, key=lambda each: (each.latched, each.topic != "/tf"))
    }.values()


def _in_time(messages: list[Messages]) -> Iterator[tuple[str, int, bytes]]:
    """Topic, stamp and bytes of all messages, in the order of time; at one time in the order of the list."""
    stamps = np.concatenate([each.stamps_ns for each in messages])
    which = np.repeat(np.arange(len(messages)), [len(each.stamps_ns) for each in messages])
    number = np.concatenate([np.arange(len(each.stamps_ns)) for each in messages])
    order = np.argsort(stamps, kind="stable")
    for stamp, k, n in zip(stamps[order].tolist(), which[order].tolist(), number[order].tolist(), strict=True):
        each = messages[k]
        yield each.topic, stamp, each.data[n * each.size : (n + 1) * each.size]


def _quality(latched: bool) -> Qos:
    """Reliable; what is latched is kept for who comes later."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    never = QosTime(9223372036, 854775807)  # as recorders write it
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=never,
        lifespan=never,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=never,
        avoid_ros_namespace_conventions=False,
    )

"""Bags of ROS, written and read again by the rosbags library: the timed points of each robot's Path."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Literal

import numpy as np

from rota.files.executed.timed_files import drive_at
from rota.files.ros.bags import write_rosbag1, write_rosbag2
from rota.files.ros.library import require_rosbags, types_of
from rota.files.ros.names import namespaces
from rota.files.ros.wire import NS_PER_S
from rota.files.timed_places import START
from rota.model.plan import Plan, Trajectory
from rota.routes.constant_speeds import plan_at_constant_speeds


def as_bag(plan: Plan, storage: Literal["mcap", "sqlite3", "rosbag1"]) -> tuple[Trajectory, ...]:
    """All robots as the Path of each in a bag has them, the loop again and again.

    The bag has no grids and no poses beyond the start, which tell nothing of routes that the Path does not. Raises
    RotaError without the extra ``ros``, PlanError as the export does.
    """
    require_rosbags("a bag of ROS")
    from rosbags.highlevel import AnyReader

    begin_s, made, plan = int(START.timestamp()), [], plan_at_constant_speeds(plan)
    paths: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="rota.") as folder:
        path = Path(folder) / ("plan.bag" if storage == "rosbag1" else "plan")
        if storage == "rosbag1":
            write_rosbag1(plan, path, START, 0.0, {})
        else:
            write_rosbag2(plan, path, START, 0.0, {}, storage)
        with AnyReader([path], default_typestore=types_of(1 if storage == "rosbag1" else 2)) as bag:
            for connection, _, data in bag.messages([each for each in bag.connections if "/path" in each.topic]):
                paths[connection.topic] = bag.deserialize(data, connection.msgtype)
    for name, trajectory in zip(namespaces(plan), plan, strict=True):
        poses = paths[f"/{name}/path"].poses
        stamps = [each.header.stamp for each in poses]
        times_s = np.array([stamp.sec - begin_s + stamp.nanosec / NS_PER_S for stamp in stamps])
        places_m = np.array([[at.x, at.y, at.z] for at in (each.pose.position for each in poses)])
        made.append(drive_at(plan, trajectory, times_s, places_m, trajectory.loop_index))
    return tuple(made)

"""Robots on ROS 2 for the tests of the link, made with rclpy alone: they hold routes, answer services, and can fail."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any


@dataclass
class ScriptedRobot:
    """``fault``: it refuses (to start), holds half (of a route), is deaf (no service), or poses have nan or a frame.

    drives: whether it drives its route once it is started, by the stamps of its poses.
    """

    namespace: str
    at_m: tuple[float, float, float]
    fault: str = ""
    kind: str = "drone"
    drives: bool = False
    started_s: float = math.inf
    orders: list[str] = field(default_factory=list)
    route: Any = None

    def join(self, node: Any) -> None:
        from nav_msgs.msg import Path
        from nav_msgs.srv import GetPlan
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        self.node = node
        self.route = Path()
        node.create_subscription(Path, f"/{self.namespace}/route", self.take_route, 10)
        if self.fault != "deaf":
            node.create_service(GetPlan, f"/{self.namespace}/get_route", self.tell_route)
            for order in ("start", "pause", "come_home", "clear_route"):
                node.create_service(Trigger, f"/{self.namespace}/{order}", self.doing(order))
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_publisher(String, f"/{self.namespace}/robot_type", latched).publish(String(data=self.kind))
        self.publishers = self.made_publishers()
        self.mode = "idle"
        node.create_timer(0.05, self.tell)

    def made_publishers(self) -> dict[str, Any]:
        from geometry_msgs.msg import PoseStamped
        from sensor_msgs.msg import BatteryState
        from std_msgs.msg import String

        kinds = {"pose": PoseStamped, "battery_state": BatteryState, "mode": String}
        return {name: self.node.create_publisher(kind, f"/{self.namespace}/{name}", 10) for name, kind in kinds.items()}

    def take_route(self, path: Any) -> None:
        if self.fault == "half":
            path.poses = path.poses[: len(path.poses) // 2]
        self.route = path

    def tell_route(self, _: Any, answer: Any) -> Any:
        answer.plan = self.route
        return answer

    def doing(self, order: str) -> Any:
        from nav_msgs.msg import Path

        modes = {"start": "running", "pause": "paused", "come_home": "returning", "clear_route": "idle"}

        def do(_: Any, answer: Any) -> Any:
            self.orders.append(order)
            answer.success = not (self.fault == "refuses" and order == "start")
            answer.message = "" if answer.success else "the emergency stop is pressed"
            if answer.success:
                self.mode = modes[order]
                self.started_s = time.monotonic() if order == "start" else math.inf
            if order == "clear_route":
                self.route = Path()
            return answer

        return do

    def drive(self) -> None:
        """Be where the route has it, straight between its poses and round its loop for ever."""
        passed_s = time.monotonic() - self.started_s
        poses = [
            (pose.header.stamp.sec + pose.header.stamp.nanosec / 1e9, pose.pose.position) for pose in self.route.poses
        ]
        stamp = self.route.header.stamp
        begins_s, ends_s = stamp.sec + stamp.nanosec / 1e9, poses[-1][0]
        if passed_s > ends_s > begins_s:
            passed_s = begins_s + (passed_s - ends_s) % (ends_s - begins_s)
        passed_s = min(passed_s, ends_s)
        for (t0, a), (t1, b) in pairwise(poses):
            if t0 <= passed_s <= t1 and t1 > t0:
                u = (passed_s - t0) / (t1 - t0)
                self.at_m = (a.x + u * (b.x - a.x), a.y + u * (b.y - a.y), a.z + u * (b.z - a.z))

    def tell(self) -> None:
        from geometry_msgs.msg import PoseStamped
        from sensor_msgs.msg import BatteryState
        from std_msgs.msg import String

        if self.drives and self.started_s < math.inf:
            self.drive()
        pose = PoseStamped()
        pose.header.frame_id = "odom" if self.fault == "frame" else "map"
        pose.header.stamp = self.node.get_clock().now().to_msg()
        x, y, z = self.at_m
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = (
            (math.nan if self.fault == "nan" else x),
            y,
            z,
        )
        self.publishers["battery_state"].publish(BatteryState(percentage=0.75))
        self.publishers["mode"].publish(String(data=self.mode))
        self.publishers["pose"].publish(pose)


@contextmanager
def on_air(*robots: ScriptedRobot) -> Iterator[None]:
    """The robots in a node of their own, in a thread."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node("scripted_robots", context=context)
    for robot in robots:
        robot.join(node)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            return

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join(10)
        node.destroy_node()
        rclpy.shutdown(context=context)

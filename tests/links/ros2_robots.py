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

Place = tuple[float, ...]


@dataclass
class ScriptedRobot:
    """``fault``: it refuses (to start), holds half (of a route), is deaf (no service), or poses have nan or a frame.

    drives: whether it drives its route once it is started, by the stamps of its poses. top_m_s: how fast it drives at
    most, and that it heeds its schedule; 0: it does not listen to one. endurance_s: how long its battery lasts while it
    drives; it fills in recharge_s while the robot is idle, and it is idle where its route ends. docks: it serves dock
    and undock, and charges only while it is docked.
    """

    namespace: str
    at_m: Place
    fault: str = ""
    kind: str = "drone"
    drives: bool = False
    top_m_s: float = 0.0
    endurance_s: float = math.inf
    recharge_s: float = math.inf
    battery: float = 0.75
    docks: bool = False
    docked: bool = False
    started_s: float = math.inf
    orders: list[str] = field(default_factory=list)
    route: Any = None
    schedule: list[Any] = field(default_factory=list)
    schedules: int = 0

    def join(self, node: Any) -> None:
        from nav_msgs.msg import Path
        from nav_msgs.srv import GetPlan
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        self.node = node
        self.route = Path()
        node.create_subscription(Path, f"/{self.namespace}/route", self.take_route, 10)
        if self.top_m_s:
            node.create_subscription(Path, f"/{self.namespace}/schedule", self.take_schedule, 1)
        if self.fault != "deaf":
            node.create_service(GetPlan, f"/{self.namespace}/get_route", self.tell_route)
            for order in ("start", "pause", "come_home", "clear_route", *(("dock", "undock") if self.docks else ())):
                node.create_service(Trigger, f"/{self.namespace}/{order}", self.doing(order))
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_publisher(String, f"/{self.namespace}/robot_type", latched).publish(String(data=self.kind))
        self.publishers = self.made_publishers()
        self.mode = "idle"
        self.told_s = self.now_s()
        node.create_timer(0.05, self.tell)

    def now_s(self) -> float:
        return float(self.node.get_clock().now().nanoseconds) / 1e9

    def take_schedule(self, path: Any) -> None:
        """Places with their instants, from where it is on the schedule's first legs."""
        self.schedules += 1
        self.schedule = timed_places(path)

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
            if order in ("dock", "undock"):
                self.docked, answer.success = order == "dock", True
                return answer
            answer.success = not (self.fault == "refuses" and order == "start")
            answer.message = "" if answer.success else "the emergency stop is pressed"
            if answer.success:
                self.mode = modes[order]
                self.started_s = self.now_s() if order == "start" else math.inf
                # until it is told more it drives by its route
                self.schedule = [(self.started_s + at_s, place) for at_s, place in timed_places(self.route)]
            if order == "clear_route":
                self.route = Path()
            return answer

        return do

    def drive(self) -> None:
        """Be where the route has it, straight between its poses and round its loop for ever."""
        passed_s = self.now_s() - self.started_s
        poses = timed_places(self.route)
        stamp = self.route.header.stamp
        begins_s, ends_s = stamp.sec + stamp.nanosec / 1e9, poses[-1][0]
        if passed_s > ends_s > begins_s:
            passed_s = begins_s + (passed_s - ends_s) % (ends_s - begins_s)
        self.at_m = place_at(poses, passed_s)

    def drive_in_time(self, now_s: float, passed_s: float) -> None:
        """On along its schedule, no faster than it can, to where that has it now."""
        left_m = self.top_m_s * passed_s
        while len(self.schedule) > 1 and left_m > 0:
            (t0, _), (t1, end_m) = self.schedule[:2]
            if now_s <= t0:
                return
            goal_m = end_m if now_s >= t1 else place_at(self.schedule[:2], now_s)
            far_m = math.dist(self.at_m, goal_m)
            share = min(1.0, left_m / far_m) if far_m > 0 else 1.0
            self.at_m = tuple(a + share * (b - a) for a, b in zip(self.at_m, goal_m, strict=True))
            left_m -= far_m
            if goal_m is not end_m or left_m < 0:
                return
            self.schedule.pop(0)

    def use_battery(self, passed_s: float) -> None:
        """Less while it drives; more while it is idle, and docked where it docks."""
        if self.mode == "running":
            self.battery = max(self.battery - passed_s / self.endurance_s, 0.0)
            begins, ends = self.route.header.stamp, self.route.poses[-1].header.stamp
            if self.endurance_s < math.inf and begins == ends and self.at_m == timed_places(self.route)[-1][1]:
                self.mode = "idle"
        elif self.docked or not self.docks:
            self.battery = min(self.battery + passed_s / self.recharge_s, 1.0)

    def tell(self) -> None:
        from geometry_msgs.msg import PoseStamped
        from sensor_msgs.msg import BatteryState
        from std_msgs.msg import String

        now_s, passed_s = self.now_s(), self.now_s() - self.told_s
        self.told_s = now_s
        if self.drives and self.started_s < math.inf:
            if self.top_m_s:
                self.drive_in_time(now_s, passed_s)
            else:
                self.drive()
        self.use_battery(passed_s)
        pose = PoseStamped()
        pose.header.frame_id = "odom" if self.fault == "frame" else "map"
        pose.header.stamp = self.node.get_clock().now().to_msg()
        x, y, z = self.at_m
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = (
            (math.nan if self.fault == "nan" else x),
            y,
            z,
        )
        self.publishers["battery_state"].publish(BatteryState(percentage=self.battery))
        self.publishers["mode"].publish(String(data=self.mode))
        self.publishers["pose"].publish(pose)


def timed_places(path: Any) -> list[tuple[float, Place]]:
    stamps = (pose.header.stamp for pose in path.poses)
    places = (pose.pose.position for pose in path.poses)
    return [(at.sec + at.nanosec / 1e9, (to.x, to.y, to.z)) for at, to in zip(stamps, places, strict=True)]


def place_at(timed: list[tuple[float, Place]], at_s: float) -> Place:
    """Straight between places, and at the last one for ever."""
    for (t0, a), (t1, b) in pairwise(timed):
        if t0 <= at_s < t1:
            u = (at_s - t0) / (t1 - t0)
            return a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2])
    return timed[-1][1]


class Simulator:
    """Publishes /clock, which goes ``times`` as fast as time."""

    def __init__(self, node: Any, times: float) -> None:
        from rosgraph_msgs.msg import Clock

        self.began_s, self.times = time.monotonic(), times
        self.clock = node.create_publisher(Clock, "/clock", 1)
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.go_on, daemon=True)
        self.thread.start()

    def go_on(self) -> None:
        from rosgraph_msgs.msg import Clock

        while not self.ended.wait(0.005):
            message = Clock()
            now_ns = round((1000.0 + (time.monotonic() - self.began_s) * self.times) * 1e9)
            message.clock.sec, message.clock.nanosec = divmod(now_ns, 10**9)
            self.clock.publish(message)

    def end(self) -> None:
        self.ended.set()
        self.thread.join(10)


@contextmanager
def on_air(*robots: ScriptedRobot, times: float = 0.0) -> Iterator[None]:
    """The robots in a node of their own, in a thread. times: how fast /clock goes that they heed; 0: there is none."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from rclpy.parameter import Parameter

    context = Context()
    rclpy.init(context=context)
    simulated = [Parameter("use_sim_time", value=times > 0)]
    node = rclpy.create_node("scripted_robots", context=context, parameter_overrides=simulated)
    simulator = Simulator(node, times) if times else None
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
        if simulator is not None:
            simulator.end()
        executor.shutdown()
        thread.join(10)
        node.destroy_node()
        rclpy.shutdown(context=context)

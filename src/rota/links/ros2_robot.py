"""One robot's topics and services on ROS 2, all in its namespace."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rota.errors import LinkError
from rota.files.ros.names import MAP_FRAME
from rota.links.inbox import MODES
from rota.links.ros2_route import NS_PER_S, TimedPath

ASK_AGAIN_S = 0.05
MOST_WORDS = 200  # of what a robot says, in messages
ORDERS = ("start", "pause", "come_home", "clear_route", "dock", "undock")

# what arrives on a topic, and what to do with it, in the event loop
Deliver = Callable[[Callable[[], None]], None]


@dataclass(kw_only=True)
class Ros2Robot:
    """What is known of a robot, and what it is reached by. ``battery``: None where it does not say."""

    name: str
    namespace: str
    kind: str | None = None
    battery: float | None = None
    mode: str | None = None
    heard: asyncio.Event = field(default_factory=asyncio.Event)
    _route: Any = None
    _schedule: Any = None
    _held: Any = None
    _orders: dict[str, Any] = field(default_factory=dict)

    def connect(self, node: Any, deliver: Deliver, on_pose: Callable[[Ros2Robot, Any], None], reject: Any) -> None:
        """Subscribe and make clients; ``on_pose`` gets each PoseStamped, ``reject`` is called for what is malformed."""
        from geometry_msgs.msg import PoseStamped
        from nav_msgs.msg import Path
        from nav_msgs.srv import GetPlan
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import BatteryState
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        def listen(kind: Any, topic: str, take: Callable[[Any], None], quality: Any = 10) -> None:
            def arrived(message: Any) -> None:
                deliver(partial(take, message))

            node.create_subscription(kind, f"/{self.namespace}/{topic}", arrived, quality)

        def take_battery(message: Any) -> None:
            share = float(message.percentage)
            if not math.isnan(share) and not 0 <= share <= 1:
                reject("out of range", f"{self.name}, battery {share:g}")
                return
            self.battery = None if math.isnan(share) else share

        def take_mode(message: Any) -> None:
            if message.data not in MODES:
                reject("malformed", f"{self.name}, mode {message.data!r:.40}")
                return
            self.mode = message.data

        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        listen(PoseStamped, "pose", partial(on_pose, self))
        listen(BatteryState, "battery_state", take_battery)
        listen(String, "mode", take_mode)
        listen(String, "robot_type", lambda message: setattr(self, "kind", message.data[:MOST_WORDS]), latched)
        self._route = node.create_publisher(Path, f"/{self.namespace}/route", 10)
        self._schedule = node.create_publisher(Path, f"/{self.namespace}/schedule", 1)
        self._held = node.create_client(GetPlan, f"/{self.namespace}/get_route")
        self._orders = {order: node.create_client(Trigger, f"/{self.namespace}/{order}") for order in ORDERS}

    async def order(self, what: str, limit_s: float) -> None:
        """Call one of the services ``ORDERS``; LinkError where it is refused, or not answered in time."""
        from std_srvs.srv import Trigger

        answer = await self._called(self._orders[what], Trigger.Request(), what, limit_s)
        if not answer.success:
            said = answer.message[:MOST_WORDS] or "it gives no reason"
            raise LinkError(f"robot {self.name}: {what}: it refuses: {said}")

    def serves(self, what: str) -> bool:
        """Whether the robot serves one of ``ORDERS``, as far as is known by now."""
        return bool(self._orders[what].service_is_ready())

    async def hold(self, path: TimedPath, limit_s: float) -> None:
        """Publish a route, and wait until the robot holds one; LinkError where it does not in time."""
        try:
            async with asyncio.timeout(limit_s):
                while self._route.get_subscription_count() == 0:
                    await asyncio.sleep(ASK_AGAIN_S)
        except TimeoutError:
            raise LinkError(f"robot {self.name}: nobody listens on /{self.namespace}/route") from None
        self._route.publish(_message(path))
        try:
            async with asyncio.timeout(limit_s):
                while not (await self.held(limit_s)).places_m:
                    await asyncio.sleep(ASK_AGAIN_S)
        except TimeoutError:
            raise LinkError(f"robot {self.name}: it holds no route {limit_s:g} s after it was sent") from None

    def be_in_time(self, path: TimedPath) -> None:
        """Publish a schedule; LinkError where nobody listens to it."""
        if self._schedule.get_subscription_count() == 0:
            raise LinkError(f"robot {self.name}: nobody listens on /{self.namespace}/schedule")
        self._schedule.publish(_message(path))

    async def held(self, limit_s: float) -> TimedPath:
        """The route that the robot says it holds."""
        from nav_msgs.srv import GetPlan

        plan = (await self._called(self._held, GetPlan.Request(), "get_route", limit_s)).plan
        return TimedPath(
            places_m=tuple((pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) for pose in plan.poses),
            times_ns=tuple(nanoseconds(pose.header.stamp) for pose in plan.poses),
            loop_ns=nanoseconds(plan.header.stamp),
        )

    async def _called(self, client: Any, request: Any, what: str, limit_s: float) -> Any:
        """A service's answer; LinkError where none comes in time."""
        loop = asyncio.get_running_loop()
        answered, future = asyncio.Event(), None
        try:
            async with asyncio.timeout(limit_s):
                while not client.service_is_ready():
                    await asyncio.sleep(ASK_AGAIN_S)
                future = client.call_async(request)
                future.add_done_callback(lambda _: loop.call_soon_threadsafe(answered.set))
                await answered.wait()
        except TimeoutError:
            if future is not None:
                client.remove_pending_request(future)
            raise LinkError(f"robot {self.name}: {what}: no answer within {limit_s:g} s") from None
        assert future is not None
        return future.result()


def _message(path: TimedPath) -> Any:
    """A nav_msgs/Path with a stamp for each pose, and its own."""
    from geometry_msgs.msg import PoseStamped
    from nav_msgs.msg import Path

    message = Path()
    message.header.frame_id = MAP_FRAME
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(path.loop_ns, NS_PER_S)
    for (x, y, z), time_ns in zip(path.places_m, path.times_ns, strict=True):
        pose = PoseStamped()
        pose.header.frame_id = MAP_FRAME
        pose.header.stamp.sec, pose.header.stamp.nanosec = divmod(time_ns, NS_PER_S)
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, z
        message.poses.append(pose)
    return message


def nanoseconds(stamp: Any) -> int:
    """A time of ROS in nanoseconds."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)

"""Robots on ROS 2, by rclpy and standard messages: each in a namespace of its own, on the frame ``map``.

A robot publishes ``pose`` (geometry_msgs/PoseStamped), and may publish ``battery_state`` (sensor_msgs/BatteryState),
``mode`` (std_msgs/String, a mode of ``rota.links.link``) and ``robot_type`` (std_msgs/String, latched). It takes
``route`` (nav_msgs/Path, see ``rota.links.ros2_route``) and, to keep in phase, ``schedule`` (nav_msgs/Path, see
``rota.links.ros2_schedule``), and serves ``get_route`` (nav_msgs/GetPlan: the route that it
holds) and ``start``, ``pause``, ``come_home`` and ``clear_route`` (std_srvs/Trigger). A robot that charges gets a route
for each flight; on its charger it holds none. It may serve ``dock`` and ``undock`` (std_srvs/Trigger).
"""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from rota.errors import LinkError
from rota.files.ros.names import MAP_FRAME, namespaces
from rota.links.link import Order
from rota.links.reporting import RealTimeLink
from rota.links.ros2_clock import NodeClock
from rota.links.ros2_robot import ASK_AGAIN_S, Ros2Robot, nanoseconds
from rota.links.ros2_route import NS_PER_S, path_differences, timed_path
from rota.links.ros2_schedule import Schedule
from rota.model.plan import Plan
from rota.model.planner_settings import Settings, setting
from rota.ros2.node import opened_node, require_rclpy, stay_on_loopback
from rota.routes.moments import route_after
from rota.routes.route import Route

MOST_PENDING = 10_000  # messages that have arrived and that nobody has looked at yet
SENDS_S = 3.0  # how long a route may take to be sent before its robot leaves its charger
WAITS_S = 0.05  # between two looks at a clock that may be a simulator's


@dataclass(frozen=True, kw_only=True)
class Ros2Settings(Settings):
    """Settings of the link ``ros2``."""

    place: ClassVar[str] = "ros2"
    network: bool = setting(False, "robots on other machines, too, and not on this one alone")
    robot_type: str = setting("", "what robots must say on robot_type; empty: anything or nothing")
    wait_s: float = setting(10.0, "how long a robot may take to be heard", above=0, most=3600)
    answer_s: float = setting(5.0, "how long it may take to answer", above=0, most=3600)
    dock_s: float = setting(120.0, "how long it may take to dock or undock, where it serves that", above=0, most=3600)
    undock_s: float = setting(0.0, "how long before it leaves its charger it is told to undock", least=0, most=3600)
    start_time: str = setting("", "when the plan started, in ISO 8601; empty: when this link opened")
    use_sim_time: bool = setting(False, "time is that of /clock, as a simulator publishes it")


SETTINGS = Ros2Settings


def link_to(plan: Plan, settings: Ros2Settings) -> Ros2Link:
    """A robot for each of the plan's, in the namespace that its name gives."""
    require_rclpy("geometry_msgs.msg", "nav_msgs.srv", "sensor_msgs.msg", "std_msgs.msg", "std_srvs.srv")
    names = dict(zip((trajectory.robot for trajectory in plan), namespaces(plan), strict=True))
    return Ros2Link(plan, names, settings)


class Ros2Link(RealTimeLink):
    """A Link to robots on ROS 2; see the module."""

    takes_fences = False
    drives_along = False
    keeps_phase = True
    relieves = True

    def __init__(self, plan: Plan, names: dict[str, str], settings: Ros2Settings) -> None:
        super().__init__(names, plan.mission.area.bounds, settings.start_time, "ros2.start_time")
        if settings.use_sim_time:
            self._clock = NodeClock(settings.start_time, "ros2.start_time")
        self._settings = settings
        self._top_m_s = {name: plan.mission.fleet.robot(name).speed_m_s for name in names}
        self._schedules: dict[str, Schedule] = {}
        self._altitude_m = plan.mission.fleet.altitude_m
        self._ways = {way.robot: way for way in plan if way.charges}
        self.lead_s = SENDS_S + settings.undock_s
        # of those that charge the moment at which the flight began that they were sent on; None: they are on a charger
        self._left_s: dict[str, float | None] = {}
        self._robots = {robot: Ros2Robot(name=robot, namespace=namespace) for robot, namespace in names.items()}
        self._closing = ExitStack()
        self._pending = 0

    # ------------------------------------------------------------ the node

    async def open(self) -> None:
        """Raises LinkError for robots that are not heard or of another type."""
        if not self._settings.network:
            stay_on_loopback()
        node = self._closing.enter_context(opened_node("rota_link", use_sim_time=self._settings.use_sim_time))
        self._closing.callback(_spinning(node))
        if isinstance(self._clock, NodeClock):
            await self._clock.follow(node, self._settings.wait_s)
        self._clock.begin()
        deliver = partial(self._deliver, asyncio.get_running_loop())
        for robot in self._robots.values():
            robot.connect(node, deliver, self._take_pose, self._inbox.reject)
        robots = self._robots.values()
        with suppress(TimeoutError):
            async with asyncio.timeout(self._settings.wait_s):
                await asyncio.gather(*(robot.heard.wait() for robot in robots))
        silent = {robot.name for robot in robots if not robot.heard.is_set()}
        limit_s = self._settings.wait_s
        faults = [f"robot {robot.name}: not heard within {limit_s:g} s" for robot in robots if robot.name in silent]
        faults += await self._of_another_type(self._settings.robot_type, silent)
        if faults:
            raise LinkError("\n".join(faults))

    async def _of_another_type(self, needed: str, silent: set[str]) -> list[str]:
        """A sentence for each robot that is heard and does not say in time that it is of the type needed."""
        others = [robot for robot in self._robots.values() if needed and robot.name not in silent]
        with suppress(TimeoutError):
            async with asyncio.timeout(self._settings.answer_s):
                while any(robot.kind is None for robot in others):
                    await asyncio.sleep(ASK_AGAIN_S)
        return [
            f"robot {robot.name}: it is {robot.kind or 'of no type that it tells'}; {needed} is needed"
            for robot in others
            if robot.kind != needed
        ]

    def _deliver(self, loop: asyncio.AbstractEventLoop, take: Callable[[], None]) -> None:
        """Let the event loop take what has arrived in the thread of rclpy; drop it where too much waits."""
        if self._pending >= MOST_PENDING or loop.is_closed():
            self._inbox.reject("too many", "messages that nobody has looked at")
            return
        self._pending += 1
        loop.call_soon_threadsafe(self._take, take)

    def _take(self, take: Callable[[], None]) -> None:
        self._pending -= 1
        take()

    def _take_pose(self, robot: Ros2Robot, message: Any) -> None:
        """Offer a pose as a report; a stamp of 0 is no time, and the report is then of now."""
        if message.header.frame_id != MAP_FRAME:
            self._inbox.reject("malformed", f"{robot.name}, a pose in the frame {message.header.frame_id!r:.40}")
            return
        stamp_ns, now_s = nanoseconds(message.header.stamp), self._clock.now_s()
        place = message.pose.position
        # one that charges has no route between its flights, and is where its plan has it all the same
        mode = "running" if robot.mode == "idle" and robot.name in self._ways else robot.mode
        taken = self._inbox.offer(
            now_s=now_s,
            robot=robot.name,
            time_s=self._clock.of_unix_s(stamp_ns / NS_PER_S) if stamp_ns else now_s,
            position_m=(place.x, place.y, place.z),
            battery=robot.battery,
            mode=mode,
        )
        if taken:
            robot.heard.set()

    async def close(self) -> None:
        """The node is gone; robots go on with what they do."""
        self._inbox.close()
        await asyncio.to_thread(self._closing.close)

    # ------------------------------------------------------------ orders

    async def send_route(self, route: Route) -> None:
        """Take away what the robot holds, publish its route, and wait until it holds one.

        Of one that charges that is its first flight; one that is on its charger gets none.
        """
        robot, first = self._robot(route.robot), self._first(route)
        if first is None:
            await robot.order("clear_route", self._settings.answer_s)
        else:
            await self._give(robot, first, 0.0)

    def _first(self, route: Route) -> Route | None:
        """What a robot drives first: of one that charges a flight, and on its charger nothing."""
        way = self._ways.get(route.robot)
        return route if way is None else route_after(way, 0.0, self._altitude_m)

    async def _give(self, robot: Ros2Robot, route: Route, begins_s: float) -> None:
        """Publish a route in the place of what the robot holds. begins_s: the plan's time at which it begins."""
        path = timed_path(route)
        await robot.order("clear_route", self._settings.answer_s)
        await robot.hold(path, self._settings.answer_s)
        # one that has mass cannot hurry: its legs are as fast as its motors allow
        top_m_s = self._top_m_s[robot.name] if route.planned is None else None
        self._schedules[robot.name] = Schedule(path, top_m_s, begins_s)

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Ask the robot for its route, and compare it pose by pose."""
        first, held = self._first(route), await self._robot(route.robot).held(self._settings.answer_s)
        if first is None:
            return ("it holds a route on its charger",) if held.places_m else ()
        return path_differences(timed_path(first), held)

    async def clear_route(self, robot: str) -> None:
        """Call the robot's clear_route."""
        self._schedules.pop(robot, None)
        await self._robot(robot).order("clear_route", self._settings.answer_s)

    async def start(self, robot: str) -> None:
        """Call the robot's start; one that begins on its charger stays there until ``keep`` has it leave."""
        if robot not in self._ways or robot in self._schedules:
            await self._robot(robot).order("start", self._settings.answer_s)

    async def keep(self, order: Order) -> None:
        """By a schedule, which takes the place of the one before; nothing for a robot whose route is not from here.

        One that comes to its charger loses its route and docks; one that is to leave undocks and gets that of its next
        flight, which it starts when it is time. Robots that serve neither stand on their chargers.
        """
        robot, schedule = self._robot(order.robot), self._schedules.get(order.robot)
        if order.dock is None:
            if schedule is not None:
                robot.be_in_time(schedule.ahead(order, self.time_s, self.begun_s))
        elif not order.dock.leaves:
            await self._stay(robot)
        elif self._left_s.get(order.robot) != order.dock.plan_s:
            await self._leave(robot, order.dock.plan_s, order.behind_s)

    async def _stay(self, robot: Ros2Robot) -> None:
        """Take the robot's route away, and let it dock, once."""
        if self._left_s.get(robot.name, math.inf) is None:
            return
        self._schedules.pop(robot.name, None)
        await robot.order("clear_route", self._settings.answer_s)
        if robot.serves("dock"):
            await robot.order("dock", self._settings.dock_s)
        self._left_s[robot.name] = None

    async def _leave(self, robot: Ros2Robot, plan_s: float, behind_s: float) -> None:
        """Let the robot undock, hold the route of its flight, and start when the clock of all says so."""
        route = route_after(self._ways[robot.name], plan_s, self._altitude_m)
        if route is None:
            return
        if robot.serves("undock"):
            await robot.order("undock", self._settings.dock_s)
        await self._give(robot, route, plan_s)
        if found := path_differences(timed_path(route), await robot.held(self._settings.answer_s)):
            raise LinkError(f"robot {robot.name}: read back, the route of its flight is another one: {found[0]}")
        while (left_s := plan_s + behind_s - self.time_s) > 0:
            await asyncio.sleep(min(left_s, WAITS_S))
        await robot.order("start", self._settings.answer_s)
        self._left_s[robot.name] = plan_s

    async def pause(self, robot: str) -> None:
        """Call the robot's pause."""
        await self._robot(robot).order("pause", self._settings.answer_s)

    async def come_home(self, robot: str) -> None:
        """Call the robot's come_home."""
        self._schedules.pop(robot, None)
        await self._robot(robot).order("come_home", self._settings.answer_s)

    def _robot(self, name: str) -> Ros2Robot:
        if name not in self._robots:
            raise LinkError(f"robot {name}: nothing is known of it; the link reaches {', '.join(self._robots)}")
        return self._robots[name]


def _spinning(node: Any) -> Callable[[], None]:
    """Let a thread look after the node's messages; returns what ends that."""
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            return

    thread = threading.Thread(target=spin, name="rota ROS 2", daemon=True)
    thread.start()

    def end() -> None:
        executor.shutdown()
        thread.join(5.0)

    return end

"""The ROS 2 link with robots of rclpy, on loopback."""

from __future__ import annotations

import asyncio
import math
import os
from collections.abc import Awaitable, Callable
from contextlib import aclosing
from dataclasses import replace
from typing import Any

import pytest
from tests.links.fleets import ALTITUDE_M, dropped, loop_of, plan_of, routes_of, staying
from tests.links.ros2_robots import ScriptedRobot, on_air
from tests.relieved import relieved, with_battery

from rota.errors import LinkError
from rota.links.link_settings import make_link
from rota.links.sending import first_reports, routes_for, send_all, start_all
from rota.live.driving import Driving
from rota.live.keeping import Keeping
from rota.live.notices import Notice
from rota.live.ready import make_ready
from rota.live.watch import Watch
from rota.model.plan import Plan
from rota.ros2.node import CHOSEN_BY, stay_on_loopback

pytestmark = pytest.mark.ros

PLAN = plan_of(loop_of("robot-1", 0.0), staying("b"))


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A domain that no other program on this machine is likely to use, and loopback."""
    pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    for name in CHOSEN_BY:
        monkeypatch.setenv(name, "")
    stay_on_loopback()


def two(**faults: str) -> tuple[ScriptedRobot, ScriptedRobot]:
    first = ScriptedRobot("robot_1", (-10.0, 0.0, 0.5), fault=faults.get("first", ""))
    return first, ScriptedRobot("b", (0.0, 60.0, 0.0), fault=faults.get("second", ""))


def with_link(robots: Any, what: Callable[[Any], Awaitable[Any]], **given: Any) -> Any:
    """What comes of doing something with a link to the robots."""
    settings = {"answer_s": 10, **given}

    async def run() -> Any:
        link = make_link("ros2", PLAN, [f"{key}={value}" for key, value in settings.items()])
        try:
            await link.open()
            return await what(link)
        finally:
            await link.close()

    with on_air(*robots):
        return asyncio.run(run())


def test_routes_arrive_whole_and_orders_are_obeyed() -> None:
    robots = two()

    async def drive(link: Any) -> None:
        routes = routes_for(PLAN, link)
        assert link.robots == ("robot-1", "b")
        await send_all(link, routes)
        await start_all(link, routes)
        await link.pause("b")
        modes: dict[str, str] = {}
        async with aclosing(link.reports()) as reports, asyncio.timeout(30):
            async for report in reports:
                modes[report.robot] = report.mode
                if modes == {"robot-1": "running", "b": "paused"}:
                    break
        latest = link.latest("robot-1")
        assert latest.position_m == (-10.0, 0.0, 0.5)
        assert latest.battery == pytest.approx(0.75)
        assert latest.mode == "running"
        assert -1 < latest.time_s < 60
        await link.come_home("b")
        assert not link.rejections

    with_link(robots, drive)
    held = robots[0].route
    assert held.header.frame_id == "map"
    assert [pose.header.stamp.sec for pose in held.poses] == [0, 2, 17, 20, 25, 40, 45]
    assert held.header.stamp.sec == 2
    places = [(pose.pose.position.x, pose.pose.position.y) for pose in held.poses]
    assert places == [tuple(place) for place in PLAN.trajectories[0].positions_m.tolist()]
    assert [robot.orders for robot in robots] == [
        ["clear_route", "start"],
        ["clear_route", "start", "pause", "come_home"],
    ]


def test_half_a_route_leaves_nobody_with_any() -> None:
    robots = two(second="half")

    async def send(link: Any) -> None:
        with pytest.raises(LinkError, match="robot b: read back, its route is another one: it holds 1 poses of 2"):
            await send_all(link, routes_of(PLAN))

    with_link(robots, send)
    assert [len(robot.route.poses) for robot in robots] == [0, 0]


def test_a_refusal_is_told_and_the_others_are_called_home() -> None:
    robots = two(second="refuses")

    async def go(link: Any) -> None:
        await send_all(link, routes_of(PLAN))
        with pytest.raises(LinkError, match="robot b: start: it refuses: the emergency stop is pressed"):
            await start_all(link, routes_of(PLAN))

    with_link(robots, go)
    assert robots[0].orders[-1] == "come_home"


def test_silence_is_an_error_that_names_the_robot() -> None:
    async def send(link: Any) -> None:
        with pytest.raises(LinkError, match="robot b: clear_route: no answer within 1 s"):
            await send_all(link, routes_of(PLAN))

    with_link(two(second="deaf"), send, answer_s=1)
    with pytest.raises(LinkError, match=r"^robot b: not heard within 1.5 s$"):
        with_link(two()[:1], send, wait_s=1.5)


def test_robots_of_another_type_are_refused() -> None:
    async def nothing(link: Any) -> None:
        assert link.robots

    with pytest.raises(LinkError, match="robot robot-1: it is drone; boat is needed\nrobot b: it is drone; boat"):
        with_link(two(), nothing, robot_type="boat")
    with_link(two(), nothing, robot_type="drone")


@pytest.mark.parametrize(
    ("top_m_s", "late_s", "told"),
    [
        (3.95, 0.8, []),  # 0.5 s a round are lost on its legs, and made up where it waits for 3 s
        (3.5, 2.5, ["b cannot keep up", "all go on at 0.9"]),  # a round lasts 45.7 s at least, of 43 s
    ],
)
def test_robots_keep_to_the_stamps_and_all_wait_for_one_that_cannot(
    top_m_s: float, late_s: float, told: list[str]
) -> None:
    """By the time of a simulator, of which five seconds go by in one."""
    plan = plan_of(loop_of("a", 0.0), loop_of("b", 200.0))
    robots = [
        ScriptedRobot("a", (-10.0, 0.0, 25.0), drives=True, top_m_s=8.0),
        ScriptedRobot("b", (190.0, 0.0, 25.0), drives=True, top_m_s=top_m_s),
    ]
    link, keeping = make_link("ros2", plan, ["use_sim_time=true", "answer_s=10"]), Keeping(plan, {})
    watch, said = Watch(plan), list[str]()

    async def drive() -> None:
        try:
            await link.open()
            await send_all(link, routes_for(plan, link))
            await start_all(link, routes_for(plan, link))
            driving = Driving(link, watch, keeping, None, lambda notice: said.append(notice.text))
            await driving.drive(until_s=70.0, should_stop=lambda: False)
        finally:
            await link.close()

    with on_air(*robots, times=5.0):
        asyncio.run(drive())
    a, b = (keeping.late_s(robot) for robot in watch.state().robots)
    assert min(robot.schedules for robot in robots) > 40
    assert abs(a) < 0.8
    assert abs(b) < late_s
    # its wait lets it keep up again for a while
    assert bool(said) == bool(told)
    assert all(text in said[0] for text in told)


def relay() -> Plan:
    """Three robots that take turns of 40 s at a square, at 4 m/s; batteries last for 100 s and fill in 50."""
    plan = with_battery(relieved(3), endurance_s=100.0, recharge_s=50.0, reserve_s=10.0)
    ways = tuple(
        replace(
            way,
            times_s=way.times_s / 4,
            loop_start_s=way.loop_start_s / 4,
            charges=tuple(replace(stay, from_s=stay.from_s / 4, until_s=stay.until_s / 4) for stay in way.charges),
        )
        for way in plan
    )
    mission = replace(plan.mission, fleet=replace(plan.mission.fleet, speed_m_s=4.0, altitude_m=ALTITUDE_M))
    return replace(plan, mission=mission, trajectories=ways)


def test_robots_that_charge_fly_their_flights_and_hold_their_posts_for_a_late_relief() -> None:
    """The second robot has no battery for its flight yet when it is to relieve the first one."""
    make_ready()
    plan, told, at = relay(), list[Notice](), dict[str, list[tuple[float, float, float]]]()
    places = [way.positions_m[0].tolist() for way in plan]
    robots = [
        ScriptedRobot(
            way.robot.replace("-", "_"), (x, y, ALTITUDE_M), drives=True, top_m_s=5.0,
            endurance_s=100.0, recharge_s=100.0, battery=0.05 if way.robot == "robot-2" else 1.0, docks=True,
        )
        for way, (x, y) in zip(plan, places, strict=True)
    ]  # fmt: skip
    link, watch = make_link("ros2", plan, ["use_sim_time=true", "answer_s=60"]), Watch(plan)

    async def drive() -> None:
        try:
            await link.open()
            await first_reports(link, link.robots)
            await send_all(link, routes_for(plan, link))
            await start_all(link, routes_for(plan, link))
            driving = Driving(link, watch, Keeping(plan, {}), None, told.append)
            await driving.drive(until_s=62.0, should_stop=lambda: False)
        finally:
            await link.close()

    take: Any = link._inbox.offer

    def note(**heard: Any) -> bool:
        at.setdefault(heard["robot"], []).append((heard["time_s"], *heard["position_m"][:2]))
        return bool(take(**heard))

    link._inbox.offer = note
    with on_air(*robots, times=5.0):
        asyncio.run(drive())
    of_reliefs = ("lands", "relief late", "does not wait", "relief comes", "takes off")
    assert [(each.kind, each.about) for each in told if each.kind in of_reliefs] == [
        ("lands", "robot-3"),
        ("relief late", "robot-2"),
        ("relief comes", "robot-2"),
        ("takes off", "robot-2"),
        ("lands", "robot-1"),
    ]
    late_s, comes_s = (next(each.time_s for each in told if each.kind == kind) for kind in of_reliefs[1:4:2])
    assert (late_s, comes_s - late_s) == (pytest.approx(40.0, abs=4.0), pytest.approx(10.0, abs=6.0))
    held = [place_m for at_s, *place_m in at["robot-1"] if late_s + 3 < at_s < comes_s - 0.5]
    assert len(held) > 5
    assert math.dist(held[0], (0, 0)) > 5
    assert max(math.dist(held[0], place_m) for place_m in held) < 0.3
    assert [robot.orders for robot in robots] == [
        ["clear_route", "start", "clear_route", "dock"],
        ["clear_route", "clear_route", "dock", "undock", "clear_route", "start"],
        ["clear_route", "start", "clear_route", "dock"],
    ]


@pytest.mark.parametrize("fault", ["nan", "frame"])
def test_poses_that_cannot_be_used_are_dropped_and_counted(fault: str) -> None:
    counted = []

    async def run() -> None:
        link = make_link("ros2", PLAN, ["wait_s=2"])
        try:
            with pytest.raises(LinkError, match=r"^robot b: not heard within 2 s$"):
                await link.open()
            counted.append(dropped(link))
        finally:
            await link.close()

    with on_air(*two(second=fault)):
        asyncio.run(run())
    assert counted[0] > 3

"""What robots on ROS 2 that charge are told on their chargers, and when they leave them; without a middleware."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest
from tests.links.fleets import routes_of
from tests.relieved import SQUARE_M, TURN_S, relieved

from rota.errors import LinkError
from rota.links.link import Dock, Order
from rota.links.ros2 import Ros2Link, Ros2Settings
from rota.links.ros2_robot import Ros2Robot
from rota.links.ros2_route import TimedPath

PLAN = relieved(3)  # robot-1 leaves its charger at once, robot-2 is on it, robot-3 is under way
NOTHING = TimedPath(places_m=(), times_ns=(), loop_ns=0)


@dataclass
class Robot:
    """It keeps what it is told. served: what it serves beside what all do. halves: routes lose their second half."""

    name: str
    served: tuple[str, ...] = ()
    halves: bool = False
    route: TimedPath = NOTHING
    told: list[str] = field(default_factory=list)
    schedules: list[TimedPath] = field(default_factory=list)

    def serves(self, what: str) -> bool:
        return what in self.served

    async def order(self, what: str, limit_s: float) -> None:
        assert limit_s == (120.0 if what in ("dock", "undock") else 5.0)
        self.told.append(what)
        if what == "clear_route":
            self.route = NOTHING

    async def hold(self, path: TimedPath, _: float) -> None:
        half = len(path.places_m) // 2 if self.halves else len(path.places_m)
        self.route = TimedPath(places_m=path.places_m[:half], times_ns=path.times_ns[:half], loop_ns=path.loop_ns)
        self.told.append("route")

    async def held(self, _: float) -> TimedPath:
        return self.route

    def be_in_time(self, path: TimedPath) -> None:
        self.schedules.append(path)


def linked(served: tuple[str, ...] = (), *, halves: bool = False, **given: Any) -> tuple[Any, list[Robot]]:
    """A link to such robots, whose plan begins now."""
    link: Any = Ros2Link(PLAN, {way.robot: way.robot for way in PLAN}, Ros2Settings(**given))
    link._robots = {way.robot: Robot(way.robot, served, halves) for way in PLAN}
    link.begin()
    return link, list(link._robots.values())


def docked(*, leaves: bool, plan_s: float, behind_s: float = 0.0) -> Order:
    return Order(robot="robot-2", late_s=0.0, behind_s=behind_s, rate=1.0, dock=Dock(leaves=leaves, plan_s=plan_s))


def test_each_holds_its_first_flight_and_one_on_its_charger_none() -> None:
    link, robots = linked()

    async def send() -> None:
        for route in routes_of(PLAN):
            await link.send_route(route)
            assert await link.differences(route) == ()
            await link.start(route.robot)

    asyncio.run(send())
    assert [robot.told for robot in robots] == [
        ["clear_route", "route", "start"],
        ["clear_route"],
        ["clear_route", "route", "start"],
    ]
    first, second, third = (robot.route for robot in robots)
    assert [place[:2] for place in first.places_m] == [(0, 0), *SQUARE_M, *SQUARE_M[1:], (0, 0)]
    assert first.loop_ns == first.times_ns[-1] == 180 * 10**9  # it stays where it lands
    assert second == NOTHING
    assert third.places_m[0][:2] == (10, 10)
    robots[1].route = first
    assert asyncio.run(link.differences(routes_of(PLAN)[1])) == ("it holds a route on its charger",)


def test_a_flight_is_sent_before_it_is_due_and_started_when_it_is() -> None:
    link, (_, robot, _) = linked()
    assert link.relieves
    assert link.lead_s == 3.0

    async def leave() -> float:
        await link.keep(docked(leaves=False, plan_s=TURN_S))
        await link.keep(docked(leaves=False, plan_s=TURN_S))
        assert robot.told == ["clear_route"]
        behind_s = link.time_s + 0.4 - TURN_S  # it is due in 0.4 s by the clock of all
        leaving = asyncio.create_task(link.keep(docked(leaves=True, plan_s=TURN_S, behind_s=behind_s)))
        await asyncio.sleep(0.2)
        assert robot.told[1:] == ["clear_route", "route"]
        await leaving
        left_s = link.time_s - behind_s
        await link.keep(docked(leaves=True, plan_s=TURN_S, behind_s=behind_s))
        assert robot.told[3:] == ["start"]  # once is enough
        # 20 s later it holds its post, is told of its flight alone, and comes back to its charger
        await link.keep(Order(robot="robot-2", late_s=0.0, behind_s=link.time_s - TURN_S - 20, rate=0.0))
        await link.keep(docked(leaves=False, plan_s=4 * TURN_S))
        return float(left_s)

    assert asyncio.run(leave()) == pytest.approx(TURN_S, abs=0.15)
    (schedule,) = robot.schedules
    assert [place[:2] for place in schedule.places_m] == [pytest.approx((20, 0), abs=0.01)] * 2
    assert robot.told[4:] == ["clear_route"]
    assert robot.route == NOTHING


def test_one_that_is_idle_between_its_flights_does_what_its_plan_asks_for() -> None:
    link, _ = linked()
    place, now = SimpleNamespace(x=0.0, y=0.0, z=0.0), SimpleNamespace(sec=0, nanosec=0)
    pose = SimpleNamespace(header=SimpleNamespace(frame_id="map", stamp=now), pose=SimpleNamespace(position=place))
    link._take_pose(Ros2Robot(name="robot-2", namespace="robot_2", mode="idle"), pose)
    link._take_pose(Ros2Robot(name="robot-3", namespace="robot_3", mode="paused"), pose)
    assert [link.latest(name).mode for name in ("robot-2", "robot-3")] == ["running", "paused"]


def test_who_serves_that_docks_and_undocks() -> None:
    link, (_, robot, _) = linked(("dock", "undock"), undock_s=20.0)
    assert link.lead_s == 23.0

    async def go() -> None:
        await link.keep(docked(leaves=False, plan_s=TURN_S))
        await link.keep(docked(leaves=True, plan_s=TURN_S, behind_s=-TURN_S))
        await link.keep(docked(leaves=False, plan_s=4 * TURN_S))

    asyncio.run(go())
    assert robot.told == ["clear_route", "dock", "undock", "clear_route", "route", "start", "clear_route", "dock"]


def test_a_flight_that_did_not_arrive_whole_is_not_started_and_is_sent_again() -> None:
    link, (_, robot, _) = linked(halves=True)
    order = docked(leaves=True, plan_s=TURN_S, behind_s=-TURN_S)
    with pytest.raises(LinkError, match="robot robot-2: read back, the route of its flight is another one: it holds 5"):
        asyncio.run(link.keep(order))
    assert "start" not in robot.told
    robot.halves = False
    asyncio.run(link.keep(order))
    assert robot.told[-1] == "start"

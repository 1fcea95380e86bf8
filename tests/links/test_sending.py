"""A fleet gets all of its routes or none, whatever single robots do."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from typing import Any

import pytest
from tests.links.fleets import routes_of, three

from rota.errors import LinkError
from rota.links.link import Report
from rota.links.link_settings import make_link
from rota.links.sending import command_all, first_reports, routes_for, send_all, start_all
from rota.routes.route import Route


class Recording:
    """A simulated link whose orders are noted, and some of which fail as told."""

    def __init__(self, *failing: tuple[str, str], given: tuple[str, ...] = ()) -> None:
        self.inner: Any = make_link("simulated", three(), ["clock=0", *given])
        self.failing = set(failing)
        self.held: set[str] = set()
        self.orders: list[tuple[str, str]] = []
        self.waits: asyncio.Event | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def note(self, order: str, robot: str) -> None:
        self.orders.append((order, robot))
        if (order, robot) in self.failing:
            raise LinkError(f"robot {robot}: it does not {order}")

    async def send_route(self, route: Route) -> None:
        self.held.add(route.robot)  # if only a part of it
        if self.waits is not None and route.robot == "c":
            self.waits.set()
            await asyncio.Event().wait()
        self.note("send", route.robot)
        await self.inner.send_route(route)

    async def clear_route(self, robot: str) -> None:
        self.note("clear", robot)
        self.held.discard(robot)
        await self.inner.clear_route(robot)

    async def start(self, robot: str) -> None:
        self.note("start", robot)
        await self.inner.start(robot)

    async def come_home(self, robot: str) -> None:
        self.note("come_home", robot)
        await self.inner.come_home(robot)


def test_all_routes_are_sent_with_their_fences() -> None:
    link: Any = Recording()
    plan = three()
    routes = routes_for(plan, link)
    assert [route.robot for route in routes] == ["a", "b", "c"]
    assert routes[0].fence is not None
    assert routes[0].fence.inside_m == ((900, -300), (900, 300), (-300, 300), (-300, -300))
    assert [len(ring) for ring in routes[0].fence.outside_m] == [4]
    asyncio.run(send_all(link, routes))
    assert link.held == {"a", "b", "c"}
    link.inner.takes_fences = False
    assert [route.fence for route in routes_for(plan, link)] == [None] * 3


@pytest.mark.parametrize(
    ("failing", "given", "told"),
    [
        ([("send", "b")], [], ["robot b: it does not send"]),
        ([("send", "a"), ("send", "c")], [], ["robot a: it does not send", "robot c: it does not send"]),
        ([], ["faults=a:half"], ["robot a: read back, its route is another one: it holds 3 stops of 5"]),
        ([], ["faults=c:silent"], ["robot c: it has not answered for 5 s"]),
    ],
)
def test_no_robot_holds_a_route_after_a_failure(failing: Any, given: list[str], told: list[str]) -> None:
    link: Any = Recording(*failing, given=tuple(given))
    with pytest.raises(LinkError) as caught:
        asyncio.run(send_all(link, routes_of(three())))
    assert str(caught.value).splitlines()[: len(told)] == told
    cleared = {robot for order, robot in link.orders if order == "clear"}
    assert cleared == {"a", "b", "c"}
    if "silent" in str(given):
        assert "it may still hold its route or a part of it" in str(caught.value)
    else:
        assert link.held == set()
        assert str(caught.value).endswith("no robot holds a route: all were cleared")


def test_a_robot_that_cannot_be_cleared_is_named() -> None:
    link: Any = Recording(("send", "a"), ("clear", "b"))
    with pytest.raises(LinkError) as caught:
        asyncio.run(send_all(link, routes_of(three())))
    assert str(caught.value).splitlines()[1] == (
        "robot b: it does not clear; it may still hold its route or a part of it: clear it before it is armed"
    )
    assert link.held == {"b"}


def test_an_interrupt_while_sending_clears_all_routes() -> None:
    async def interrupted() -> set[str]:
        link: Any = Recording()
        link.waits = asyncio.Event()
        task = asyncio.create_task(send_all(link, routes_of(three())))
        await asyncio.wait_for(link.waits.wait(), 10)
        assert link.held == {"a", "b", "c"}
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return set(link.held)

    assert asyncio.run(interrupted()) == set()


def test_robots_that_the_link_does_not_reach_are_named_before_anything_is_sent() -> None:
    link: Any = Recording()
    routes = routes_of(three())
    link.inner = make_link("simulated", type(three())(mission=three().mission, trajectories=three().trajectories[:1]))
    with pytest.raises(LinkError, match=r"robot b: the link does not reach it\nrobot c: the link does not reach it"):
        asyncio.run(send_all(link, routes))
    assert link.orders == []


def test_where_one_does_not_start_the_others_come_home() -> None:
    link: Any = Recording(("start", "b"))

    async def send_and_start() -> None:
        await send_all(link, routes_of(three()))
        await start_all(link, routes_of(three()))

    with pytest.raises(LinkError, match=r"robot b: it does not start\ncalled home: a, c$"):
        asyncio.run(send_and_start())
    assert [order for order in link.orders if order[0] == "come_home"] == [("come_home", "a"), ("come_home", "c")]


def test_commands_go_to_all_and_all_errors_are_told() -> None:
    link: Any = Recording(("come_home", "a"), ("come_home", "b"))
    with pytest.raises(LinkError, match=r"robot a: it does not come_home\nrobot b: it does not come_home"):
        asyncio.run(command_all(link.come_home, link.robots))
    assert len(link.orders) == 3


def test_first_reports_are_waited_for() -> None:
    link: Any = Recording()
    asyncio.run(first_reports(link, link.robots))
    assert all(link.latest(robot) is not None for robot in "abc")


def test_those_that_say_nothing_are_waited_for_no_longer_than_one_says() -> None:
    class Silent(Recording):
        def latest(self, robot: str) -> Report | None:
            return None

        async def reports(self) -> AsyncGenerator[Report, None]:
            await asyncio.sleep(60)
            yield None  # type: ignore[misc]

    link: Any = Silent()
    asyncio.run(asyncio.wait_for(first_reports(link, link.robots, 0.05), 20))

"""Routes to a whole fleet: sent, read back and compared, or taken back from all; started all, or called home."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Sequence
from contextlib import aclosing
from dataclasses import replace
from typing import TypeVar

from rota.errors import LinkError
from rota.links.link import Link
from rota.model.plan import Plan
from rota.routes.fence import fence_of
from rota.routes.route import Route, route_of

Item = TypeVar("Item")

MOST_DIFFERENCES = 3  # of one robot that a message tells
FIRST_REPORT_S = 3.0  # that robots have for their first report
MOST_AT_ONCE = 16  # robots that are talked to at the same time
MAY_MOVE = "it may be on its way"


def routes_for(plan: Plan, link: Link) -> tuple[Route, ...]:
    """A route for each robot of the plan, with what the link's robots keep for flying by themselves.

    That is a fence, where the route leaves room, and the rally points, at the fleet's altitude.
    """
    fleet = plan.mission.fleet
    routes = (route_of(trajectory, fleet.altitude_m) for trajectory in plan)
    if not link.takes_fences:
        return tuple(routes)
    fences = (fence_of(plan.mission, trajectory) for trajectory in plan)
    rally_m = tuple((x, y, fleet.altitude_m) for x, y in fleet.rally_points)
    return tuple(replace(route, fence=fence, rally_m=rally_m) for route, fence in zip(routes, fences, strict=True))


async def send_all(link: Link, routes: Sequence[Route]) -> None:
    """Send every route, read it back and compare it.

    Raises LinkError with all that went wrong, each with its robot. Then, and when cancelled, all routes are cleared
    again; the error, or the CancelledError, names robots that could not be reached for that.
    """
    known = set(link.robots)
    missing = [route.robot for route in routes if route.robot not in known]
    if missing:
        raise LinkError("\n".join(f"robot {name}: the link does not reach it" for name in missing))

    async def send(route: Route) -> None:
        await link.send_route(route)
        if found := await link.differences(route):
            more = len(found) - MOST_DIFFERENCES
            told = "; ".join(found[:MOST_DIFFERENCES]) + (f"; and {more} more" if more > 0 else "")
            raise LinkError(f"robot {route.robot}: read back, its route is another one: {told}")

    try:
        faults = await _for_all(send, routes)
    except asyncio.CancelledError:
        raise asyncio.CancelledError(await _cleared(link, routes)) from None
    if faults:
        raise LinkError("\n".join((*map(str, faults), await _cleared(link, routes))))


async def _cleared(link: Link, routes: Iterable[Route]) -> str:
    """Clear all routes; what came of it, with a line for each robot whose route could not be cleared."""
    faults = await _for_all(lambda route: link.clear_route(route.robot), routes)
    kept = "it may still hold its route or a part of it: clear it before it is armed"
    return "\n".join(f"{fault}; {kept}" for fault in faults) or "no robot holds a route: all were cleared"


async def start_all(link: Link, routes: Sequence[Route]) -> None:
    """Start all at the same time, and the plan's time with them.

    Raises LinkError where one does not start: the others are called home, and that one is told to pause, since it may
    have started unheard. When cancelled, all are called home; the CancelledError says so.
    """
    started: list[str] = []
    link.begin()

    async def start(route: Route) -> None:
        await link.start(route.robot)
        started.append(route.robot)

    names = [route.robot for route in routes]
    try:
        faults = await _for_all(start, routes, at_once=len(routes))
    except asyncio.CancelledError:
        raise asyncio.CancelledError("\n".join(await _called_home(link, names))) from None
    if faults:
        unheard = await _for_all(link.pause, [name for name in names if name not in started])
        told = [*await _called_home(link, started), *(f"{fault}; {MAY_MOVE}" for fault in unheard)]
        raise LinkError("\n".join([*map(str, faults), *told]))


async def _called_home(link: Link, names: Sequence[str]) -> list[str]:
    """Call robots home; who was called, and a line for each that could not be."""
    lost = await _for_all(link.come_home, names)
    return [*([f"called home: {', '.join(names)}"] if names else []), *(f"{fault}; {MAY_MOVE}" for fault in lost)]


async def command_all(command: Callable[[str], Awaitable[None]], robots: Iterable[str]) -> None:
    """The same command to all; raises LinkError with all that went wrong."""
    if faults := await _for_all(command, robots):
        raise LinkError("\n".join(map(str, faults)))


async def first_reports(link: Link, robots: Iterable[str], most_s: float = FIRST_REPORT_S) -> None:
    """Take reports until each robot has sent one, or for so long."""
    silent = {robot for robot in robots if link.latest(robot) is None}
    if not silent:
        return
    try:
        async with asyncio.timeout(most_s), aclosing(link.reports()) as reports:
            async for report in reports:
                silent.discard(report.robot)
                if not silent:
                    return
    except TimeoutError:
        return


async def _for_all(
    what: Callable[[Item], Awaitable[None]], items: Iterable[Item], at_once: int = MOST_AT_ONCE
) -> list[LinkError]:
    """Do it for all, some at once and none left out, whatever the others come to; the errors of those that failed."""
    turns = asyncio.Semaphore(at_once)

    async def do(item: Item) -> None:
        async with turns:
            await what(item)

    outcomes = await asyncio.gather(*(do(item) for item in items), return_exceptions=True)
    for outcome in outcomes:
        if isinstance(outcome, BaseException) and not isinstance(outcome, LinkError):
            raise outcome
    return [outcome for outcome in outcomes if isinstance(outcome, LinkError)]

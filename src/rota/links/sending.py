"""Routes to a whole fleet: sent, read back and compared, or taken back from all; started all, or called home."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Sequence
from contextlib import aclosing
from dataclasses import replace
from typing import TypeVar

from rota.errors import LinkError
from rota.fence import fence_of
from rota.links.link import Link
from rota.plan import Plan
from rota.route import Route, route_of

Item = TypeVar("Item")

MOST_DIFFERENCES = 3  # of one robot that a message tells
FIRST_REPORT_S = 3.0  # that robots have for their first report
MOST_AT_ONCE = 16  # robots that are talked to at the same time


def routes_for(plan: Plan, link: Link) -> tuple[Route, ...]:
    """A route for each robot of the plan, with a fence where the link's robots keep one and the route leaves room."""
    routes = (route_of(trajectory, plan.mission.fleet.altitude_m) for trajectory in plan)
    if not link.takes_fences:
        return tuple(routes)
    fences = (fence_of(plan.mission, trajectory) for trajectory in plan)
    return tuple(replace(route, fence=fence) for route, fence in zip(routes, fences, strict=True))


async def send_all(link: Link, routes: Sequence[Route]) -> None:
    """Send every route, read it back and compare it.

    Raises LinkError with all that went wrong, each with its robot. Then, and when cancelled, all routes are cleared
    again; the error names robots that could not be reached for that.
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

    whole = False
    try:
        faults = await _for_all(send, routes)
        whole = not faults
    finally:
        kept = [] if whole else await _cleared(link, routes)
    if faults:
        outcome = kept or ["no robot holds a route: all were cleared"]
        raise LinkError("\n".join((*map(str, faults), *outcome)))


async def _cleared(link: Link, routes: Iterable[Route]) -> list[str]:
    """Clear all routes; a sentence for each robot whose route could not be cleared."""
    faults = await _for_all(lambda route: link.clear_route(route.robot), routes)
    return [f"{fault}; it may still hold its route or a part of it: clear it before it is armed" for fault in faults]


async def start_all(link: Link, routes: Sequence[Route]) -> None:
    """Start all at the same time. Raises LinkError where one does not start; the others are then called home."""
    started: list[Route] = []

    async def start(route: Route) -> None:
        await link.start(route.robot)
        started.append(route)

    whole = False
    try:
        faults = await _for_all(start, routes, at_once=len(routes))
        whole = not faults
    finally:
        lost = [] if whole else await _for_all(lambda route: link.come_home(route.robot), started)
    if faults:
        called = [f"called home: {', '.join(route.robot for route in started)}"] if started else []
        raise LinkError("\n".join([*map(str, faults), *called, *(f"{fault}; it may be on its way" for fault in lost)]))


async def command_all(command: Callable[[str], Awaitable[None]], robots: Iterable[str]) -> None:
    """The same command to all; raises LinkError with all that went wrong."""
    if faults := await _for_all(command, robots):
        raise LinkError("\n".join(map(str, faults)))


async def first_reports(link: Link, robots: Iterable[str]) -> None:
    """Take reports until each robot has sent one, or for ``FIRST_REPORT_S``."""
    silent = {robot for robot in robots if link.latest(robot) is None}
    if not silent:
        return
    try:
        async with asyncio.timeout(FIRST_REPORT_S), aclosing(link.reports()) as reports:
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

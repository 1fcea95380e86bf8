"""`rota fly`: a plan's routes to its robots, and their start."""

from __future__ import annotations

import asyncio
import math
import sys
import threading
from collections.abc import Sequence
from contextlib import aclosing
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import PlanPath, placed_plan, read_plan_argument
from rota.command.link_option import LinkName, LinkSettings, ListSettings
from rota.command.terminal import STANDARD_STREAM, say
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.route import Route

FAR_FROM_START_M = 20.0  # from where its route begins; nothing has been planned for a robot's way there
NEWS_EVERY_S = 10.0


def fly(
    plan: PlanPath,
    link: LinkName = "simulated",
    settings: LinkSettings = None,
    origin: Annotated[
        str | None, typer.Option(metavar="LAT,LON", help="Where x = y = 0 lies, for a mission that does not say it.")
    ] = None,
    start: Annotated[bool, typer.Option("--start", help="Start the robots, after a summary and a question.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="With --start: ask nothing.")] = False,
    pause: Annotated[bool, typer.Option("--pause", help="Send nothing; let all robots stop where they are.")] = False,
    home: Annotated[bool, typer.Option("--home", help="Send nothing; let all robots return to their start.")] = False,
    seconds: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="With --start: end after so long; default at Ctrl-C.")
    ] = None,
    list_settings: ListSettings = False,
) -> None:
    """Send a plan's routes to its robots; start them if asked.

    Routes are read back and compared item by item. Either every robot holds all of its route afterwards, or none does.
    """
    from rota.links.link_settings import make_link, settings_help

    if list_settings:
        typer.echo(settings_help(link))
        return
    _require_sense(plan, start, yes, pause, home, seconds)
    answer = read_plan_argument(plan)
    if origin is not None:
        answer = placed_plan(answer, origin)
    made = make_link(link, answer, settings or ())
    if pause or home:
        asyncio.run(_command(made, home))
        return

    async def run() -> None:
        from rota.links.sending import routes_for

        try:
            await made.open()
            await _send_and_start(made, routes_for(answer, made), start, yes, seconds)
        finally:
            await made.close()

    asyncio.run(run())


def _require_sense(plan: str, start: bool, yes: bool, pause: bool, home: bool, seconds: float | None) -> None:
    if pause + home + start > 1:
        raise RotaError("--start, --pause, --home: only one of them is allowed")
    if (yes or seconds is not None) and not start:
        raise RotaError(f"{'--yes' if yes else '--seconds'}: is for --start only")
    if seconds is not None and not 0 < seconds < math.inf:
        raise RotaError(f"--seconds: {seconds:g} is not allowed; a number greater than 0 is needed")
    if start and not yes and (plan == STANDARD_STREAM or not sys.stdin.isatty()):
        raise RotaError("--start: somebody has to say yes on a terminal; scripts give --yes")


async def _command(link: Link, home: bool) -> None:
    from rota.links.sending import command_all

    try:
        await link.open()
        await command_all(link.come_home if home else link.pause, link.robots)
    finally:
        await link.close()
    typer.echo(f"{len(link.robots)} robots {'are called home' if home else 'have stopped'}.")


async def _send_and_start(link: Link, routes: Sequence[Route], start: bool, yes: bool, seconds: float | None) -> None:
    from rota.links.sending import first_reports, send_all, start_all

    await send_all(link, routes)
    await first_reports(link, [route.robot for route in routes])
    typer.echo(_summary(link, routes))
    if not start:
        typer.echo("Nothing was started: --start does.")
        return
    if not yes and not await _confirmed(f"Start {len(routes)} robots? Type yes: "):
        typer.echo("Nothing was started; the robots hold their routes.")
        return
    await start_all(link, routes)
    typer.echo(f"Started: {len(routes)} robots.")
    if link.drives_along or seconds is not None:
        await _drive_along(link, seconds)


async def _confirmed(question: str) -> bool:
    """Whether somebody types yes; links go on meanwhile, and Ctrl-C ends the waiting."""
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[str] = loop.create_future()

    def take(text: str) -> None:
        if not answer.done():
            answer.set_result(text)

    def ask() -> None:
        try:
            text = input(question)
        except EOFError:
            text = ""
        loop.call_soon_threadsafe(take, text)

    # not by to_thread: the program would not end before somebody types something
    threading.Thread(target=ask, daemon=True).start()
    return (await answer).strip().lower() == "yes"


async def _drive_along(link: Link, seconds: float | None) -> None:
    """Take reports, without which these robots stop, and tell now and then how they are."""
    if link.drives_along:
        say("robots drive while this goes on; Ctrl-C ends it")

    async def news() -> None:
        while True:
            await asyncio.sleep(NEWS_EVERY_S)
            known = [report for robot in link.robots if (report := link.latest(robot)) is not None]
            charges = [report.battery for report in known if report.battery is not None]
            battery = f", lowest battery {min(charges):.0%}" if charges else ""
            say(f"{len(known)} of {len(link.robots)} robots heard{battery}, {link.rejected} messages dropped")

    teller = asyncio.create_task(news())
    failed: set[str] = set()
    try:
        async with asyncio.timeout(seconds), aclosing(link.reports()) as reports:
            async for report in reports:
                if report.mode == "failed" and report.robot not in failed:
                    failed.add(report.robot)
                    say(f"robot {report.robot} has failed")
    except TimeoutError:
        pass
    finally:
        teller.cancel()


def _summary(link: Link, routes: Sequence[Route]) -> str:
    """A line for each robot: its route, its fence, its battery, and how far it is from where its route begins."""
    rows = [("robot", "stops", "loop m", "loop s", "fence", "battery", "from start m")]
    for route in routes:
        report = link.latest(route.robot)
        length_m, duration_s = _round(route)
        off_m = None if report is None else math.dist(report.position_m[:2], route.start_m[:2])
        if off_m is not None and off_m > FAR_FROM_START_M:
            say(f"warning: robot {route.robot} is {off_m:.0f} m from where its route begins; it goes there straight")
        fence = "none" if route.fence is None else f"{len(route.fence.inside_m)} corners"
        if route.fence is not None and route.fence.outside_m:
            fence += f", {len(route.fence.outside_m)} out"
        rows.append(
            (
                route.robot,
                str(len(route.once) + len(route.every_round)),
                f"{length_m:.1f}" if route.every_round else "stays",
                f"{duration_s:.1f}" if route.every_round else "-",
                fence,
                f"{report.battery:.0%}" if report is not None and report.battery is not None else "-",
                f"{off_m:.1f}" if off_m is not None else "-",
            )
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join((row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:]))) for row in rows]
    return "\n".join([*lines, f"{len(routes)} routes sent; read back, each is the one sent."])


def _round(route: Route) -> tuple[float, float]:
    """Length in metres and duration in seconds of a round of the loop."""
    length_m = duration_s = 0.0
    at_m = route.loop[0].place_m
    for stop in route.every_round:
        step_m = math.dist(at_m, stop.place_m)
        length_m, at_m = length_m + step_m, stop.place_m
        duration_s += (step_m / stop.speed_m_s if stop.speed_m_s else 0.0) + stop.hold_s
    return length_m, duration_s

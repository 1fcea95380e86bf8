"""`rota fly`: a plan's routes to its robots, and their start."""

from __future__ import annotations

import asyncio
import math
import os
import shlex
import sys
import threading
from collections.abc import Sequence
from contextlib import aclosing
from datetime import UTC, datetime
from io import UnsupportedOperation
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import PlanPath, read_plan_argument
from rota.command.interrupt import run_to_its_end
from rota.command.link_option import LinkName, LinkOrigin, LinkSettings, ListSettings, chosen_link, opened
from rota.command.terminal import STANDARD_STREAM, say
from rota.command.without_mass import without_mass
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.plan import Plan
    from rota.route import Route

FAR_FROM_START_M = 20.0  # from where its route begins; nothing has been planned for a robot's way there
NEWS_EVERY_S = 10.0
LONGEST_ANSWER = 1000  # bytes
RELEASED = "robots get no more stops from here on, and wait at the last one that they have"
GO_ON = "robots go on with their routes; --pause stops them, --home calls them back"


def fly(
    plan: PlanPath,
    link: LinkName = "simulated",
    settings: LinkSettings = None,
    origin: LinkOrigin = None,
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
    from rota.links.link_settings import settings_help

    if list_settings:
        typer.echo(settings_help(link))
        return
    _require_sense(plan, start, yes, pause, home, seconds)
    answer = read_plan_argument(plan)
    made = chosen_link(link, answer, origin, settings)
    watching = _watching(plan, link, settings or [], origin)
    if link == "mavlink" and not (pause or home) and (told := without_mass(answer, is_flown=True)) is not None:
        say(f"the plan is {told}")
    run_to_its_end(_command(made, home) if pause or home else _fly(made, answer, start, yes, seconds, watching))


def _require_sense(plan: str, start: bool, yes: bool, pause: bool, home: bool, seconds: float | None) -> None:
    if pause + home + start > 1:
        raise RotaError("--start, --pause, --home: only one of them is allowed")
    if (yes or seconds is not None) and not start:
        raise RotaError(f"{'--yes' if yes else '--seconds'}: is for --start only")
    if seconds is not None and not 0 < seconds < math.inf:
        raise RotaError(f"--seconds: {seconds:g} is not allowed; a number greater than 0 is needed")
    if start and not yes and (plan == STANDARD_STREAM or not sys.stdin.isatty()):
        raise RotaError("--start: somebody has to say yes on a terminal; scripts give --yes")


def _watching(plan: str, link: str, settings: list[str], origin: str | None) -> str:
    """The command that watches the same robots, but for when they started."""
    words = ["rota", "watch", plan, "--link", link, *(["--origin", origin] if origin is not None else [])]
    for text in settings:
        if not text.startswith("start_time="):
            words += ["--set", text]
    return shlex.join(words)


async def _fly(link: Link, plan: Plan, start: bool, yes: bool, seconds: float | None, watching: str) -> None:
    from rota.links.sending import routes_for

    async with opened(link):
        await _send_and_start(link, routes_for(plan, link), start, yes, seconds, watching)


async def _command(link: Link, home: bool) -> None:
    from rota.links.sending import command_all

    async with opened(link):
        await command_all(link.come_home if home else link.pause, link.robots)
    typer.echo(f"{len(link.robots)} robots {'are called home' if home else 'have stopped'}.")


async def _send_and_start(
    link: Link, routes: Sequence[Route], start: bool, yes: bool, seconds: float | None, watching: str
) -> None:
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
    if link.in_process:
        typer.echo(f"Started: {len(routes)} robots.")
    else:
        from rota.files.timed_places import instant_text

        now = instant_text(datetime.now(UTC))
        typer.echo(f"Started: {len(routes)} robots at {now}. To watch them, from another terminal:")
        typer.echo(f"{watching} --set start_time={now}")
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
            # a line, as terminals hand it out; a thread within Python's own stdin would abort the program at its end
            text = os.read(sys.stdin.fileno(), LONGEST_ANSWER).decode(errors="replace")
        except UnsupportedOperation:
            text = sys.stdin.readline()
        loop.call_soon_threadsafe(take, text)

    typer.echo(question, nl=False)
    # not by to_thread: the program would not end before somebody types something
    threading.Thread(target=ask, daemon=True).start()
    try:
        return (await answer).strip().lower() == "yes"
    except asyncio.CancelledError:
        raise asyncio.CancelledError("nothing was started; the robots hold their routes") from None


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
            dropped = sum(rejected.messages for rejected in link.rejections.values())
            say(f"{len(known)} of {len(link.robots)} robots heard{battery}, {dropped} messages dropped")

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
        if not link.in_process:
            say(RELEASED if link.drives_along else GO_ON)


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
        out = 0 if route.fence is None else len(route.fence.outside_m) + len(route.fence.circles_m)
        if out:
            fence += f", {out} out"
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

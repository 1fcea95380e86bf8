"""`rota fly`: a plan's routes to its robots, and their start."""

from __future__ import annotations

import asyncio
import math
import os
import shlex
import sys
import threading
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from datetime import UTC, datetime
from io import UnsupportedOperation
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import PlanPath, read_plan_argument
from rota.command.fly_reliefs import require_reliefs, routes_off_chargers
from rota.command.interrupt import run_to_its_end
from rota.command.link_option import LinkName, LinkOrigin, LinkSettings, ListSettings, chosen_link, open_link
from rota.command.terminal import STANDARD_STREAM, say
from rota.command.without_mass import without_mass
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError
from rota.model.columns import columns

if TYPE_CHECKING:
    from rota.command.fly_along import Along
    from rota.links.flights import Flights
    from rota.links.free_ways import LayeredWay
    from rota.links.link import Link
    from rota.model.plan import Plan
    from rota.routes.route import Route

FAR_FROM_START_M = 20.0  # from where its route begins; nothing has been planned for a robot's way there
LONGEST_ANSWER = 1000  # bytes
FIRST_PLACE_S = 60.0  # that copters have which were just switched on, until they know where they are


def fly(
    plan: PlanPath,
    link: LinkName = "simulated",
    settings: LinkSettings = None,
    origin: LinkOrigin = None,
    start: Annotated[bool, typer.Option("--start", help="Start the robots, after a summary and a question.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="With --start: ask nothing.")] = False,
    pause: Annotated[bool, typer.Option("--pause", help="Send nothing; let all robots stop where they are.")] = False,
    home: Annotated[bool, typer.Option("--home", help="Send nothing; let all robots return to their start.")] = False,
    hands_off: Annotated[
        bool, typer.Option("--hands-off", help="With --start: leave them alone then; nobody keeps them in phase.")
    ] = False,
    log: Annotated[
        str | None, typer.Option(metavar="LOG", help="With --start: write all that arrives, for `rota watch --judge`.")
    ] = None,
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
    _require_sense(plan, start, yes, pause, home, _only_started(yes, seconds, hands_off, log))
    answer = read_plan_argument(plan)
    left_alone = hands_off and link == "mavlink" and not any(text.startswith("way=") for text in settings or ())
    # targets need somebody who sends them
    chosen = [*(settings or ()), "way=mission"] if left_alone else settings
    made = chosen_link(link, answer, origin, chosen)
    if not (pause or home):
        require_reliefs(answer, made, link, hands_off)
    watching = _watching(plan, link, settings or [], origin)
    if hands_off and made.drives_along:
        raise RotaError(f"--hands-off: robots on the link {link} drive only while this command goes on")
    order = Order(start=start, yes=yes, hands_off=hands_off, seconds=seconds, log=log)
    if link == "mavlink" and not (pause or home) and (told := without_mass(answer, is_flown=True)) is not None:
        say(f"the plan is {told}")
    run_to_its_end(_command(made, answer, home) if pause or home else _fly(made, answer, order, watching))


@dataclass(frozen=True, kw_only=True)
class Order:
    """What is to be done once the robots hold their routes."""

    start: bool
    yes: bool
    hands_off: bool
    seconds: float | None
    log: str | None


def _only_started(yes: bool, seconds: float | None, hands_off: bool, log: str | None) -> list[str]:
    """The options given that are for --start only."""
    if seconds is not None and not 0 < seconds < math.inf:
        raise RotaError(f"--seconds: {seconds:g} is not allowed; a number greater than 0 is needed")
    if hands_off and (seconds is not None or log is not None):
        raise RotaError(f"--hands-off: {'--seconds' if log is None else '--log'} is for robots that are driven along")
    given = {"--yes": yes, "--hands-off": hands_off, "--log": log is not None, "--seconds": seconds is not None}
    return [option for option, is_given in given.items() if is_given]


def _require_sense(plan: str, start: bool, yes: bool, pause: bool, home: bool, only_started: list[str]) -> None:
    if pause + home + start > 1:
        raise RotaError("--start, --pause, --home: only one of them is allowed")
    if only_started and not start:
        raise RotaError(f"{only_started[0]}: is for --start only")
    if start and not yes and (plan == STANDARD_STREAM or not sys.stdin.isatty()):
        raise RotaError("--start: somebody has to say yes on a terminal; scripts give --yes")


def _watching(plan: str, link: str, settings: list[str], origin: str | None) -> str:
    """The command that watches the same robots, but for when they started."""
    words = ["rota", "watch", plan, "--link", link, *(["--origin", origin] if origin is not None else [])]
    for text in settings:
        if not text.startswith("start_time="):
            words += ["--set", text]
    return shlex.join(words)


async def _fly(link: Link, plan: Plan, order: Order, watching: str) -> None:
    """Send the routes, start the robots if asked to, and drive along with them."""
    from rota.links.flights import Flights
    from rota.links.sending import first_reports, routes_for, send_all, start_all

    with _along(plan, link, order) as along:
        async with open_link(link):
            routes = routes_for(plan, link)
            await send_all(link, routes)
            await first_reports(link, link.robots)
            if link.flies and (silent := [name for name in link.robots if link.latest(name) is None]):
                say(f"waiting for {', '.join(silent)} to say where it is")
                await first_reports(link, silent, FIRST_PLACE_S)
            flights = Flights(link, plan.mission, say) if link.flies and not order.hands_off else None
            gathers = routes_off_chargers(link, plan, routes)
            try:
                if not await _is_to_start(link, plan, order, (routes, gathers), along, flights):
                    return
            except asyncio.CancelledError:
                raise asyncio.CancelledError("nothing was started; the robots hold their routes") from None
            if flights is not None:
                await flights.gather(gathers)
            await start_all(link, routes)
            holds = along is not None and link.heard_by_one
            _tell_started(link, len(routes), "" if holds else watching)
            if along is not None:
                try:
                    await along.drive(order.seconds)
                finally:
                    if holds:
                        say(f"to watch them: {watching} --set start_time={_begun_text(link)}")


async def _is_to_start(
    link: Link,
    plan: Plan,
    order: Order,
    sent: tuple[Sequence[Route], Sequence[Route]],
    along: Along | None,
    flights: Flights | None,
) -> bool:
    """Tell what was sent and what robots do by themselves; whether they are to be started.

    sent: all routes, and those of robots that gather in the air before they start.
    """
    routes, gathers = sent
    typer.echo(_summary(link, routes, flights.ways_to(gathers) if flights else ()))
    for told in along.tell_before() if along is not None else ():
        typer.echo(told)
    for told in await _by_themselves(link, plan):
        typer.echo(told)
    if not order.start:
        typer.echo("Nothing was started: --start does.")
        return False
    if not order.yes and not await _is_confirmed(f"Start {len(routes)} robots? Type yes: "):
        typer.echo("Nothing was started; the robots hold their routes.")
        return False
    return True


async def _by_themselves(link: Link, plan: Plan) -> list[str]:
    """What robots do by themselves, each sentence once with those whom it holds for."""
    from rota.links.flights import Flights

    whose: dict[str, list[str]] = {}
    sentences = await asyncio.gather(*map(link.by_itself, link.robots))
    for robot, said in zip(link.robots, sentences, strict=True):
        for sentence in said:
            whose.setdefault(sentence, []).append(robot)
    told = [
        f"{'each robot' if len(robots) == len(link.robots) else ', '.join(robots)}: {said}"
        for said, robots in whose.items()
    ]
    if link.flies:
        flights = Flights(link, plan.mission, say)
        shares = [(way.robot, flights.blocked_home(way)) for way in plan]
        blocked = [f"{share:.0%} of {robot}'s" for robot, share in shares if share > 0]
        if blocked:
            told.append(
                f"a straight way home, which they take by themselves, crosses obstacles from {', '.join(blocked)} way"
            )
    return told


def _along(plan: Plan, link: Link, order: Order) -> AbstractContextManager[Along | None]:
    """What drives along, if it is wanted and there is something to do or to write down."""
    listens = link.drives_along or link.keeps_phase or order.seconds is not None or order.log is not None
    if not order.start or order.hands_off or not listens:
        return nullcontext()
    from rota.command.fly_along import Along
    from rota.live.ready import make_ready

    mention_compiling("live")
    make_ready()
    return Along(plan, link, order.log)


def _tell_started(link: Link, robots: int, watching: str) -> None:
    """That they have started, and when; ``watching``: the command that watches them, empty: there is none yet."""
    if link.in_process:
        typer.echo(f"Started: {robots} robots.")
        return
    begun = _begun_text(link)
    typer.echo(f"Started: {robots} robots at {begun}.{' To watch them, from another terminal:' if watching else ''}")
    if watching:
        typer.echo(f"{watching} --set start_time={begun}")


def _begun_text(link: Link) -> str:
    """When the plan's time began, by the clock that robots' stamps are of."""
    from rota.files.timed_places import instant_text

    return instant_text(datetime.fromtimestamp(link.begun_s, UTC))


async def _command(link: Link, plan: Plan, home: bool) -> None:
    """Stop all robots or bring them home."""
    from rota.links.flights import Flights
    from rota.links.sending import command_all, first_reports

    async with open_link(link):
        if home and link.flies:
            await first_reports(link, link.robots)
            await Flights(link, plan.mission, say).bring_home()
            typer.echo(f"{len(link.robots)} robots have landed.")
            return
        await command_all(link.come_home if home else link.pause, link.robots)
    typer.echo(f"{len(link.robots)} robots {'are called home' if home else 'have stopped'}.")


async def _is_confirmed(question: str) -> bool:
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
    return (await answer).strip().lower() == "yes"


def _summary(link: Link, routes: Sequence[Route], ways: Sequence[LayeredWay]) -> str:
    """A line for each robot: its route, its fence, its battery, and how far it is from where its route begins.

    ways: those that lead there; without them it goes straight.
    """
    rows = [("robot", "stops", "loop m", "loop s", "fence", "battery", "way there m" if ways else "from start m")]
    led = {way.robot: f"{way.length_m:.1f} at {way.height_m:g}" for way in ways}
    for route in routes:
        report = link.latest(route.robot)
        length_m, duration_s = _round(route)
        off_m = None if report is None else math.dist(report.position_m[:2], route.start_m[:2])
        if off_m is not None and off_m > FAR_FROM_START_M and not ways:
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
                led.get(route.robot, f"{off_m:.1f}" if off_m is not None else "-"),
            )
        )
    return f"{columns(rows)}\n{len(routes)} routes sent; read back, each is the one sent."


def _round(route: Route) -> tuple[float, float]:
    """Length in metres and duration in seconds of a round of the loop."""
    length_m = duration_s = 0.0
    at_m = route.loop[0].place_m
    for stop in route.every_round:
        duration_s += stop.drive_s(at_m) + stop.hold_s
        length_m, at_m = length_m + math.dist(at_m, stop.place_m), stop.place_m
    return length_m, duration_s

"""`rota watch`: the fleet beside its plan, live or from a log, and the check's verdict on a log."""

from __future__ import annotations

import asyncio
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import PlanPath, read_plan_argument
from rota.command.exit_codes import DONE, VIOLATED
from rota.command.interrupt import stop_on_interrupt
from rota.command.link_option import LinkName, LinkOrigin, LinkSettings, ListSettings, chosen_link, open_link
from rota.command.terminal import STANDARD_STREAM, say
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import MissionError, RotaError

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.live.notices import Notice
    from rota.live.settings import WatchSettings
    from rota.live.watch import Watch
    from rota.live.watch_log import LogReader
    from rota.model.plan import Plan

LOG_SUFFIX = ".rota-log"


def watch(
    plan: PlanPath,
    link: LinkName = "simulated",
    settings: LinkSettings = None,
    origin: LinkOrigin = None,
    log: Annotated[
        str | None, typer.Option(metavar="LOG", help="Where all that arrives is written; default PLAN's name.rota-log.")
    ] = None,
    replay: Annotated[
        str | None, typer.Option(metavar="LOG", help="Connect to nobody; watch again what a log holds.")
    ] = None,
    judge: Annotated[
        str | None, typer.Option(metavar="LOG", help="Connect to nobody; check what was really covered.")
    ] = None,
    tolerance: Annotated[
        float, typer.Option(min=0, metavar="METRES", help="With --judge: credit sensors with so much more reach.")
    ] = 0.0,
    silent: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="A robot silent for longer is lost; default 5.")
    ] = None,
    battery: Annotated[
        float | None, typer.Option(metavar="SHARE", help="A battery at or below this is low; default 0.25.")
    ] = None,
    off_route: Annotated[
        float | None, typer.Option(metavar="METRES", help="Farther beside its route; default half a sensor's reach.")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="End when the plan is so old; default at Ctrl-C.")
    ] = None,
    every: Annotated[
        float, typer.Option(metavar="SECONDS", help="Where no table is shown: time between two lines of state.")
    ] = 10.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print notices and states as lines of JSON.")] = False,
    replan: Annotated[
        bool, typer.Option("--replan", help="When a robot is lost, write a plan for those that remain beside the log.")
    ] = False,
    list_settings: ListSettings = False,
) -> None:
    """Watch robots along their plan: exit code 1 on a lapse.

    Alarms come before: which zone, in how many seconds, and who could still make it.
    """
    from rota.links.link_settings import settings_help

    if list_settings:
        typer.echo(settings_help(link))
        return
    chosen = _settings(silent, battery, off_route)
    _require_sense(replay, judge, log, bool(settings) or chosen is not None, seconds, every, tolerance, replan)
    answer = read_plan_argument(plan)
    if judge is not None:
        raise typer.Exit(_judge(answer, judge, tolerance, as_json))
    if replay is not None:
        raise typer.Exit(_replay(answer, replay, every, as_json))
    made = chosen_link(link, answer, origin, settings)
    log = _free_name(plan) if log is None else log
    raise typer.Exit(_watch(answer, made, chosen, log, seconds, every, as_json, replan))


# ---------------------------------------------------------------- what was asked


def _settings(silent: float | None, battery: float | None, off_route: float | None) -> WatchSettings | None:
    """The settings that differ from their defaults; None: none does."""
    from rota.live.settings import WatchSettings

    given = {"silent_s": silent, "battery_low": battery, "off_route_m": off_route}
    try:
        chosen = {name: value for name, value in given.items() if value is not None}
        return WatchSettings(**chosen) if chosen else None
    except MissionError as error:
        text = str(error)
        for name, option in (("silent_s", "--silent"), ("battery_low", "--battery"), ("off_route_m", "--off-route")):
            text = text.replace(name, option)
        raise RotaError(text) from None


def _require_sense(
    replay: str | None,
    judge: str | None,
    log: str | None,
    has_settings: bool,
    seconds: float | None,
    every: float,
    tolerance: float,
    replan: bool,
) -> None:
    """Refuse options that contradict each other, and numbers that are not above 0."""
    if replay is not None and judge is not None:
        raise RotaError("--replay, --judge: only one of them is allowed")
    if (replay or judge) and (log is not None or has_settings or seconds is not None or replan):
        option = "--replay" if replay else "--judge"
        raise RotaError(f"{option}: the log says what was watched, and how; leave out all but --every and --json")
    for option, value in (("--seconds", seconds), ("--every", every), ("--tolerance", tolerance or None)):
        if value is not None and not 0 < value < math.inf:
            raise RotaError(f"{option}: {value:g} is not allowed; a number greater than 0 is needed")


def _free_name(plan: str) -> str:
    """A log's name in this folder that no file has yet."""
    stem = "plan" if plan == STANDARD_STREAM else Path(plan).name.removesuffix(".json").removesuffix(".rota")
    names = (f"{stem}{f'-{k}' if k > 1 else ''}{LOG_SUFFIX}" for k in range(1, 1_000_000))
    return next(name for name in names if not Path(name).exists())


# ---------------------------------------------------------------- watching


class Lines:
    """Notices and, now and then, the state as lines on stdout: the same ones live and in a replay."""

    def __init__(self, watched: Watch, every_s: float, as_json: bool) -> None:
        self._watch, self._every_s, self._as_json = watched, every_s, as_json
        self._next_s: float | None = None

    def show(self, notices: list[Notice]) -> None:
        """What a session calls at every tick."""
        from rota.live.notices import notice_json, notice_line, state_json, state_line

        for notice in notices:
            typer.echo(notice_json(notice) if self._as_json else notice_line(notice))
        now_s = self._watch.now_s
        if self._next_s is None or now_s >= self._next_s:
            self._next_s = now_s + self._every_s
            state = self._watch.state()
            typer.echo(state_json(state) if self._as_json else state_line(state))

    def end(self) -> None:
        """What it came to."""
        from rota.live.notices import state_json, summary

        if not self._watch.begun:
            say("nothing was heard, and nothing watched")
            return
        state = self._watch.state()
        typer.echo(state_json(state) if self._as_json else summary(state, self._watch.lapses))


def _watch(
    plan: Plan,
    link: Link,
    chosen: WatchSettings | None,
    log: str,
    seconds: float | None,
    every: float,
    as_json: bool,
    replan: bool,
) -> int:
    """Watch robots over a link until the time is up or Ctrl-C; returns the exit code."""
    from rota.command.watch_replans import Replans
    from rota.command.watch_table import WatchTable
    from rota.live.ready import make_ready
    from rota.live.session import Session
    from rota.live.watch import Watch
    from rota.live.watch_log import LogWriter

    mention_compiling("live")
    make_ready()
    watched = Watch(plan, chosen)
    is_table = sys.stdout.isatty() and not as_json
    until_s = math.inf if seconds is None else seconds
    with LogWriter(log, plan, watched.settings) as writer, stop_on_interrupt(lambda by: None) as stop:
        say(f"all that arrives is written to {log}; Ctrl-C ends the watch")
        lines = Lines(watched, every, as_json)
        table = WatchTable(watched) if is_table else None
        replans = Replans(plan, log.removesuffix(LOG_SUFFIX)) if replan else None
        show = lines.show if table is None else table.show

        def tell(notices: list[Notice]) -> None:
            """Show notices, and replan for those that remain where that is asked."""
            show(notices)
            if replans is not None:
                replans.note(notices)

        session = Session(watched, writer, tell)

        async def run() -> None:
            async with open_link(link):
                await _begin(plan, link)
                await session.follow(link, until_s=until_s, should_stop=stop)

        if table is None:
            asyncio.run(run())
        else:
            with table:
                asyncio.run(run())
        if replans is not None:
            replans.end()
        lines.end()
    return VIOLATED if watched.lapses else DONE


async def _begin(plan: Plan, link: Link) -> None:
    """Vehicles in this process are given their routes and started; others are not this command's to start."""
    if link.in_process:
        from rota.links.sending import routes_for, send_all, start_all

        routes = routes_for(plan, link)
        await send_all(link, routes)
        await start_all(link, routes)


def _replay(plan: Plan, path: str, every: float, as_json: bool) -> int:
    """Show a log as if it came now; returns the exit code."""
    from rota.live.session import replay
    from rota.live.watch import Watch
    from rota.live.watch_log import LogReader

    log = LogReader.of(path, plan)
    mention_compiling("live")
    watched = Watch(plan, log.settings)
    lines = Lines(watched, every, as_json)
    replay(log, watched, lines.show)
    lines.end()
    _tell_damage(log)
    return VIOLATED if watched.lapses else DONE


def _judge(plan: Plan, path: str, tolerance_m: float, as_json: bool) -> int:
    """Print the verdict of the check on a log; returns the exit code."""
    from rota.check import report_table, report_to_json
    from rota.check.recorded import check_recording
    from rota.live.recording import recording_of
    from rota.live.watch_log import LogReader

    log = LogReader.of(path, plan)
    recording = recording_of(plan, log.events(), log.settings)
    _tell_damage(log)
    mention_compiling("check")
    report = check_recording(
        plan.mission, recording.tracks, recording.window_s, robots=len(plan.trajectories), tolerance_m=tolerance_m
    )
    if as_json:
        typer.echo(json.dumps(report_to_json(report), indent=1))
    else:
        from_s, to_s = recording.window_s
        credit = f", with {tolerance_m:g} m more reach" if tolerance_m else ""
        typer.echo(f"recorded: {recording.reports} reports, judged from {from_s:.1f} s to {to_s:.1f} s{credit}")
        typer.echo(report_table(report))
    return DONE if report.verdict == "met" else VIOLATED


def _tell_damage(log: LogReader) -> None:
    if log.fault is not None:
        say(f"warning: {log.fault}")

"""`rota replan`: a plan for the robots that remain and the mission as it is now, from where robots are at a moment."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rota.check import compiled_packages
from rota.command.arguments import PlanPath, read_and_warn, read_plan_argument, require_target
from rota.command.exit_codes import DONE, NO_PLAN, VIOLATED
from rota.command.interrupt import stop_on_interrupt
from rota.command.plan import write_or_print
from rota.command.terminal import STANDARD_STREAM, progress_bar, say
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import MissionError, NoPlanFound, RotaError

if TYPE_CHECKING:
    from rota.replanning.replan import Replanned

OPTIONS = {  # by what they are called in Python
    "at_s": "--at",
    "lost": "--lost",
    "joined": "--joined",
    "late": "--late",
    "battery": "--battery",
    "time_limit_s": "--time-limit",
}


def replan(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="NEW", help="The plan file to write; - stdout.")],
    at: Annotated[
        float, typer.Option("--at", metavar="T", help="The moment of the change, seconds since the plan began.")
    ],
    lost: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A robot that is there no more. May be given again.")
    ] = None,
    joined: Annotated[
        list[str] | None, typer.Option(metavar="NAME=X,Y", help="A new robot, and where it is, metres.")
    ] = None,
    late: Annotated[
        list[str] | None, typer.Option(metavar="NAME=S", help="A robot that has driven all S seconds late.")
    ] = None,
    battery: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=SHARE", help="How full a battery is, 0 to 1, if a new robot's is not full, or less."
        ),
    ] = None,
    mission: Annotated[
        Path | None, typer.Option(metavar="CHANGED", help="The mission as it is now; default as in the plan.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="NUMBER", help="Of the search for better plans.")] = 0,
    time_limit: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Stop after so long with the best plan so far.")
    ] = None,
) -> None:
    """Replan from a moment on, with robots lost, new or late.

    The first plan is written within moments, and each better one in its place.
    """
    require_target(output, source=plan)
    before = read_plan_argument(plan)
    changed = None if mission is None else read_and_warn(mission)
    shares = _numbers(battery or [], "--battery", "SHARE", "robot-6=0.4")
    places, delays = _places(joined or []), _numbers(late or [], "--late", "S", "robot-2=8")
    asked = changed or before.mission
    mention_compiling(*compiled_packages(asked))
    from rota.replanning.replan import replan as search

    with stop_on_interrupt(lambda by: say(f"stopping, by {by}")) as stop:
        try:
            with progress_bar() as bar:
                found = search(
                    before, at_s=at, lost=lost or (), joined=places, late=delays, mission=changed,
                    battery=shares, seed=seed, time_limit_s=time_limit, should_stop=stop, progress=bar.show,
                    on_better=_teller(output),
                )  # fmt: skip
        except NoPlanFound as failure:
            say(f"no plan: {failure}")
            raise typer.Exit(stop.exit_code or NO_PLAN) from None
        except MissionError as error:
            name, colon, rest = str(error).partition(":")
            raise (RotaError(OPTIONS[name] + colon + rest) if name in OPTIONS else error) from None
    if output == STANDARD_STREAM:
        write_or_print(found.plan, output, meets_demand=found.meets_demand)
    _show(found, output)
    raise typer.Exit(stop.exit_code or (DONE if found.meets_demand else VIOLATED))


def _teller(output: str) -> Callable[[Replanned], None]:
    """What writes each plan that is better than the last, and tells how late it is."""
    began_s = time.monotonic()

    def tell(found: Replanned) -> None:
        if output != STANDARD_STREAM:
            write_or_print(found.plan, output, meets_demand=found.meets_demand)
        late_now = found.report.lateness
        told = "" if late_now is None else late_now.lines()[0].partition(": ")[2]
        say(f"after {time.monotonic() - began_s:.1f} s: {found.report.verdict}; {told}")

    return tell


def _show(found: Replanned, target: str) -> None:
    """Tell what the check says, who keeps its ways, and where the plan is."""
    from rota.check import met_text, report_table

    def print_line(line: str) -> None:
        typer.echo(line, err=target == STANDARD_STREAM)

    report, lateness = found.report, found.report.lateness
    changed = [line.robot for line in found.plan if line.robot not in found.kept]
    print_line(
        f"On their ways as before: {', '.join(found.kept) or 'none'}. On others: {', '.join(changed) or 'none'}."
    )
    if report.verdict == "met":
        print_line(f"Check: {met_text(report)}")
        for line in () if lateness is None else lateness.lines():
            print_line(line[:1].upper() + line[1:] + ".")
    else:
        print_line(f"Check: {report.verdict}. The robots that remain were not found to meet the demand.\n")
        print_line(report_table(report))
    if target != STANDARD_STREAM:
        print_line(f"Plan: {target}")


def _places(given: list[str]) -> dict[str, tuple[float, float]]:
    """Robots and places of NAME=X,Y."""
    places = dict[str, tuple[float, float]]()
    for text in given:
        name, _, place = text.rpartition("=")
        parts = place.split(",")
        if not name or len(parts) != 2:
            raise RotaError(f"--joined: {text!r} is not allowed; NAME=X,Y is needed, such as robot-9=12.5,3")
        _require_once("--joined", name, places)
        places[name] = (_number("--joined", text, parts[0]), _number("--joined", text, parts[1]))
    return places


def _numbers(given: list[str], option: str, unit: str, such: str) -> dict[str, float]:
    """Robots and their numbers, given as NAME=NUMBER."""
    numbers = dict[str, float]()
    for text in given:
        name, _, number = text.rpartition("=")
        if not name:
            raise RotaError(f"{option}: {text!r} is not allowed; NAME={unit} is needed, such as {such}")
        _require_once(option, name, numbers)
        numbers[name] = _number(option, text, number)
    return numbers


def _require_once(option: str, name: str, given: Collection[str]) -> None:
    """RotaError for a robot that an option has been given for."""
    if name in given:
        raise RotaError(f"{option}: robot {name!r} is given twice; once is allowed")


def _number(option: str, text: str, part: str) -> float:
    """A number of an option's text."""
    try:
        return float(part)
    except ValueError:
        raise RotaError(f"{option}: {text!r} is not allowed; {part!r} is no number") from None

"""The command line: arguments to functions, outcomes to exit codes."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from rota.errors import NoPlanFound, RotaError

if TYPE_CHECKING:
    from rota.check import Report
    from rota.mission import Mission
    from rota.plan import Plan

DONE, VIOLATED, BAD_INPUT, NO_PLAN, OUR_FAULT, INTERRUPTED = 0, 1, 2, 3, 70, 130
STANDARD_STREAM = "-"

app = typer.Typer(
    help="Plan timed routes for teams of robots that must keep watching a whole area, and check every plan.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


ExportFormat = Literal["geojson", "qgroundcontrol", "qgroundcontrol-px4"]
SchemaName = Literal["mission", "plan", "report"]
EffortName = Literal["quick", "normal", "high"]


def main() -> NoReturn:
    """The ``rota`` program."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run the command line; returns the exit code. All messages to people go to stderr."""
    try:
        app(arguments, prog_name="rota")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else DONE
    except NoPlanFound as outcome:
        _say(f"no plan: {outcome}")
        return NO_PLAN
    except RotaError as error:
        for line in str(error).splitlines():
            _say(f"error: {line}")
        return BAD_INPUT
    except Exception as error:
        traceback.print_exc()
        _say(f"a fault in Rota, not in your input ({type(error).__name__}); please report it with the lines above")
        return OUR_FAULT
    return DONE


def _say(message: str) -> None:
    print(f"rota: {message}", file=sys.stderr, flush=True)


# ---------------------------------------------------------------- plan


@app.command()
def plan(
    mission: Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file, YAML or JSON.")],
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="PLAN", help="The plan file; default STEM.rota.json, - stdout."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same plan.")] = 0,
    effort: Annotated[EffortName | None, typer.Option(help="Work to spend; default as the mission says.")] = None,
    time_limit: Annotated[float | None, typer.Option(metavar="SECONDS", help="Stop early with the best plan.")] = None,
    best: Annotated[bool, typer.Option("--best", help="Write the best plan even if it misses its demand.")] = False,
) -> None:
    """Plan a mission, check the plan, and write it."""
    from rota.compiled_cache import check_compiled_meanwhile, is_compiled
    from rota.files.mission_file import read_mission

    target = output if output is not None else f"{mission.stem}.rota.json"
    _require_target(target, source=mission)
    read = read_mission(mission)
    for warning in read.warnings:
        _say(f"warning: {warning}")
    asked = read.mission if effort is None else read.mission.with_effort(effort)
    _mention_compiling("planners/patrol/annealing", "geometry", "check")
    with nullcontext() if is_compiled("check") else check_compiled_meanwhile():
        code = _plan_and_write(asked, target, seed, time_limit, best)
    raise typer.Exit(code)


def _plan_and_write(mission: Mission, target: str, seed: int, time_limit_s: float | None, best: bool) -> int:
    from rota.check import check_plan
    from rota.interrupt import stop_on_interrupt
    from rota.make_plan import search_plan

    reason = None
    with _progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        try:
            found = search_plan(mission, seed=seed, time_limit_s=time_limit_s, progress=bar.show, should_stop=stop)
            answer, report, early = found.plan, found.report, found.stopped_early
        except NoPlanFound as failure:
            reason, early = failure, False
            if not best or failure.best is None:
                return _say_no_plan(failure, stop.raised)
            answer = failure.best  # type: ignore[assignment]
            report = check_plan(answer)
    _write_plan(answer, target, meets_demand=reason is None)
    _show_outcome(answer, report, target)
    if stop.raised:
        _say("interrupted: this is the best plan so far")
    elif early:
        _say("stopped early by the time limit: this is the best plan so far")
    if reason is not None:
        _say(f"no plan: {reason}")
        _say("this is the best plan found; it does NOT meet its demand and its file is marked so")
    return INTERRUPTED if stop.raised else DONE if reason is None else NO_PLAN


def _say_no_plan(failure: NoPlanFound, interrupted: bool) -> int:
    if interrupted:
        _say("interrupted before a plan passed the check; nothing is written")
    _say(f"no plan: {failure}")
    if failure.best is not None:
        _say("--best writes the best plan found, which does not meet its demand")
    return INTERRUPTED if interrupted else NO_PLAN


def _write_plan(answer: Plan, target: str, *, meets_demand: bool) -> None:
    from rota.files.plan_file import plan_text, write_plan

    if target == STANDARD_STREAM:
        sys.stdout.write(plan_text(answer, meets_demand=meets_demand))
        sys.stdout.flush()
    else:
        write_plan(answer, target, meets_demand=meets_demand)


def _show_outcome(answer: Plan, report: Report, target: str) -> None:
    from rota.check import report_table
    from rota.plan_table import robot_rows, robots_sentence

    console = Console(stderr=target == STANDARD_STREAM, highlight=False)
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("robot")
    table.add_column("loop m", justify="right")
    table.add_column("loop s", justify="right")
    table.add_column("slack", justify="right")
    table.add_column("serves")
    for row in robot_rows(answer):
        slack = "shared" if row.slack is None else f"{row.slack:.0%}"
        length, time = f"{row.loop_length_m:.1f}", f"{row.loop_time_s:.1f}"
        table.add_row(row.robot, length, time, slack, ", ".join(row.zones) or "nothing")
    console.print(table)
    console.print(robots_sentence(answer), markup=False)
    if report.verdict == "met":
        console.print("Check: met, every demand, for ever.")
    else:
        console.print(f"Check: {report.verdict}. The plan does not meet its demand.\n")
        console.print(report_table(report), markup=False, soft_wrap=True)
    if target != STANDARD_STREAM:
        console.print(f"Plan: {target}", markup=False, soft_wrap=True)


@app.command()
def compare(
    mission: Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file, YAML or JSON.")],
    methods: Annotated[str | None, typer.Option(metavar="NAME,...", help="tours,parallel,... ; default all.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", metavar="PICTURE", help="Draw them, too.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same plans.")] = 0,
    effort: Annotated[EffortName | None, typer.Option(help="Work to spend; default as the mission says.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
) -> None:
    """Plan a mission by several methods, side by side; exit code 3 when one of them finds no plan."""
    from rota.compare import compare_methods, comparison_table, comparison_to_json, draw_outcomes, named_methods
    from rota.files.mission_file import read_mission
    from rota.interrupt import stop_on_interrupt

    if output is not None:
        _require_suffix(output, (".png", ".svg", ".pdf"))
        _require_target(output, source=mission)
    names, read = named_methods(methods), read_mission(mission)
    for warning in read.warnings:
        _say(f"warning: {warning}")
    asked = read.mission if effort is None else read.mission.with_effort(effort)
    _mention_compiling("planners/patrol/annealing", "geometry", "check")
    with _progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        outcomes = compare_methods(asked, names, seed=seed, progress=bar.show, should_stop=stop)
    told = comparison_to_json(asked, outcomes, seed) if as_json else None
    typer.echo(comparison_table(outcomes) if told is None else json.dumps(told, indent=1))
    if output is not None:
        draw_outcomes(asked, outcomes, output)
    raise typer.Exit(INTERRUPTED if stop.raised else DONE if all(o.met for o in outcomes) else NO_PLAN)


class _Bar:
    """Progress for people: on a terminal only."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._task = None if progress is None else progress.add_task("planning", total=1.0)

    def show(self, fraction: float, doing: str) -> None:
        """What the planner calls."""
        if self._progress is not None and self._task is not None:
            self._progress.update(self._task, completed=fraction, description=doing)

    def announce_stop(self) -> None:
        """What the first Ctrl-C calls."""
        if self._progress is not None:
            self._progress.stop()  # gives the terminal its cursor back before a second Ctrl-C could
        _say("stopping with the best plan so far; Ctrl-C again ends at once")


@contextmanager
def _progress_bar() -> Iterator[_Bar]:
    if not sys.stderr.isatty():
        yield _Bar(None)
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        yield _Bar(progress)


def _mention_compiling(*packages: str) -> None:
    from rota.compiled_cache import is_compiled

    if not is_compiled(*packages):
        _say("compiling, once: about a minute")


# ---------------------------------------------------------------- check, draw, animate, export


PlanPath = Annotated[str, typer.Argument(metavar="PLAN", help="A plan file; - reads stdin.")]


def _read_plan(path: str) -> Plan:
    from rota.files.plan_file import plan_from_text, read_plan

    return plan_from_text(sys.stdin.buffer.read(), "stdin") if path == STANDARD_STREAM else read_plan(path)


@app.command()
def check(
    plan: PlanPath, as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False
) -> None:
    """Check a plan: exit code 0 when every demand is met, 1 when not."""
    from rota.check import check_plan, report_table, report_to_json

    answer = _read_plan(plan)
    _mention_compiling("check")
    report = check_plan(answer)
    typer.echo(json.dumps(report_to_json(report), indent=1) if as_json else report_table(report))
    raise typer.Exit(DONE if report.verdict == "met" else VIOLATED)


@app.command()
def draw(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="PICTURE", help="A .png, .svg or .pdf file.")],
) -> None:
    """Draw a plan and the worst revisit gap of every place."""
    _require_suffix(output, (".png", ".svg", ".pdf"))
    _require_target(output, source=plan)
    answer = _read_plan(plan)
    from rota.draw import draw_plan

    draw_plan(answer, Path(output))


@app.command()
def animate(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="FILM", help="A .gif or .mp4 file (needs ffmpeg).")],
) -> None:
    """Animate a plan: robots moving, what they see, time since last seen."""
    _require_suffix(output, (".gif", ".mp4"))
    _require_target(output, source=plan)
    answer = _read_plan(plan)
    from rota.draw import animate_plan

    animate_plan(answer, Path(output))


@app.command()
def export(
    plan: PlanPath,
    to: Annotated[ExportFormat, typer.Option(help="The format.")],
    output: Annotated[str, typer.Option("-o", "--output", metavar="PATH", help="A file; a folder for qgroundcontrol.")],
) -> None:
    """Export a plan to what maps and robots read."""
    answer = _read_plan(plan)
    if to == "geojson":
        _require_target(output, source=plan)
        _export_geojson(answer, output)
        return
    from rota.files.qgroundcontrol import write_qgroundcontrol

    for path in write_qgroundcontrol(answer, output, autopilot="ardupilot" if to == "qgroundcontrol" else "px4"):
        typer.echo(path)


def _export_geojson(answer: Plan, output: str) -> None:
    from rota.files.geojson import geojson_text, write_geojson

    if answer.mission.origin is None:
        _say("warning: the mission has no origin: coordinates are in local metres, not in WGS84 as maps expect")
    if output == STANDARD_STREAM:
        typer.echo(geojson_text(answer), nl=False)
    else:
        write_geojson(answer, output)


# ---------------------------------------------------------------- new, schema


@app.command()
def new(mission: Annotated[Path, typer.Argument(metavar="MISSION")] = Path("mission.yaml")) -> None:
    """Write a commented example mission to start from."""
    from rota.files.atomic_write import write_atomically
    from rota.files.example_mission import example_mission_text

    if str(mission) == STANDARD_STREAM:
        typer.echo(example_mission_text(), nl=False)
        return
    if os.path.lexists(mission):
        raise RotaError(f"{mission}: exists already and is not overwritten; name another file")
    write_atomically(mission, example_mission_text())
    typer.echo(f"{mission}: edit it, then: rota plan {mission}")


@app.command()
def schema(name: SchemaName) -> None:
    """Print the JSON Schema of a file format."""
    typer.echo(json.dumps(_schema_maker(name)(), indent=1))


def _schema_maker(name: SchemaName) -> Callable[[], dict[str, Any]]:
    if name == "mission":
        from rota.files.mission_file import mission_schema

        return mission_schema
    if name == "plan":
        from rota.files.plan_schema import plan_schema

        return plan_schema
    from rota.check import report_schema

    return report_schema


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"rota {version('rota')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and end.")
    ] = False,
) -> None:
    """Plan timed routes for teams of robots that must keep watching a whole area, and check every plan."""


def _require_suffix(path: str, allowed: tuple[str, ...]) -> None:
    suffix = Path(path).suffix
    if suffix.lower() not in allowed:
        raise RotaError(f"{path}: the extension {suffix!r} is not known here; {', '.join(allowed)} are")


def _require_target(target: str, source: str | Path) -> None:
    """Refuse what is known beforehand not to work, and to overwrite the input."""
    from rota.files.atomic_write import require_writable

    if target == STANDARD_STREAM:
        return
    require_writable(target)
    if os.path.exists(source) and os.path.exists(target) and os.path.samefile(source, target):
        raise RotaError(f"{target}: is the input itself and is not overwritten; name another file")

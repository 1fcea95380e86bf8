"""The command line: arguments to functions, outcomes to exit codes."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer.main import get_command

from rota.check import compiled_packages
from rota.command.arguments import (
    PICTURES,
    ClusterAddress,
    EffortName,
    PlanPath,
    cluster_or_none,
    read_and_warn,
    read_plan_argument,
    require_target,
)
from rota.command.compare import compare
from rota.command.compile import compile_first, compile_kernels
from rota.command.ending import exit_code_of, flush
from rota.command.exit_codes import DONE, VIOLATED
from rota.command.export import FORMATS_HELP, FORMATS_LIST, plan_as_executed, write_export
from rota.command.fly import fly
from rota.command.interrupt import clean_end_on_terminate, saying_when_interrupted
from rota.command.link_option import LINKS_LIST
from rota.command.memory import use_one_heap
from rota.command.other_mission import plan_for_mission
from rota.command.page import page
from rota.command.plan import plan_and_write
from rota.command.registry import Commands
from rota.command.rehearse import rehearse
from rota.command.replan import replan
from rota.command.ros2 import ros2
from rota.command.serve import serve
from rota.command.start import new, schema
from rota.command.straighten import straighten
from rota.command.swarm_processes import swarm_launch, swarm_node
from rota.command.sweep import sweep
from rota.command.terminal import reading_ahead, say
from rota.command.watch import watch
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError
from rota.exports import export_format
from rota.planning.stopping import OwnThread

if TYPE_CHECKING:
    from rota.command.executed import Executed
    from rota.command.flown import ByVehicle
    from rota.model.plan import Plan

app = typer.Typer(
    cls=Commands,
    help="Plan timed routes for teams of robots that must keep watching a whole area, and check every plan.",
    epilog="Exit codes: 0 done, 1 demand not met (check), 2 bad input, 3 no plan found, 70 our fault, 130 Ctrl-C,"
    " 143 SIGTERM, 129 SIGHUP.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
command_line = cache(get_command)  # to read all functions takes as long as many a command


def run(arguments: list[str]) -> int:
    """Run the command line; returns the exit code. All messages to people go to stderr."""
    use_one_heap()
    try:
        with clean_end_on_terminate():
            command_line(app)(arguments, prog_name="rota")
    except (Exception, SystemExit) as end:
        return flush(exit_code_of(end))
    return flush(DONE)


# ---------------------------------------------------------------- plan


@app.command()
def plan(
    mission: Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file, YAML or JSON.")],
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="PLAN", help="The plan file; default MISSION's name with .rota.json; - stdout."
        ),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, metavar="NUMBER", help="The same seed gives the same plan; default 0.")
    ] = None,
    effort: Annotated[
        EffortName | None, typer.Option(metavar="EFFORT", help="quick, normal or high; default as the mission says.")
    ] = None,
    time_limit: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Stop after so long with the best plan so far.")
    ] = None,
    best: Annotated[bool, typer.Option("--best", help="Write the best plan even if it misses its demand.")] = False,
    resume: Annotated[
        str | None, typer.Option(metavar="RUN", help="Go on with a swarm's run that was stopped: its .rota-run file.")
    ] = None,
    metrics: Annotated[
        str | None, typer.Option(metavar="FILE.csv", help="Write what every step of a swarm came to, as a table.")
    ] = None,
    cluster: ClusterAddress = None,
) -> None:
    """Plan a mission, check the plan, and write it."""
    from rota.files.atomic_write import require_suffix
    from rota.files.checkpoint_file import read_checkpoint
    from rota.planning.planner import planner_of

    target = output if output is not None else f"{mission.stem}.rota.json"
    require_target(target, source=mission)
    if resume is not None:
        require_target(target, source=resume)
    if metrics is not None:
        require_suffix(metrics, (".csv",), "a table")
        require_target(metrics, source=mission)
    with ExitStack() as stack:
        with saying_when_interrupted("no plan: the search had not begun"):
            if (long := reading_ahead(mission)) is not None:
                say(long)
            asked = read_and_warn(mission)
            asked = asked if effort is None else asked.with_effort(effort)
            planner = planner_of(asked)
            for long in planner.long_work(asked):
                say(f"this takes long: {long}")
            packages = (*planner.compiled_packages(asked), *compiled_packages(asked))
            checkpoint = None if resume is None else read_checkpoint(resume)
            seed = seed if seed is not None else checkpoint.seed if checkpoint is not None else 0
            stack.enter_context(compile_first(planner, packages))
            executor = stack.enter_context(cluster_or_none(cluster))
            if (left_out := OwnThread(lambda: planner.omission(asked)).do_work()) is not None:
                say(left_out)
        code = plan_and_write(asked, target, seed, time_limit, best, (resume, checkpoint), metrics, executor)
    raise typer.Exit(code)


app.command()(compare)
app.command()(replan)


# ---------------------------------------------------------------- check, draw, animate, export


@app.command()
def check(
    plan: PlanPath,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    mission: Annotated[
        Path | None,
        typer.Option(metavar="MISSION", help="Judge the plan for this mission file, not for the mission in the plan."),
    ] = None,
    executed: Annotated[
        str | None,
        typer.Option(metavar="FORMAT", help="Check the plan as the files of rota export --to FORMAT drive it."),
    ] = None,
    in_phase_every: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="With --executed: robots are brought into phase anew so often."),
    ] = None,
    origin: Annotated[
        str | None, typer.Option(metavar="LAT,LON", help="With --executed: where x = y = 0 lies, as in rota export.")
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="With --executed: as the firmware of arducopter or arducopter-tuned flies."),
    ] = None,
    wind: Annotated[
        str | None,
        typer.Option(metavar="M_S[,FROM_DEG]", help="With --vehicle: wind, from where (90: east) or anywhere."),
    ] = None,
) -> None:
    """Check a plan: exit code 0 when all is met, 1 when not."""
    from rota.check import check_plan, margins_of
    from rota.command.executed import AsPlanned
    from rota.command.flown import fly_by, worst_flight

    answer = read_plan_argument(plan)
    if mission is not None:
        answer = plan_for_mission(answer, mission)
    made: AsPlanned | Executed | ByVehicle = AsPlanned(plan=answer)
    flights: tuple[ByVehicle, ...] = ()
    if executed is None:
        given = {"--vehicle": vehicle, "--in-phase-every": in_phase_every, "--origin": origin, "--wind": wind}
        if (option := next((name for name, value in given.items() if value is not None), None)) is not None:
            raise RotaError(f"{option}: is for --executed only")
    elif vehicle is not None:
        flights = fly_by(answer, executed, vehicle, wind, in_phase_every, origin)
    elif wind is not None:
        raise RotaError("--wind: is for --vehicle only")
    else:
        made = plan_as_executed(answer, executed, in_phase_every, origin)
    mention_compiling(*compiled_packages(answer.mission))
    with saying_when_interrupted("the plan is not checked to the end"):
        reports = OwnThread(lambda: [check_plan(each.plan) for each in flights or (made,)]).do_work()
    made, report = worst_flight(flights, reports) if flights else (made, reports[0])
    report = replace(report, margins=margins_of(made.plan, report))
    typer.echo(json.dumps(made.to_json(report), indent=1) if as_json else made.text(report))
    for remark in made.remarks(answer, report):
        say(remark)
    raise typer.Exit(DONE if report.verdict == "met" else VIOLATED)


app.command()(straighten)
app.command()(rehearse)


@app.command()
def draw(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="PICTURE", help="A .png, .svg or .pdf file.")],
    cells: Annotated[
        bool, typer.Option("--cells", help="Of bouncing robots: headings in each cell, and times entered.")
    ] = False,
) -> None:
    """Draw a plan and the worst revisit gap of every place."""
    answer = _plan_to_show(plan, output, PICTURES, "a picture")
    from rota.draw import draw_cells, draw_plan

    if cells:
        draw_cells(answer, output)
    else:
        mention_compiling(*compiled_packages(answer.mission))
        draw_plan(answer, output)
    typer.echo(output)


@app.command()
def animate(
    plan: PlanPath,
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="FILM", help="A .gif file, or .mp4 with ffmpeg on the path.")
    ],
    seconds: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="The film's length; default about 12, for one round.")
    ] = None,
    fps: Annotated[
        int | None, typer.Option(metavar="FRAMES", help="Frames per second; default 8 for .gif, 20 for .mp4.")
    ] = None,
) -> None:
    """Animate a plan: robots, and the time since last seen."""
    answer = _plan_to_show(plan, output, (".gif", ".mp4"), "a film")
    from rota.draw import animate_plan

    animate_plan(answer, output, seconds=seconds, fps=fps)
    typer.echo(output)


def _plan_to_show(plan: str, output: str, suffixes: tuple[str, ...], what: str) -> Plan:
    """The plan, once it is clear that ``output`` can be written and is ``what`` by its suffix."""
    from rota.files.atomic_write import require_suffix

    require_suffix(output, suffixes, what)
    require_target(output, source=plan)
    return read_plan_argument(plan)


@app.command(epilog=FORMATS_LIST)
def export(
    plan: PlanPath,
    to: Annotated[str, typer.Option(parser=export_format, metavar="FORMAT", help=FORMATS_HELP)],
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="PATH", help="A file; a folder where each robot has one.")
    ],
    origin: Annotated[
        str | None, typer.Option(metavar="LAT,LON", help="Where x = y = 0 lies, for a mission that does not say it.")
    ] = None,
    start_time: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="When robots start, in ISO 8601, for formats with a clock; default 2000-01-01T00:00Z."
        ),
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A setting of dji-wpml or vda5050.")
    ] = None,
) -> None:
    """Export a plan to what maps and robots read."""
    answer = read_plan_argument(plan)
    for path in write_export(answer, plan, to, output, origin=origin, start_time=start_time, settings=settings or ()):
        typer.echo(path)


app.command()(page)
app.command()(ros2)
app.command("swarm-node")(swarm_node)
app.command("swarm-launch")(swarm_launch)
app.command(epilog=LINKS_LIST)(fly)
app.command(epilog=LINKS_LIST)(watch)
app.command()(serve)
app.command()(sweep)
app.command()(new)
app.command()(schema)
app.command("compile")(compile_kernels)


# ---------------------------------------------------------------- the program as a whole


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
    """Options of the program as a whole."""

"""`rota compare`: a mission by several methods, side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from rota.command.arguments import PICTURES, EffortName, read_and_warn, require_target
from rota.command.exit_codes import DONE, NO_PLAN
from rota.command.interrupt import stop_on_interrupt
from rota.command.terminal import progress_bar
from rota.compiled.compiled_cache import mention_compiling


def compare(
    mission: Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file, YAML or JSON.")],
    methods: Annotated[str | None, typer.Option(metavar="NAME,...", help="tours,parallel,... ; default all.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", metavar="PICTURE", help="Draw them, too.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same plans.")] = 0,
    effort: Annotated[EffortName | None, typer.Option(help="Work to spend; default as the mission says.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
) -> None:
    """Plan a mission by several methods, side by side."""
    from rota.compare import compare_methods, comparison_table, comparison_to_json, draw_outcomes, named_methods
    from rota.files.atomic_write import require_suffix
    from rota.planning.planner import planner_of

    if output is not None:
        require_suffix(output, PICTURES, "a picture")
        require_target(output, source=mission)
    asked = read_and_warn(mission)
    asked = asked if effort is None else asked.with_effort(effort)
    names = named_methods(asked, methods)
    mention_compiling(*planner_of(asked).compiled_packages(asked), "check")
    with progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        outcomes = compare_methods(asked, names, seed=seed, progress=bar.show, should_stop=stop)
    told = comparison_to_json(asked, outcomes, seed) if as_json else None
    typer.echo(comparison_table(outcomes) if told is None else json.dumps(told, indent=1))
    if output is not None:
        draw_outcomes(asked, outcomes, output)
    raise typer.Exit(stop.exit_code or (DONE if all(o.met for o in outcomes) else NO_PLAN))

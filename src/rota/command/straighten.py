"""`rota straighten`: a plan without the points on straight ways, at which autopilots slow down."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rota.check import compiled_packages
from rota.command.arguments import PlanPath, read_plan_argument, require_target
from rota.command.exit_codes import DONE, VIOLATED
from rota.command.interrupt import saying_when_interrupted
from rota.command.plan import write_or_print
from rota.command.terminal import say
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError
from rota.planning.stopping import OwnThread

if TYPE_CHECKING:
    from rota.model.plan import Plan

TRIED_M = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)


def straighten(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="PLAN", help="The plan file to write; - stdout.")],
    within_m: Annotated[
        float | None,
        typer.Option(
            "--within-m",
            metavar="M",
            help="How far robots may be off; default as far as all stays met, up to 1.",
        ),
    ] = None,
) -> None:
    """Leave out the points of a plan on straight ways."""
    from rota.check import check_plan
    from rota.vehicles.straight_ways import straighten_ways

    require_target(output, source=plan)
    answer = read_plan_argument(plan)
    tried_m = TRIED_M if within_m is None else (within_m,)
    mention_compiling(*compiled_packages(answer.mission))
    with saying_when_interrupted("no plan: it is not checked to the end"):
        for off_m in tried_m:
            made = straighten_ways(answer, off_m)
            verdict = OwnThread(partial(check_plan, made)).do_work().verdict
            if verdict == "met":
                break
    if verdict != "met" and within_m is None:
        raise RotaError(
            f"{plan}: not met within {off_m:g} m of its ways, either: rota check says what it misses, and --within-m"
            " takes points away all the same"
        )
    write_or_print(made, output, meets_demand=verdict == "met")
    say(f"{_points(answer)} points become {_points(made)}, at any moment within {off_m:g} m: {verdict}")
    raise typer.Exit(DONE if verdict == "met" else VIOLATED)


def _points(plan: Plan) -> int:
    return sum(len(trajectory.times_s) for trajectory in plan)

"""`rota rehearse`: a plan driven in many runs in which things go wrong."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from rota.command.arguments import (
    PICTURES,
    ClusterAddress,
    PlanPath,
    cluster_or_none,
    read_plan_argument,
    require_target,
    wind_given,
)
from rota.command.exit_codes import DONE
from rota.command.interrupt import saying_when_interrupted
from rota.command.terminal import progress_bar
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import MissionError, RotaError
from rota.planning.stopping import OwnThread

OPTIONS = {
    "wind_m_s": "wind",
    "wind_from_deg": "wind",
    "late_relief_s": "late-relief",
}  # of what is asked, where they are called otherwise


def rehearse(
    plan: PlanPath,
    hours: Annotated[float, typer.Option(metavar="HOURS", help="How long each run is.")] = 24.0,
    runs: Annotated[int, typer.Option(metavar="NUMBER", help="How many; all differ by chance alone.")] = 100,
    failures: Annotated[
        float,
        typer.Option("--failures-per-hour", metavar="NUMBER", help="Of each robot, which then stands and is blind."),
    ] = 0.0,
    noise: Annotated[
        str, typer.Option("--speed-noise", metavar="SHARE", help="By how much speeds vary, such as 5%.")
    ] = "0",
    wind: Annotated[
        str, typer.Option(metavar="M_S[,FROM_DEG]", help="Wind, from where (90: east) or in each run from elsewhere.")
    ] = "0",
    late_relief: Annotated[
        float, typer.Option("--late-relief", metavar="S", help="By how much robots leave chargers late, in the mean.")
    ] = 0.0,
    hands_off: Annotated[
        bool, typer.Option("--hands-off", help="Nobody keeps robots in phase, as rota fly does otherwise.")
    ] = False,
    replan: Annotated[
        bool, typer.Option("--replan", help="When a robot fails, let a plan for those that remain take over.")
    ] = False,
    seed: Annotated[int, typer.Option(metavar="NUMBER", help="The same seed gives the same runs.")] = 0,
    output: Annotated[str | None, typer.Option("-o", "--output", metavar="PICTURE", help="Draw it, too.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the outcome as JSON.")] = False,
    cluster: ClusterAddress = None,
) -> None:
    """Rehearse a plan with robots that fail or are late."""
    from rota.check import compiled_packages
    from rota.files.atomic_write import require_suffix
    from rota.rehearsal import draw_rehearsal, rehearsal_table, rehearsal_to_json, rehearse as rehearse_plan

    if output is not None:
        require_suffix(output, PICTURES, "a picture")
        require_target(output, source=plan)
    speed_noise, (wind_m_s, wind_from_deg) = _share(noise), wind_given(wind, "in each run from elsewhere")
    answer = read_plan_argument(plan)
    mention_compiling("rehearsal", "live", "check", *(compiled_packages(answer.mission) if replan else ()))
    with (
        saying_when_interrupted("the plan is not rehearsed to the end"),
        progress_bar() as bar,
        cluster_or_none(cluster) as executor,
    ):
        try:
            made = OwnThread(
                lambda: rehearse_plan(
                    answer, hours=hours, failures_per_hour=failures, speed_noise=speed_noise, wind_m_s=wind_m_s,
                    wind_from_deg=wind_from_deg, late_relief_s=late_relief, hands_off=hands_off, replan=replan,
                    runs=runs, seed=seed, executor=executor, progress=bar.show,
                )
            ).do_work()  # fmt: skip
        except MissionError as error:
            raise RotaError(_by_option(str(error))) from None
    typer.echo(json.dumps(rehearsal_to_json(made), indent=1) if as_json else rehearsal_table(made))
    if output is not None:
        draw_rehearsal(answer, made, output)
    raise typer.Exit(DONE)


def _share(text: str) -> float:
    """The share that a text such as 5% or 0.05 says."""
    try:
        return float(text[:-1]) / 100 if text.endswith("%") else float(text)
    except ValueError:
        raise RotaError(f"--speed-noise: {text!r} is not allowed; a share is needed, such as 5% or 0.05") from None


def _by_option(message: str) -> str:
    """What is said of a value, by the option that gives it."""
    name, colon, rest = message.partition(":")
    return f"--{OPTIONS.get(name, name).replace('_', '-')}{colon}{rest}"

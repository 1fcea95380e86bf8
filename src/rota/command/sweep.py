"""`rota sweep`: many missions, planners, settings and seeds, planned and checked into one table."""

from __future__ import annotations

import shlex
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.arguments import ClusterAddress
from rota.command.exit_codes import DONE, NO_PLAN
from rota.command.terminal import Bar, progress_bar, say
from rota.errors import RotaError
from rota.planning.planner import about

if TYPE_CHECKING:
    from rota.sweep.cells import Cell
    from rota.sweep.results import Results
    from rota.sweep.run import Standing

SAY_EVERY_S = 60.0  # where no terminal shows a bar


def sweep(
    sweep_file: Annotated[Path, typer.Argument(metavar="SWEEP", help="A sweep file, YAML or JSON.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="The folder of results.")],
    processes: Annotated[
        int | None, typer.Option(min=1, metavar="NUMBER", help="Processes on this machine; default one for each core.")
    ] = None,
    cluster: ClusterAddress = None,
    retry: Annotated[bool, typer.Option("--retry", help="Plan cells again that crashed or were killed.")] = False,
) -> None:
    """Plan missions by settings and seeds into one table."""
    if find_spec("pyarrow") is None:
        raise RotaError("rota sweep needs pyarrow: pip install 'rota[sweep]'")
    if cluster is not None and processes is not None:
        raise RotaError("--processes: is for this machine; the cluster has its own workers")
    from rota.command.interrupt import stop_on_interrupt
    from rota.engines.workers import workers
    from rota.files.sweep_file import read_sweep
    from rota.sweep.cells import cells_of
    from rota.sweep.results import Results
    from rota.sweep.run import run_sweep

    read = read_sweep(sweep_file)
    cells = cells_of(read)
    _say_refused(cells, sweep_file)
    results = Results(output)
    try:
        before = sum(results.has(cell, retry=retry) for cell in cells)
        if before:
            say(f"{before} of {len(cells)} cells are finished already")
        with (
            progress_bar() as bar,
            stop_on_interrupt(lambda by: bar.announce_stop(by, "with the cells that are finished")) as stop,
            workers(cluster, processes) as executor,
        ):
            whole = run_sweep(
                read.file.name, cells, results, executor, retry=retry,
                first_alone=cluster is None and not _is_compiled(cells), tell=_Teller(bar), should_stop=stop,
            )  # fmt: skip
        _write_outcome(results, cells)
        if not whole:
            say(f"interrupted: {len(results.rows(cells))} of {len(cells)} cells are finished; to go on:")
            say(shlex.join(["rota", *sys.argv[1:]]))
        met = all(row["met"] for row in results.rows(cells))
    finally:
        results.close()
    raise typer.Exit(stop.exit_code or (DONE if met else NO_PLAN))


class _Teller:
    """How far it is: on a terminal as a bar, elsewhere as a line now and then."""

    def __init__(self, bar: Bar) -> None:
        self._bar, self._said_s = bar, time.monotonic()

    def __call__(self, standing: Standing) -> None:
        left = "" if standing.left_s is None else f", about {about(standing.left_s)} left"
        failed = f", {standing.failed} without a plan" if standing.failed else ""
        busy = f" on {standing.workers} workers" if standing.workers else ", waiting for a worker to join"
        told = f"{standing.finished} of {standing.cells} cells{failed}{busy}{left}"
        self._bar.show(standing.finished / max(1, standing.cells), told)
        now_s = time.monotonic()
        if not sys.stderr.isatty() and now_s - self._said_s >= SAY_EVERY_S:
            self._said_s = now_s
            say(told)


def _say_refused(cells: list[Cell], path: Path) -> None:
    """Say which missions are refused, and why; RotaError when all are."""
    refused = {cell.combination.label: cell.combination.refused for cell in cells if cell.combination.mission is None}
    if refused and all(cell.combination.mission is None for cell in cells):
        reasons = dict.fromkeys(line for reason in refused.values() for line in str(reason).splitlines())
        raise RotaError("\n".join([f"{path}: no mission can be planned:", *reasons]))
    for label, reason in refused.items():
        say(f"refused: {label}: {reason}")


def _is_compiled(cells: list[Cell]) -> bool:
    """Whether the loops of all planners of the sweep are compiled."""
    from rota.compiled.compiled_cache import is_compiled
    from rota.planning.planner import planner_of

    missions = {id(cell.combination): cell.combination.mission for cell in cells}.values()
    packages = {
        package for each in missions if each is not None for package in planner_of(each).compiled_packages(each)
    }
    return is_compiled(*sorted(packages))


def _write_outcome(results: Results, cells: list[Cell]) -> None:
    """The table, the summary and the pictures of what is finished."""
    from rota.files.atomic_write import write_atomically
    from rota.sweep.results import TABLE
    from rota.sweep.summary import summaries, summary_csv, summary_table

    results.write_table(cells)
    found = summaries(results.rows(cells))
    if not found:
        return
    write_atomically(results.folder / "summary.csv", summary_csv(found))
    typer.echo(summary_table(found))
    typer.echo("\nMeans over the seeds that met their demand ± Student's 95 % interval.")
    written = [TABLE, "summary.csv"]
    if any(each.means for each in found):
        from rota.draw import draw_sweep

        written += draw_sweep(found, results.folder)
    typer.echo(f"{results.folder}: {', '.join(written)}")

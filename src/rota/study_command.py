"""``rota study``: the part of the command line that runs studies."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rota.exit_codes import DONE, INTERRUPTED, NO_PLAN
from rota.terminal import mention_compiling, progress_bar, say

if TYPE_CHECKING:
    from rota.mission import Mission
    from rota.studies.study import Study

app = typer.Typer(help="Run a study of how the planners do.", no_args_is_help=True, rich_markup_mode=None)


@app.command("patrol-progress")
def patrol_progress(
    mission: Annotated[
        Path | None, typer.Argument(metavar="MISSION", help="A mission file; default Sun 2019's map.")
    ] = None,
    output: Annotated[
        list[str] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="A picture (.png, .svg, .pdf) or numbers (.csv, .json); repeatable.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="NUMBER", help="The same seed gives the same search.")] = 0,
    effort: Annotated[
        Literal["quick", "normal", "high"] | None,
        typer.Option(metavar="EFFORT", help="quick, normal or high; default as the mission says."),
    ] = None,
) -> None:
    """Anytime curve: unseen ground and robots of the best plan so far, by seconds."""
    from rota.files.atomic_write import require_suffix, require_target
    from rota.interrupt import stop_on_interrupt
    from rota.studies.patrol_progress import OUTPUTS, patrol_progress, progress_table, write_progress

    for path in output or []:
        require_suffix(path, OUTPUTS, "a progress curve")
        require_target(path, source=mission)
    asked = _mission(mission)
    asked = asked if effort is None else asked.with_effort(effort)
    mention_compiling("planners/patrol/annealing", "geometry", "check")
    with progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        found = patrol_progress(asked, seed=seed, progress=bar.show, should_stop=stop)
    typer.echo(progress_table(found))
    for path in output or []:
        write_progress(found, path)
        typer.echo(path)
    raise typer.Exit(INTERRUPTED if stop.raised else DONE if found.reason is None else NO_PLAN)


@app.command("sun2019", short_help="The figures and tables of Sun 2019, ours beside the paper's.")
def sun2019(
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FOLDER",
            help="Write the page (sun2019.md) and its pictures there; default: only print the tables.",
        ),
    ] = None,
    figures: Annotated[
        str | None, typer.Option(metavar="NUMBER,...", help="6,8,12,13,14,15,16: make only some; default all.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="NUMBER", help="The same seed gives the same page.")] = 0,
    effort: Annotated[
        Literal["quick", "normal", "high"],
        typer.Option(metavar="EFFORT", help="quick, normal or high, of sun2019 and tours."),
    ] = "quick",
) -> None:
    """Sun et al. 2019, figure by figure: the paper's numbers beside those of its method and of ours.

    Takes some minutes; Figures 14 and 16 take most of them. Table 5 comes with Figure 13, Table 6 with 14, Table 8 with
    16. Ctrl-C writes nothing.
    """
    from rota.studies.study import listed_figures, require_study_folder
    from rota.studies.sun2019.runs import StudySettings
    from rota.studies.sun2019.study import FIGURES, PAGE, PICTURES, sun2019_study

    asked = listed_figures(figures, FIGURES)
    if output is not None:
        require_study_folder(output, PAGE, PICTURES)
    mention_compiling("planners/patrol/annealing", "geometry", "check")
    settings = StudySettings(effort=effort)
    _tell_study(
        lambda tell, stop: sun2019_study(asked, settings=settings, seed=seed, progress=tell, should_stop=stop), output
    )


@app.command("chen2018", short_help="The figures and tables of Chen 2018, ours beside the paper's.")
def chen2018(
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FOLDER",
            help="Write the page (chen2018.md) and its pictures there; default: only print the tables.",
        ),
    ] = None,
    figures: Annotated[
        str | None, typer.Option(metavar="NUMBER,...", help="9,11,12,...,21: make only some; default all.")
    ] = None,
    seed: Annotated[
        int, typer.Option(min=0, metavar="NUMBER", help="The same seed gives the same page but for measured times.")
    ] = 0,
) -> None:
    """Chen et al. 2018, figure by figure: what the paper says beside its controller, its baselines and ours.

    Takes some minutes; Figures 20 and 21 take most of them. Table 2 comes with Figure 12, Table 3 with 20. Ctrl-C
    writes nothing.
    """
    from rota.studies.chen2018.study import FIGURES, PAGE, PICTURES, chen2018_study
    from rota.studies.study import listed_figures, require_study_folder

    asked = listed_figures(figures, FIGURES)
    if output is not None:
        require_study_folder(output, PAGE, PICTURES)
    mention_compiling("planners/swarm")
    _tell_study(lambda tell, stop: chen2018_study(asked, seed=seed, progress=tell, should_stop=stop), output)


@app.command("alam2020", short_help="The figures of Alam & Bobadilla 2020 on maps of the same kind.")
def alam2020(
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FOLDER",
            help="Write the page (alam2020.md) and its pictures there; default: only print the tables.",
        ),
    ] = None,
    figures: Annotated[
        str | None,
        typer.Option(metavar="NUMBER,...", help="6,7,...,11, and 12,13 beyond the paper: make only some; default all."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="NUMBER", help="The same seed gives the same page.")] = 0,
) -> None:
    """Alam & Bobadilla 2020, figure by figure: what the paper says beside its algorithms and ours.

    Its maps are not published; ours are of the same size and kind. 12: robots that turn inexactly. 13: polygons without
    a grid. Ctrl-C writes nothing.
    """
    from rota.studies.alam2020.study import FIGURES, PAGE, PICTURES, alam2020_study
    from rota.studies.study import listed_figures, require_study_folder

    asked = listed_figures(figures, FIGURES)
    if output is not None:
        require_study_folder(output, PAGE, PICTURES)
    mention_compiling("planners/bounce")
    _tell_study(lambda tell, stop: alam2020_study(asked, seed=seed, progress=tell, should_stop=stop), output)


def _tell_study(make: Callable[[Callable[[float, str], None], Callable[[], bool]], Study], output: Path | None) -> None:
    """Make a study, given what to tell of its progress and what says when to stop; print its tables and write it."""
    from rota.interrupt import stop_on_interrupt
    from rota.studies.study import StudyStopped, write_study

    with progress_bar() as bar, stop_on_interrupt(lambda: bar.announce_stop("with nothing written")) as stop:
        try:
            study = make(bar.show, stop)
        except StudyStopped:
            raise typer.Exit(INTERRUPTED) from None
        # within the block, so that Ctrl-C does not leave half of the files
        written = () if output is None else write_study(study, output)
    typer.echo(study.tables_text)
    for path in written:
        typer.echo(path)


def _mission(path: Path | None) -> Mission:
    if path is None:
        from rota.studies.sun2019 import figure_13

        return figure_13()
    from rota.files.mission_file import read_mission

    read = read_mission(path)
    for warning in read.warnings:
        say(f"warning: {warning}")
    return read.mission

"""``rota study``: the part of the command line that runs studies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from rota.command.exit_codes import DONE, NO_PLAN
from rota.command.terminal import progress_bar, say
from rota.compiled.compiled_cache import mention_compiling
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.model.mission import Mission
    from rota_studies.study import AnyRuns, AnySettings, PaperStudy

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
    from rota.command.interrupt import stop_on_interrupt
    from rota.files.atomic_write import require_suffix, require_target
    from rota_studies.patrol_progress import OUTPUTS, patrol_progress, progress_table, write_progress

    for path in output or []:
        require_suffix(path, OUTPUTS, "a progress curve")
        require_target(path, source=mission)
    asked = _mission(mission)
    asked = asked if effort is None else asked.with_effort(effort)
    mention_compiling("planners/patrol/annealing", "geometry", "check")
    with progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        search = patrol_progress(asked, seed=seed, progress=bar.show, should_stop=stop)
    typer.echo(progress_table(search))
    for path in output or []:
        write_progress(search, path)
        typer.echo(path)
    raise typer.Exit(stop.exit_code or (DONE if search.reason is None else NO_PLAN))


Folder = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FOLDER",
        help="Write the page there, its pictures and its records (PAPER.md, .json); default: only print the tables.",
    ),
]
Seed = Annotated[int, typer.Option(min=0, metavar="NUMBER", help="The first seed; the same gives the same page.")]
RecordsOf = Annotated[
    Path | None,
    typer.Option(
        "--from", metavar="RECORDS", help="Make the page from the records of earlier runs (PAPER.json), without a run."
    ),
]
Also = Annotated[
    list[str] | None,
    typer.Option(
        "--also",
        metavar="FORMAT",
        help="Write figures as svg or pdf, tables and curves as csv, all that figures hold as json; repeatable.",
    ),
]


def _some(figures: str) -> Any:
    """The option that chooses among a study's figures."""
    return typer.Option(metavar="NUMBER,...", help=f"{figures}: make only some; default all.")


@app.command("sun2019", short_help="The figures and tables of Sun 2019, ours beside the paper's.")
def sun2019(
    output: Folder = None,
    records: RecordsOf = None,
    figures: Annotated[str | None, _some("6,8,12,13,14,15,16")] = None,
    seed: Seed = 0,
    effort: Annotated[
        Literal["quick", "normal", "high"],
        typer.Option(metavar="EFFORT", help="quick, normal or high, of all methods."),
    ] = "quick",
    also: Also = None,
) -> None:
    """Sun et al. 2019, claim by claim and figure by figure: its numbers beside those of its method and of ours.

    Takes about half an hour; Figures 13 and 14 take most of it. Table 5 comes with Figure 13, Table 6 with 14, Table 8
    with 16. Ctrl-C writes nothing.
    """
    from rota_studies.sun2019.runs import StudySettings
    from rota_studies.sun2019.study import sun2019_study

    compiled = ("planners/patrol/annealing", "geometry", "check")
    asked = _Asked(figures=figures, output=output, records=records, also=tuple(also or ()), seed=seed)
    _tell_study(sun2019_study, asked, compiled, settings=StudySettings(effort=effort))


@app.command("chen2018", short_help="The figures and tables of Chen 2018, ours beside the paper's.")
def chen2018(
    output: Folder = None,
    records: RecordsOf = None,
    figures: Annotated[str | None, _some("9,11,12,...,24")] = None,
    seed: Seed = 0,
    also: Also = None,
) -> None:
    """Chen et al. 2018, figure by figure: what the paper says beside its controller, its baselines and ours.

    Takes some minutes; Figures 20 and 21 take most of them. Table 2 comes with Figure 12, Table 3 with 20. Times of
    decisions and runs of processes differ with the same seed. Ctrl-C writes nothing.
    """
    from rota_studies.chen2018.study import chen2018_study

    asked = _Asked(figures=figures, output=output, records=records, also=tuple(also or ()), seed=seed)
    _tell_study(chen2018_study, asked, ("planners/swarm",))


@app.command("alam2020", short_help="The figures of Alam & Bobadilla 2020 on maps of the same kind.")
def alam2020(
    output: Folder = None,
    records: RecordsOf = None,
    figures: Annotated[str | None, _some("6,7,...,11, and 12,13 beyond the paper")] = None,
    seed: Seed = 0,
    also: Also = None,
) -> None:
    """Alam & Bobadilla 2020, figure by figure: what the paper says beside its algorithms and ours.

    Its maps are not published; ours are of the same size and kind. 12: robots that turn inexactly. 13: polygons without
    a grid. Ctrl-C writes nothing.
    """
    from rota_studies.alam2020.study import alam2020_study

    asked = _Asked(figures=figures, output=output, records=records, also=tuple(also or ()), seed=seed)
    _tell_study(alam2020_study, asked, ("planners/bounce",))


class _Asked(NamedTuple):
    """What a user asks of a study, as the command line has it."""

    figures: str | None
    output: Path | None
    records: Path | None
    also: tuple[str, ...]
    seed: int


def _tell_study(
    make: PaperStudy[AnySettings, AnyRuns],
    asked: _Asked,
    compiled: tuple[str, ...],
    *,
    settings: AnySettings | None = None,
) -> None:
    """Make the listed figures of a study, print their tables and write them to a folder, where one is given.

    compiled: packages whose loops it needs. settings: None for those of the page in docs.
    """
    from rota.command.interrupt import stop_on_interrupt
    from rota_studies.figure_data import FORMS
    from rota_studies.study import listed_figures, require_study_folder, write_study
    from rota_studies.study_runs import StudyStopped
    from rota_studies.tables import joined

    chosen = listed_figures(asked.figures, make.figures)
    for form in asked.also:
        if form not in FORMS:
            raise RotaError(f"--also: {form!r} is not allowed; must be {joined(list(FORMS), 'or')}")
    if asked.also and asked.output is None:
        raise RotaError(f"--also {asked.also[0]}: files need a folder; give one with -o FOLDER")
    if asked.output is not None:
        require_study_folder(asked.output, make.name)
    if asked.records is not None:
        study = make.from_records(asked.records, chosen)
        written = () if asked.output is None else write_study(study, asked.output, asked.also)
        _tell(study.tables_text, written)
        return
    mention_compiling(*compiled)
    with progress_bar() as bar, stop_on_interrupt(lambda by: bar.announce_stop(by, "with nothing written")) as stop:
        try:
            study = make(chosen, settings=settings, seed=asked.seed, progress=bar.show, should_stop=stop)
        except StudyStopped:
            raise typer.Exit(stop.exit_code) from None
        # within the block, so that Ctrl-C does not leave half of the files
        written = () if asked.output is None else write_study(study, asked.output, asked.also)
    _tell(study.tables_text, written)


def _tell(tables: str, written: Sequence[Path]) -> None:
    """Print what was made."""
    typer.echo(tables)
    for path in written:
        typer.echo(path)


def _mission(path: Path | None) -> Mission:
    """The mission of a file, or the map of Sun 2019's Figure 13."""
    if path is None:
        from rota_studies.sun2019 import figure_13

        return figure_13()
    from rota.files.mission_file import read_mission

    read = read_mission(path)
    for warning in read.warnings:
        say(f"warning: {warning}")
    return read.mission

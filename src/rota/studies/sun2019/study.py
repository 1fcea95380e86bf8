"""The whole study: the figures that are asked for, made from one set of runs, and written to a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_writable, require_writable_folder
from rota.studies.sun2019.page import page_markdown
from rota.studies.sun2019.result_figures import figure_13_section, figure_14_section, figure_16_section
from rota.studies.sun2019.runs import Runs, StudySettings
from rota.studies.sun2019.section import Section
from rota.studies.sun2019.stage_figures import (
    figure_6_section,
    figure_8_section,
    figure_12_section,
    figure_15_section,
)
from rota.studies.sun2019.tables import joined

PAGE, PICTURES = "sun2019.md", "figure-*.png"
# of a figure, and about how many parts of the whole work it is
FIGURES: dict[int, tuple[Callable[[Runs], Section], float]] = {
    6: (figure_6_section, 8),
    8: (figure_8_section, 6),
    12: (figure_12_section, 6),
    13: (figure_13_section, 20),
    14: (figure_14_section, 150),
    15: (figure_15_section, 1),
    16: (figure_16_section, 30),
}


@dataclass(frozen=True, kw_only=True)
class Study:
    """The sections in the order of the figures, and the page that holds them."""

    sections: tuple[Section, ...]
    page: str

    @property
    def tables_text(self) -> str:
        """All tables as plain text."""
        return "\n\n".join(table.text for section in self.sections for table in section.tables)

    @property
    def files(self) -> dict[str, bytes]:
        """Name and bytes of every file: pictures first, the page that shows them last."""
        found = {picture.file: picture.png for section in self.sections for picture in section.pictures}
        return found | {PAGE: self.page.encode()}


def named_figures(listed: str | None) -> tuple[int, ...]:
    """The figures of a list of numbers with commas, in their order; all for None. Raises RotaError for another one."""
    if listed is None:
        return tuple(FIGURES)
    known = joined([str(figure) for figure in FIGURES])
    names = [name.strip() for name in listed.split(",")]
    for name in names:
        if not name.isdecimal() or int(name) not in FIGURES:
            raise RotaError(f"figures: {name!r} is none of them; {known} are")
    return tuple(figure for figure in FIGURES if figure in {int(name) for name in names})


def sun2019_study(
    figures: tuple[int, ...] = tuple(FIGURES),
    *,
    settings: StudySettings | None = None,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Study:
    """Make the figures and tables of Sun et al. 2019 again: the paper's numbers beside ours.

    figures: numbers out of ``FIGURES``. settings: None for the tables of the paper. seed: the same seed gives the same
    study. progress: called with a fraction 0..1 and what is being done. should_stop: asked before every run and within
    searches; raises StudyStopped when it says so, since a study of half the runs is none.
    """
    settings = settings or StudySettings()
    tell = progress or (lambda fraction, doing: None)
    whole = sum(FIGURES[figure][1] for figure in figures)
    done = 0.0
    runs = Runs(
        settings,
        seed=seed,
        tell=lambda doing: tell(done / whole, doing),
        should_stop=should_stop or (lambda: False),
    )
    sections = []
    for figure in figures:
        make, share = FIGURES[figure]
        sections.append(make(runs))
        done += share
    page = page_markdown(sections, seed=seed, effort=settings.effort)
    return Study(sections=tuple(sections), page=page)


def require_study_folder(folder: str | Path) -> None:
    """Raise RotaError when it is already known that the study cannot be written there; asked before long work."""
    require_writable_folder(folder)
    for name in (PAGE, *(found.name for found in Path(folder).glob(PICTURES))):
        if (Path(folder) / name).exists():
            require_writable(Path(folder) / name)


def write_study(study: Study, folder: str | Path) -> tuple[Path, ...]:
    """Write the page and its pictures into ``folder``, which is made when it is missing; returns what was written.

    Each file appears whole or not at all, the page last. Other files in the folder stay. Raises RotaError when it
    cannot be written.
    """
    require_writable_folder(folder)
    folder = Path(folder)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise RotaError(f"{folder}: cannot be made: {error.strerror or error}") from error
    for name, data in study.files.items():
        with replaced_file(folder / name) as partial:
            partial.write_bytes(data)
    return tuple(folder / name for name in study.files)

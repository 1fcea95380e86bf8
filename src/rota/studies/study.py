"""A paper's study: the figures that are asked for, made one after the other, and written to a folder with a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_writable, require_writable_folder
from rota.studies.section import Section
from rota.studies.tables import joined

AnyRuns = TypeVar("AnyRuns")
# how a figure is made from runs, and about how many parts of the whole work it is
Makers = Mapping[int, tuple[Callable[[AnyRuns], Section], float]]


class StudyStopped(Exception):  # noqa: N818 (no fault: somebody asked for it)
    """The study was asked to stop before its end; nothing is written of it."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """The sections in the order of the figures, and the page that holds them, under its file's name."""

    sections: tuple[Section, ...]
    page_file: str
    page: str

    @property
    def tables_text(self) -> str:
        """All tables as plain text."""
        return "\n\n".join(table.text for section in self.sections for table in section.tables)

    @property
    def files(self) -> dict[str, bytes]:
        """Name and bytes of every file: pictures first, the page that shows them last."""
        found = {picture.file: picture.png for section in self.sections for picture in section.pictures}
        return found | {self.page_file: self.page.encode()}


def listed_figures(listed: str | None, known: Makers[AnyRuns]) -> tuple[int, ...]:
    """The figures of a list of numbers with commas, in their order; all for None. Raises RotaError for another one."""
    if listed is None:
        return tuple(known)
    allowed = joined([str(figure) for figure in known])
    names = [name.strip() for name in listed.split(",")]
    for name in names:
        if not name.isdecimal() or int(name) not in known:
            raise RotaError(f"figures: {name!r} is none of them; {allowed} are")
    return tuple(figure for figure in known if figure in {int(name) for name in names})


def made_sections(
    makers: Makers[AnyRuns],
    figures: tuple[int, ...],
    make_runs: Callable[[Callable[[str], None]], AnyRuns],
    tell: Callable[[float, str], None] | None,
) -> tuple[Section, ...]:
    """The sections of these figures, all from one set of runs; ``tell`` hears the fraction done and what is being done.

    make_runs: makes the set of runs, given what to call with words for what is being done.
    """
    hear = tell or (lambda fraction, doing: None)
    whole = sum(makers[figure][1] for figure in figures)
    done = 0.0
    runs = make_runs(lambda doing: hear(done / whole, doing))
    sections = []
    for figure in figures:
        make, share = makers[figure]
        sections.append(make(runs))
        done += share
    return tuple(sections)


def require_study_folder(folder: str | Path, page_file: str, pictures: str) -> None:
    """Raise RotaError when it is already known that a study cannot be written there; asked before long work.

    pictures: a pattern that the names of its pictures match.
    """
    require_writable_folder(folder)
    for name in (page_file, *(found.name for found in Path(folder).glob(pictures))):
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

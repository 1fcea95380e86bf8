"""A paper's study: the figures that are asked for, made one after the other, and written to a folder with a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_writable, require_writable_folder
from rota.papers.section import Section
from rota.papers.tables import joined

AnySettings = TypeVar("AnySettings")
AnyRuns = TypeVar("AnyRuns")
SettingsTaken = TypeVar("SettingsTaken", contravariant=True)
RunsMade = TypeVar("RunsMade", covariant=True)
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
        pictures = {picture.file: picture.png for section in self.sections for picture in section.pictures}
        return pictures | {self.page_file: self.page.encode()}


class RunsMaker(Protocol[SettingsTaken, RunsMade]):
    """What makes the set of runs that figures share.

    tell: called with words for what is being done. should_stop: asked before every run; True raises StudyStopped.
    """

    def __call__(
        self, settings: SettingsTaken, *, seed: int, tell: Callable[[str], None], should_stop: Callable[[], bool]
    ) -> RunsMade:
        """Make it, before any run."""


@dataclass(frozen=True, kw_only=True)
class PaperStudy(Generic[AnySettings, AnyRuns]):
    """How a paper's figures are made again; called, it makes those that are asked for.

    page_file: the page's name; pictures: a pattern that the names of its pictures match. figures: how each is made.
    settings: makes those of the page in docs. runs: makes what the figures are made of. page: the page's Markdown of
    sections, a seed and settings.
    """

    page_file: str
    pictures: str
    figures: Makers[AnyRuns]
    settings: Callable[[], AnySettings]
    runs: RunsMaker[AnySettings, AnyRuns]
    page: Callable[[Sequence[Section], int, AnySettings], str]

    def __call__(
        self,
        figures: tuple[int, ...] | None = None,
        *,
        settings: AnySettings | None = None,
        seed: int = 0,
        progress: Callable[[float, str], None] | None = None,
        should_stop: Callable[[], bool] | None = None,
    ) -> Study:
        """Make figures of the paper again, all from one set of runs.

        figures: their numbers; None for all. settings: how much is run; None for the page in docs. seed: the same seed
        gives the same study. progress: called with a fraction 0..1 and what is being done. should_stop: asked before
        every run at least; raises StudyStopped when it says so, since a study of half the runs is none.
        """
        asked = self.settings() if settings is None else settings
        chosen = tuple(self.figures) if figures is None else figures
        hear = progress or (lambda fraction, doing: None)
        whole = sum(self.figures[figure][1] for figure in chosen)
        done = 0.0
        runs = self.runs(
            asked, seed=seed, tell=lambda doing: hear(done / whole, doing), should_stop=should_stop or (lambda: False)
        )
        sections = []
        for figure in chosen:
            make, share = self.figures[figure]
            sections.append(make(runs))
            done += share
        return Study(sections=tuple(sections), page_file=self.page_file, page=self.page(sections, seed, asked))


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


def require_study_folder(folder: str | Path, page_file: str, pictures: str) -> None:
    """Raise RotaError when it is already known that a study cannot be written there; asked before long work.

    pictures: a pattern that the names of its pictures match.
    """
    require_writable_folder(folder)
    for name in (page_file, *(path.name for path in Path(folder).glob(pictures))):
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

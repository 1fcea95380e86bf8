"""A paper's study: the figures that are asked for, made one after the other, and written to a folder with a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_writable, require_writable_folder
from rota_studies.figure_data import further_files
from rota_studies.plain import built
from rota_studies.records import Records, RecordsFile, read_records
from rota_studies.section import Section
from rota_studies.tables import joined

AnySettings = TypeVar("AnySettings")
AnyRuns = TypeVar("AnyRuns")
# how a figure is made from runs, and about how many parts of the whole work it is
Makers = Mapping[int, tuple[Callable[[AnyRuns], Section], float]]


@dataclass(frozen=True, kw_only=True)
class Study:
    """The sections in the order of the figures, the page that holds them, and the records that they are made from.

    name: what the names of its files begin with.
    """

    name: str
    sections: tuple[Section, ...]
    page: str
    records: RecordsFile

    @property
    def tables_text(self) -> str:
        """All tables as plain text."""
        return "\n\n".join(table.text for section in self.sections for table in section.tables)

    def files(self, forms: Sequence[str] = ()) -> dict[str, bytes]:
        """Name and bytes of every file: pictures, what else is asked for, records, and the page that shows them last.

        forms: svg and pdf pictures, csv and json data beside them.
        """
        found = {picture.file: picture.png for section in self.sections for picture in section.pictures}
        for section in self.sections:
            found |= further_files(section, forms, self.name)
        return found | {f"{self.name}.json": self.records.text.encode(), f"{self.name}.md": self.page.encode()}


@dataclass(frozen=True, kw_only=True)
class PaperStudy(Generic[AnySettings, AnyRuns]):
    """How a paper's figures are made again; called, it makes those that are asked for.

    name: of the command, and what the names of its files begin with. figures: how each is made. settings: the type of
    settings, whose defaults are those of the page in docs. runs: makes what the figures are made of. page: the page's
    Markdown of sections, a seed and settings.
    """

    name: str
    figures: Makers[AnyRuns]
    settings: Callable[[], AnySettings]
    runs: Callable[..., AnyRuns]
    page: Callable[[Sequence[Section], int, AnySettings], str]

    def __call__(
        self,
        figures: tuple[int, ...] | None = None,
        *,
        settings: AnySettings | None = None,
        seed: int = 0,
        records: Records | None = None,
        progress: Callable[[float, str], None] | None = None,
        should_stop: Callable[[], bool] | None = None,
    ) -> Study:
        """Make figures of the paper again, all from one set of runs.

        figures: their numbers; None for all. settings: how much is run; None for the page in docs. seed: the same seed
        gives the same study. records: runs that are known. progress: called with a fraction 0..1 and what is being
        done. should_stop: asked before every run at least; raises StudyStopped when it says so, since a study of half
        the runs is none.
        """
        asked = self.settings() if settings is None else settings
        chosen = tuple(self.figures) if figures is None else figures
        hear = progress or (lambda fraction, doing: None)
        whole = sum(self.figures[figure][1] for figure in chosen)
        done = 0.0
        kept = Records() if records is None else records
        runs = self.runs(
            asked, seed=seed, tell=lambda doing: hear(done / whole, doing), should_stop=should_stop or (lambda: False),
            records=kept,
        )  # fmt: skip
        sections = []
        for figure in chosen:
            make, share = self.figures[figure]
            sections.append(make(runs))
            done += share
        return Study(
            name=self.name,
            sections=tuple(sections),
            page=self.page(sections, seed, asked),
            records=RecordsFile(study=self.name, seed=seed, settings=asked, runs=kept.used),
        )

    def from_records(self, path: str | Path, figures: tuple[int, ...] | None = None) -> Study:
        """The same from a file of records, without any run. Raises RotaError for a file that lacks one."""
        file = read_records(path, self.name)
        known = Records(file.runs, may_run=False)
        study = self(figures, settings=self.settings_of(file), seed=file.seed, records=known)
        return replace(study, records=replace(study.records, rota=file.rota))

    def settings_of(self, file: RecordsFile) -> AnySettings:
        """The settings that records were made with."""
        asked: AnySettings = built(self.settings, file.settings)
        return asked


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


def require_study_folder(folder: str | Path, name: str) -> None:
    """Raise RotaError when it is already known that a study cannot be written there; asked before long work.

    name: what the names of its files begin with.
    """
    require_writable_folder(folder)
    for path in sorted(Path(folder).glob(f"{name}*.*")):
        require_writable(path)


def write_study(study: Study, folder: str | Path, forms: Sequence[str] = ()) -> tuple[Path, ...]:
    """Write page, pictures and records into ``folder``, which is made when it is missing; returns the paths.

    forms: as for ``Study.files``. Each file appears whole or not at all, the page last. Other files in the folder stay.
    Raises RotaError when it cannot be written.
    """
    require_writable_folder(folder)
    folder = Path(folder)
    files = study.files(forms)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise RotaError(f"{folder}: cannot be made: {error.strerror or error}") from error
    for name, data in files.items():
        with replaced_file(folder / name) as partial:
            partial.write_bytes(data)
    return tuple(folder / name for name in files)

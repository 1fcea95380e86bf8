"""The frame of a paper's study: which figures it makes, from what, and what it tells meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest

from rota.errors import RotaError
from rota_studies.records import Records
from rota_studies.section import Section
from rota_studies.study import PaperStudy, write_study
from rota_studies.study_runs import StudyStopped


@dataclass(frozen=True)
class Words:
    """Settings: words."""

    told: str = "as in docs"


class Runs:
    """Runs that tell of each, and remember how often they were asked."""

    def __init__(
        self,
        settings: Words,
        *,
        seed: int,
        tell: Callable[[str], None],
        should_stop: Callable[[], bool],
        records: Records,
    ) -> None:
        self.settings, self.seed, self.tell, self.should_stop = settings, seed, tell, should_stop
        self.records = records
        self.asked = 0

    def __call__(self, figure: int) -> Section:
        """A section that says which run it is made from."""
        if self.should_stop():
            raise StudyStopped
        self.asked += 1
        self.tell(f"run {self.asked}")
        run = {"settings": self.settings.told, "seed": self.seed, "run": self.asked}
        told = self.records.get(str, run, lambda: f"{self.settings.told}, seed {self.seed}, run {self.asked}")
        return Section(figure=figure, heading="", pictures=(), caption="", paper="", ours=told)


class Told(NamedTuple):
    """How far the study is, and what it does."""

    fraction: float
    doing: str


STUDY = PaperStudy(
    name="page",
    figures={2: (lambda runs: runs(2), 3.0), 5: (lambda runs: runs(5), 1.0), 7: (lambda runs: runs(7), 4.0)},
    settings=Words,
    runs=Runs,
    page=lambda sections, seed, settings: f"{[s.figure for s in sections]} with {seed}, {settings.told}",
)


def test_all_figures_are_made_from_one_set_of_runs_unless_some_are_asked_for() -> None:
    found = STUDY(seed=4)
    assert [section.ours for section in found.sections] == [f"as in docs, seed 4, run {k}" for k in (1, 2, 3)]
    files = found.files()
    assert list(files) == ["page.json", "page.md"]
    assert files["page.md"] == b"[2, 5, 7] with 4, as in docs"
    assert STUDY((7,), settings=Words("less")).page == "[7] with 0, less"


def test_a_page_is_made_again_from_its_records_byte_for_byte(tmp_path: Path) -> None:
    found = STUDY(seed=4, settings=Words("less"))
    for path in write_study(found, tmp_path):
        assert path.read_bytes() == found.files()[path.name]
    again = STUDY.from_records(tmp_path / "page.json")
    assert again.files() == found.files()
    assert STUDY.from_records(tmp_path / "page.json", (2, 5)).page == "[2, 5] with 4, less"
    (tmp_path / "page.json").write_text(found.files()["page.json"].decode().replace('"run":3', '"run":4'))
    with pytest.raises(RotaError, match="the records have no run"):
        STUDY.from_records(tmp_path / "page.json")


def test_the_fraction_done_goes_by_the_work_of_the_figures_asked_for() -> None:
    told: list[Told] = []
    STUDY(progress=lambda fraction, doing: told.append(Told(fraction, doing)))
    assert told == [Told(0, "run 1"), Told(3 / 8, "run 2"), Told(4 / 8, "run 3")]
    told.clear()
    STUDY((5, 7), progress=lambda fraction, doing: told.append(Told(fraction, doing)))
    assert told == [Told(0, "run 1"), Told(1 / 5, "run 2")]


def test_a_stop_between_two_figures_ends_the_study() -> None:
    told: list[str] = []
    with pytest.raises(StudyStopped):
        STUDY(progress=lambda _, doing: told.append(doing), should_stop=lambda: len(told) == 2)
    assert told == ["run 1", "run 2"]

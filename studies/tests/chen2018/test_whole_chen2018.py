"""The study as a whole: its numbers come from its runs, its links lead to pictures, and a stop writes nothing."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rota.command.cli import run
from rota_studies.chen2018 import maps, runs as runs_module, study as study_module
from rota_studies.chen2018.runs import EXACT, READINGS, Runs, StudySettings
from rota_studies.chen2018.study import chen2018_study
from rota_studies.study import Study, write_study
from rota_studies.study_runs import StudyStopped

pytestmark = pytest.mark.slow  # the whole study is made, small


@pytest.fixture(scope="module")
def study(settings: StudySettings) -> Study:
    return chen2018_study(settings=settings, seed=2)


def test_every_figure_has_its_section(study: Study) -> None:
    assert tuple(chen2018_study.figures) == (9, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24)
    assert [section.figure for section in study.sections] == list(chen2018_study.figures)
    titles = [table.title for section in study.sections for table in section.tables]
    assert "Table 2: parameters" in titles
    assert any(title.startswith("Table 3: ") for title in titles)


def test_every_claim_has_its_verdict_in_the_table_at_the_top(study: Study) -> None:
    top = study.page.split("## The controllers")[0]
    rows = [line.split(" | ") for line in top.splitlines() if line.startswith("| ") and "| **" in line]
    claims = [verdict for section in study.sections for verdict in section.verdicts]
    assert [row[0].removeprefix("| ") for row in rows] == [one.claim for one in claims]
    assert [row[2].strip("*") for row in rows] == [one.outcome for one in claims]
    assert len(claims) >= 20
    assert all(one.why.endswith(".") and one.place for one in claims)


def test_the_page_shows_every_picture_in_small_files(study: Study) -> None:
    files = study.files()
    links = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", study.page)
    assert links == [name for name in files if name.endswith(".png")]
    for name in links:
        assert len(files[name]) < 200_000
        with Image.open(io.BytesIO(files[name])) as picture:
            picture.load()
            assert 500 <= picture.width <= 1000
            assert len(picture.convert("RGB").getcolors(100_000) or []) > 10


def test_tables_are_whole_markdown(study: Study) -> None:
    assert not re.search(r"\b(nan|inf)\b", study.page)
    for section in study.sections:
        for table in section.tables:
            lines = table.markdown.splitlines()[2:]
            assert {line.count("|") for line in lines} == {len(table.head) + 1}
            assert "None" not in table.markdown


def test_steps_and_coverage_are_those_of_the_runs(study: Study, settings: StudySettings) -> None:
    _, table = study.sections[2].tables
    assert table.rows[0][3] == "574"
    assert [row[:2] for row in table.rows[1:]] == [(start, one.name) for start in maps.STARTS for one in READINGS]
    runs = Runs(settings, seed=2, tell=lambda _: None, should_stop=lambda: False)
    covered = [100 * outcome.coverage for outcome in runs.seeds(maps.small("corner"), EXACT)]
    row = table.rows[1 + 2 * len(READINGS) + READINGS.index(EXACT)]
    assert row[2] == "0 of 2"
    assert row[5] == f"{np.mean(covered):.2f} ± {np.std(covered, ddof=1):.2f}"


def test_the_same_seed_gives_the_same_files(study: Study, settings: StudySettings) -> None:
    once, again = (chen2018_study((12, 19), settings=settings, seed=1).files() for _ in range(2))
    assert once == again
    assert once["chen2018-figure-12.png"] != study.files()["chen2018-figure-12.png"]  # of seed 2


def test_files_are_written_beside_others(study: Study, tmp_path: Path) -> None:
    (tmp_path / "figure-12.png").write_text("of another study")
    written = write_study(study, tmp_path)
    assert {path.name: path.read_bytes() for path in written} == study.files()
    assert (tmp_path / "figure-12.png").read_text() == "of another study"


def test_progress_grows_and_a_stop_ends_the_study(settings: StudySettings) -> None:
    told: list[tuple[float, str]] = []

    def progress(fraction: float, doing: str) -> None:
        told.append((fraction, doing))

    with pytest.raises(StudyStopped):
        chen2018_study((12, 17), settings=settings, progress=progress, should_stop=lambda: len(told) > 32)
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert 0 <= fractions[0] <= fractions[-1] < 1


@pytest.fixture
def small(settings: StudySettings, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The command with small settings, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study_module, "chen2018_study", replace(chen2018_study, settings=lambda: settings))


@pytest.mark.usefixtures("small")
def test_the_command_writes_page_and_pictures(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["study", "chen2018", "--figures", "16,9", "-o", "out", "--seed", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Mean distance to the centroid, m/s"
    names = ["chen2018-figure-9.png", "chen2018-figure-16.png", "chen2018.json", "chen2018.md"]
    assert lines[-4:] == [f"out/{name}" for name in names]
    assert "with seed 3" in Path("out/chen2018.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "file"], "file: is a file; the path of a folder is needed"),
        (["-o", "full"], "chen2018.md: is a folder; the path of a file is needed"),
        (
            ["--figures", "10"],
            "figures: '10' is none of them; 9, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23 and 24 are",
        ),
        (["--figures", "9;11"], "figures: '9;11' is none of them"),
    ],
)
@pytest.mark.usefixtures("small")
def test_what_cannot_be_is_refused_before_any_run(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("ran all the same")

    monkeypatch.setattr(runs_module, "run_mission", never)
    Path("file").write_text("mine")
    Path("full/chen2018.md").mkdir(parents=True)
    assert run(["study", "chen2018", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert Path("file").read_text() == "mine"

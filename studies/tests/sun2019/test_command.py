"""``rota study sun2019``: what it prints and writes, what it refuses, and Ctrl-C."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rota.command.cli import run
from rota_studies.section import Section
from rota_studies.sun2019 import runs as runs_module, study as study_module
from rota_studies.sun2019.runs import Runs, StudySettings
from rota_studies.sun2019.study import sun2019_study

STAGED = ["study", "sun2019", "--figures", "8,15"]


@pytest.fixture
def small(settings: StudySettings, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The command with small settings, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(runs_module, "StudySettings", lambda **_: settings)


@pytest.mark.slow  # draws every picture
@pytest.mark.usefixtures("small")
def test_the_page_and_its_pictures_go_into_a_new_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*STAGED, "-o", "out", "--seed", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Crossings between the two sub-regions, 2 seeds: mean (range)"
    assert lines[1].split()[:3] == ["distances", "paper", "ours"]
    names = ["sun2019-figure-8.png", "sun2019-figure-15.png", "sun2019.json", "sun2019.md"]
    assert lines[-4:] == [f"out/{name}" for name in names]
    assert sorted(os.listdir("out")) == sorted(names)
    page = Path("out/sun2019.md").read_text()
    assert "with seeds 3 to 4 and effort quick" in page
    assert run([*STAGED, "--from", "out/sun2019.json", "-o", "again", "--also", "pdf"]) == 0
    assert "pdf" in capsys.readouterr().out
    assert {name: Path("again", name).read_bytes() for name in names} == {
        name: Path("out", name).read_bytes() for name in names
    }


@pytest.mark.usefixtures("small")
def test_without_a_folder_it_prints_the_tables_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(STAGED) == 0
    assert "Eq. 14" in capsys.readouterr().out
    assert os.listdir() == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "file"], "file: is a file; the path of a folder is needed"),
        (["-o", "missing/out"], "there is no folder"),
        (["-o", "full"], "sun2019.md: is a folder; the path of a file is needed"),
        (["-o", "taken"], "sun2019-figure-6.png: is a folder; the path of a file is needed"),
        (["--figures", "9"], "figures: '9' is none of them; 6, 8, 12, 13, 14, 15 and 16 are"),
        (["--figures", ""], "figures: '' is none of them"),
        (["--from", "missing.json"], "missing.json: cannot be read"),
        (["--from", "file"], "file: not JSON"),
        (["--also", "svg"], "--also svg: files need a folder; give one with -o FOLDER"),
        (["--also", "gif", "-o", "out"], "--also: 'gif' is not allowed; must be svg, pdf, csv or json"),
    ],
)
@pytest.mark.usefixtures("small")
def test_what_cannot_be_is_refused_before_any_run(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: Any, **__: Any) -> None:
        raise AssertionError("ran all the same")

    monkeypatch.setattr(study_module, "sun2019_study", replace(sun2019_study, runs=never))
    Path("file").write_text("mine")
    Path("full/sun2019.md").mkdir(parents=True)
    Path("taken/sun2019-figure-6.png").mkdir(parents=True)
    assert run(["study", "sun2019", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert Path("file").read_text() == "mine"


@pytest.mark.usefixtures("small")
def test_ctrl_c_writes_nothing(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's background jobs ignore
    figures = sun2019_study.figures
    make, share = figures[15]

    def interrupted(runs: Runs) -> Section:
        section = make(runs)
        os.kill(os.getpid(), signal.SIGINT)
        return section

    changed = replace(sun2019_study, figures={**figures, 6: (interrupted, share)})
    monkeypatch.setattr(study_module, "sun2019_study", changed)
    assert run(["study", "sun2019", "--figures", "6,8", "-o", "out"]) == 130
    told = capsys.readouterr()
    assert "stopping with nothing written; Ctrl-C again ends at once" in told.err
    assert told.out == ""
    assert not Path("out").exists()


def test_help_tells_figures_and_tables(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["study", "sun2019", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "6,8,12,13,14,15,16" in told
    assert "Table 5 comes with Figure 13" in told

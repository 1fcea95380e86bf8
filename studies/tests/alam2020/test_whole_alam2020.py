"""The study as a whole: its numbers come from its runs, its links lead to pictures, and a stop writes nothing."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from PIL import Image

from rota.command.cli import run
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.planner import bouncing_robots, coverage_by
from rota_studies.alam2020 import maps, study as study_module
from rota_studies.alam2020.runs import StudySettings, steps_until
from rota_studies.alam2020.study import alam2020_study
from rota_studies.alam2020.watched import group_counts, shown_group
from rota_studies.study import Study
from rota_studies.study_runs import StudyStopped
from rota_studies.verdict import Outcome

pytestmark = pytest.mark.slow  # the whole study is made, small

SMALL = StudySettings(starts=2, layouts=1, layout_steps=500, region_pairs=5, error_steps=30, walks=2000)


@pytest.fixture(scope="module")
def study() -> Study:
    return alam2020_study(settings=SMALL, seed=2)


def test_every_figure_has_its_section(study: Study) -> None:
    assert (
        [section.figure for section in study.sections] == list(alam2020_study.figures) == [6, 7, 8, 9, 10, 11, 12, 13]
    )
    assert [section.figure for section in study.sections if section.extra] == [12, 13]
    assert "## Figure 11: " in study.page
    assert "## Extra figure 12: " in study.page


def test_the_page_shows_every_picture_in_small_files(study: Study) -> None:
    files = study.files()
    links = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", study.page)
    assert links == [name for name in files if name.endswith(".png")]
    for name in links:
        assert len(files[name]) < 200_000
        with Image.open(io.BytesIO(files[name])) as picture:
            assert 500 <= picture.width <= 1000
            assert len(picture.convert("RGB").getcolors(100_000) or []) > 10


def test_tables_are_whole_markdown(study: Study) -> None:
    assert not re.search(r"\b(nan|inf|None)\b", study.page)
    for section in study.sections:
        for table in section.tables:
            assert {line.count("|") for line in table.markdown.splitlines()[2:]} == {len(table.head) + 1}


def test_steps_are_those_of_the_planner(study: Study) -> None:
    mission = maps.room(maps.ROOM_10, 3, 135.0, method="improved")
    bouncing = bouncing_robots(mission, make_cells(mission))
    steps = [coverage_by(bouncing, seed=seed).steps for seed in (2, 3)]
    table = study.sections[1].tables[0]
    row = next(row for row in table.rows if row[:2] == ("3", "improved"))
    assert row[2:5] == (
        "2 of 2",
        f"{np.mean(steps):,.0f} ± {np.std(steps, ddof=1):,.0f}",
        f"{min(steps)} to {max(steps)}",
    )


def test_each_claim_has_a_verdict_with_its_reason(study: Study) -> None:
    top = study.page.split("## The paper's claims")[1].split("## The methods")[0]
    rows = [line.strip("| ").split(" | ") for line in top.splitlines() if line.startswith("| ") and "**" in line]
    assert len(rows) >= 18
    assert {row[2].strip("*") for row in rows} <= set(get_args(Outcome))
    assert all(len(row[3]) > 20 for row in rows)
    driven = [row for row in rows if "Create 2" in row[0]]
    assert [row[1] for row in driven] == ["5.1, Figure 6d-f", "5.2, Figure 11d-f"]
    assert "4 of 4 plans" in driven[0][3]  # two starts, two methods


def test_the_papers_counts_stand_at_their_angles(study: Study) -> None:
    told = [{row[0]: row[1] for row in study.sections[k].tables[0].rows} for k in (4, 5)]
    assert told == [{"45°": "47", "90°": "", "135°": ""}, {"45°": "", "90°": "18", "135°": ""}]


def test_steps_until_a_share_by_hand() -> None:
    mission = maps.room("....", 1, 180.0, method="as_printed", start_headings_deg=(0.0,))
    bouncing = bouncing_robots(mission, make_cells(mission))
    found = coverage_by(bouncing, seed=0)
    cells = found.states[:, 0] // 8
    for share, wanted in ((0.25, 1), (0.5, 2), (0.51, 3), (1.0, 4)):
        by_hand = next(step for step in range(len(cells)) if len(set(cells[: step + 1].tolist())) >= wanted)
        assert steps_until(found, 8, share) == by_hand


def test_a_ring_of_cells_has_its_groups_by_hand() -> None:
    """In a room of 4 x 3 by 90° robots of four headings go round ten cells in 14 steps, four of them turns.

    What two of them do depends on how many steps they are apart: 1 to 13. One step apart the one behind would drive
    into the cell in which the one before it turns; two apart it comes there when that is leaving. So 2 to 12 are left,
    of which those that add up to 14 are the same without names.
    """
    mission = maps.watching(maps.room("....\n....\n....", 2, 90.0, headings=4), {"A": (0, 0, 1, 1), "B": (3, 2, 4, 3)})
    counts = group_counts(mission)
    assert (counts.cycles, counts.states) == (1, 14)
    assert (counts.apart, counts.unordered, counts.anywhere) == (11, 6, 11)
    assert counts.free_basin <= counts.basin <= 1
    plan, words = shown_group(mission, 0)
    assert len(plan.trajectories) == 2
    assert words.startswith("cycles of 14 and 14 steps")


def test_random_rooms_hang_together() -> None:
    for seed in range(5):
        text = maps.random_room(10, 8, 15, np.random.default_rng(seed))
        assert [len(line) for line in text.splitlines()] == [10] * 8
        assert text.count("#") >= 15
        mission = maps.room(text, 1, 135.0, method="improved")
        assert coverage_by(bouncing_robots(mission, make_cells(mission)), seed=seed).complete


def test_the_same_seed_gives_the_same_files(study: Study) -> None:
    once, again = (alam2020_study((7, 9), settings=SMALL, seed=1).files() for _ in range(2))
    assert once == again
    assert once["alam2020-figure-9.png"] != study.files()["alam2020-figure-9.png"]  # of seed 2


def test_progress_grows_and_a_stop_ends_the_study() -> None:
    told: list[float] = []
    with pytest.raises(StudyStopped):
        alam2020_study(
            (7, 10), settings=SMALL, progress=lambda share, _: told.append(share), should_stop=lambda: len(told) > 25
        )
    assert told == sorted(told)
    assert 0 <= told[0] <= told[-1] < 1


@pytest.fixture
def _small(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study_module, "alam2020_study", replace(alam2020_study, settings=lambda: SMALL))


@pytest.mark.usefixtures("_small")
def test_the_command_writes_page_and_pictures(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["study", "alam2020", "--figures", "13,6", "-o", "out", "--seed", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = ["alam2020-figure-6.png", "alam2020-figure-13.png", "alam2020.json", "alam2020.md"]
    assert lines[-4:] == [f"out/{name}" for name in names]
    assert "with seed 3" in Path("out/alam2020.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "file"], "file: is a file; the path of a folder is needed"),
        (["--figures", "5"], "figures: '5' is none of them; 6, 7, 8, 9, 10, 11, 12 and 13 are"),
    ],
)
@pytest.mark.usefixtures("_small")
def test_what_cannot_be_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("file").write_text("mine")
    assert run(["study", "alam2020", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert Path("file").read_text() == "mine"

"""The study as a whole: its numbers come from its runs, its links lead to pictures, and a stop writes nothing."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from rota.errors import RotaError
from rota.mission import Mission
from rota.papers.study import Study, StudyStopped, listed_figures, write_study
from rota.papers.sun2019 import runs as runs_module
from rota.papers.sun2019.printed_settings import TABLE_7
from rota.papers.sun2019.runs import Reading, Runs, StudySettings
from rota.papers.sun2019.stage_figures import figure_8_section
from rota.papers.sun2019.study import sun2019_study
from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.sun2019.deploy import deploy_sensors
from rota.planners.patrol.methods.sun2019.settings import MethodSettings
from rota.planners.patrol.planner_settings import PatrolSettings

STAGES = (6, 8, 12, 15)

pytestmark = pytest.mark.slow  # the whole study is made, small


@pytest.fixture(scope="module")
def study(settings: StudySettings) -> Study:
    return sun2019_study(STAGES, settings=settings, seed=2)


def test_sensors_in_the_table_are_those_of_the_runs(study: Study, settings: StudySettings, make_runs) -> None:
    table, additions = study.sections[0].tables
    mission, deploy = make_runs().map_13, settings.figure_13.deployments[0]
    for row, under, paper in zip(table.rows, (deploy, deploy.without_rules()), ("99", "103"), strict=True):
        zones = [len(zone.positions_m) for zone in deploy_sensors(mission, under, seed=2).zones]
        assert row[1:] == (paper, str(sum(zones)), *map(str, zones))
        assert f"{sum(zones)} " in study.sections[0].ours
        other = len(deploy_sensors(mission, under, seed=3).positions_m)
        assert additions.rows[0][1 if under is deploy else 2] == f"{sum(zones)}, {other}"
    assert [row[0] for row in additions.rows[::4]] == ["as here", "all three, the letter of Algorithm 1"]


def test_crossings_in_the_table_are_those_of_the_frames(study: Study, make_runs: Callable[..., Runs]) -> None:
    (table,) = study.sections[1].tables
    assert [row[:2] for row in table.rows] == [("Euclidean", "8"), ("Eq. 14", "2")]
    runs = make_runs(seed=2)
    deployment = runs.deployment(runs.map_8, runs.settings.figure_13.deployments[0])
    graph = runs.frame(runs.map_8, deployment, runs.settings.figure_13.tour)
    zone = deployment.zone_of
    assert table.rows[1][2:] == (str(graph.zone_crossings), "0", f"{graph.length_m:,.0f}")
    assert int(np.sum(np.diff(zone[[*graph.order, graph.order[0]]]) != 0)) <= graph.zone_crossings
    assert figure_8_section(make_runs(seed=2)).markdown == study.sections[1].markdown


def test_the_page_shows_every_picture_and_names_what_cannot_be_reproduced(study: Study) -> None:
    files = study.files
    links = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", study.page)
    assert links == [name for name in files if name != "sun2019.md"]
    for name in links:
        with Image.open(io.BytesIO(files[name])) as picture:
            picture.load()
            assert picture.format == "PNG"
            assert 500 <= picture.width <= 1000
            assert len(picture.convert("RGB").getcolors(100_000) or []) > 10
    assert [line for line in study.page.splitlines() if line.startswith("# ")] == [
        "# Sun et al. 2019, figure by figure"
    ]
    assert [line for line in study.page.splitlines() if line.startswith("## Figure ")] == [
        f"## Figure {section.figure}: {section.heading}" for section in study.sections
    ]
    assert study.page.count("The map is a reconstruction: the paper prints no coordinates.") == len(STAGES)
    assert "| **holds** |" in study.page or "| **does not hold** |" in study.page
    for fault in ("61,025.99", "50 iterations", "168th", "T₁ > T₂ > T₃", "r_n = 2 r_s", "ξ₁ = 300", "5,709.0"):
        assert fault in study.page


def test_tables_are_whole_markdown(study: Study) -> None:
    rows = [line for line in study.page.splitlines() if line.startswith("|")]
    assert rows
    assert not re.search(r"\b(None|nan|inf)\b", study.page)
    for section in study.sections:
        for table in section.tables:
            lines = table.markdown.splitlines()[2:]
            assert {line.count("|") for line in lines} == {len(table.head) + 1}
            assert len(lines) == len(table.rows) + 2


def test_the_same_seed_gives_the_same_files(study: Study, settings: StudySettings) -> None:
    once, again = (sun2019_study((12,), settings=settings, seed=1).files for _ in range(2))
    assert once == again
    assert once["sun2019-figure-12.png"] != study.files["sun2019-figure-12.png"]  # of seed 2


def test_files_are_written_whole_and_others_stay(study: Study, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    (folder / "sun2019-figure-6.png").write_text("old")
    written = write_study(study, folder)
    assert {path.name for path in folder.iterdir()} == {"notes.txt", *(path.name for path in written)}
    assert {path.name: path.read_bytes() for path in written} == study.files
    assert written[-1].name == "sun2019.md"
    assert (folder / "notes.txt").read_text() == "mine"


def test_a_stop_ends_the_study_between_two_runs(settings: StudySettings) -> None:
    told: list[str] = []
    with pytest.raises(StudyStopped):
        sun2019_study(
            (6, 8), settings=settings, progress=lambda _, doing: told.append(doing), should_stop=lambda: len(told) == 2
        )
    assert told == [
        "sun2019-fig13: deploying sensors and finding the frame, seed 0", "sun2019-fig13: deploying sensors, seed 0",
    ]  # fmt: skip


def test_progress_grows_to_the_last_figure(settings: StudySettings) -> None:
    told: list[float] = []
    sun2019_study((8, 15), settings=settings, progress=lambda fraction, _: told.append(fraction))
    assert told == sorted(told)
    assert 0 <= told[0] <= told[-1] < 1


def test_every_figure_of_the_study_can_be_named() -> None:
    assert tuple(sun2019_study.figures) == (6, 8, 12, 13, 14, 15, 16)
    assert listed_figures(None, sun2019_study.figures) == tuple(sun2019_study.figures)
    assert listed_figures("13, 6,13", sun2019_study.figures) == (6, 13)


@pytest.mark.parametrize("listed", ["", "7", "6,", "six", "6;8", "-6"])
def test_other_figures_are_refused(listed: str) -> None:
    with pytest.raises(RotaError, match=r"figures: .* is none of them; 6, 8, 12, 13, 14, 15 and 16 are"):
        listed_figures(listed, sun2019_study.figures)


def test_what_figures_share_runs_once(settings: StudySettings) -> None:
    told: list[str] = []
    runs = Runs(settings, seed=0, tell=told.append, should_stop=lambda: False)
    framed, printed = runs.framed(runs.map_13, settings.figure_13), runs.printed(runs.map_13, settings.figure_13)
    assert printed.stages.framed is framed
    assert runs.printed(runs.map_13, settings.figure_13) is printed
    assert told == [
        f"sun2019-fig13: {doing}"
        for doing in ("deploying sensors and finding the frame, seed 0", "cutting the frame", "checking the routes")
    ]


def test_methods_are_asked_once(make_runs: Callable[..., Runs], without_search: list[Mission]) -> None:
    runs = make_runs()
    runs.printed(runs.map_13, runs.settings.figure_13)
    for _ in range(2):
        runs.by_method(runs.map_13, "tours")
        runs.by_method(runs.map_13, "sun2019")
        runs.by_method(runs.map_13, "tours", effort="normal")
    asked = [(PatrolSettings.of(mission).method, PatrolSettings.of(mission).effort) for mission in without_search]
    assert asked == [("tours", "quick"), ("sun2019", "quick"), ("tours", "normal")]


def test_mending_is_done_once_with_the_figure_s_own_tables(
    make_runs: Callable[..., Runs], without_search: list[Mission], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = make_runs()
    asked: list[tuple[str, MethodSettings]] = []

    def searched(context: Context, settings: MethodSettings) -> SimpleNamespace:
        asked.append((PatrolSettings.of(context.problem.mission).effort, settings))
        plan = runs.printed(runs.map_15, runs.settings.figure_16).plan
        return SimpleNamespace(plan=plan, met=True, within_budgets=True)

    monkeypatch.undo()
    monkeypatch.setattr(runs_module, "fewest_robots_by_stages", searched)
    found = runs.mended(runs.map_15, runs.settings.figure_16)
    assert runs.mended(runs.map_15, runs.settings.figure_16) is found
    assert (found.method, found.met) == ("sun2019", True)
    ((effort, settings),) = asked
    assert (effort, settings.route.routes) == ("quick", "repaired")
    assert replace(settings, route=runs.settings.figure_16.route) == runs.settings.figure_16
    assert StudySettings().figure_16.deployments == (TABLE_7,)


@pytest.mark.usefixtures("without_search")
def test_the_cheapest_partition_costs_no_more_than_the_swarms(make_runs: Callable[..., Runs]) -> None:
    runs = make_runs()
    settings = runs.settings.figure_13
    printed = runs.printed(runs.map_13, settings)
    own = Reading(settings.partition.joining_legs, settings.partition.weight_late)
    least = runs.cheapest(printed.stages.framed, runs.map_13, settings, own)
    assert least.cost <= printed.stages.partitions[0].cost
    never = runs.cheapest(printed.stages.framed, runs.map_13, settings, Reading(False, 1e6))
    assert never.kept
    assert len(never.first) >= len(
        runs.cheapest(printed.stages.framed, runs.map_13, settings, Reading(False, 200)).first
    )

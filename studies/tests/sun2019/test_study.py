"""The study as a whole: its numbers come from its runs, its links lead to pictures, and a stop writes nothing."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from rota.errors import RotaError
from rota.model.plan import Plan
from rota.planners.patrol.context import Context
from rota.planners.patrol.planner_settings import PatrolSettings
from rota_studies.study import Study, listed_figures, write_study
from rota_studies.study_runs import StudyStopped
from rota_studies.sun2019 import runs as runs_module
from rota_studies.sun2019.cases import brief
from rota_studies.sun2019.printed_settings import TABLE_7
from rota_studies.sun2019.runs import Reading, Runs, StudySettings
from rota_studies.sun2019.study import sun2019_study
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.sun2019_stages.deploy import deploy_sensors
from rota_studies.verdict import spread

STAGES = (6, 8, 12, 15)

pytestmark = pytest.mark.slow  # the whole study is made, small


@pytest.fixture(scope="module")
def study(settings: StudySettings) -> Study:
    return sun2019_study(STAGES, settings=settings, seed=2)


def test_sensors_in_the_table_are_those_of_the_runs(study: Study, settings: StudySettings, make_runs) -> None:
    table, additions = study.sections[0].tables
    runs = make_runs()
    mission, deploy = runs.map_13, runs.figure_13.deployments[0]
    for k, (under, theirs) in enumerate(((deploy, "99"), (deploy.without_rules(), "103"))):
        counts = [len(deploy_sensors(mission, under, seed=seed).positions_m) for seed in (2, 3)]
        assert table.rows[k][1:3] == (theirs, brief(counts))
        assert additions.rows[0][1 + k] == spread(counts, ".1f")
    assert [row[0] for row in additions.rows[::4]] == ["as here", "all three, the letter of Algorithm 1"]


def test_crossings_in_the_table_are_those_of_the_frames(study: Study, make_runs: Callable[..., Runs]) -> None:
    (table,) = study.sections[1].tables
    assert [row[:2] for row in table.rows] == [("Euclidean", "8"), ("Eq. 14", "2")]
    runs = make_runs(seed=2)
    deploy, tour = runs.figure_13.deployments[0], runs.figure_13.tour
    frames = [runs.way(runs.map_8, deploy, tour, seed) for seed in runs.seeds]
    assert table.rows[1][2:4] == (brief([one.zone_crossings for one in frames]), brief([0, 0]))
    sensors = runs.sensors(runs.map_8, deploy, 2)
    changes = np.diff(sensors.zone_of[[*frames[0].order, frames[0].order[0]]])
    assert int(np.sum(changes != 0)) <= frames[0].zone_crossings


def test_a_page_and_its_files_are_made_again_from_records(study: Study, tmp_path: Path) -> None:
    written = write_study(study, tmp_path, ("svg", "csv", "json"))
    again = sun2019_study.from_records(tmp_path / "sun2019.json", STAGES)
    assert again.files() == study.files()
    names = {path.name for path in written}
    assert {"sun2019-figure-12.svg", "sun2019-figure-6-table-2.csv", "sun2019-figure-6-curves-1.csv"} <= names
    stages = json.loads((tmp_path / "sun2019-figure-12.json").read_text())
    panels = {panel["title"]: panel for panel in stages["panels"]}
    marked = panels["(2) Sensors (Algorithm 1)"]["marks"]
    assert sum(len(marks["places_m"]) for marks in marked) == int(
        str(study.sections[2].ours.split(" = ")[1]).split()[0]
    )
    frame = next(one for one in panels["(3) Graph and frame (Algorithm 2)"]["lines"] if one["label"] == "frame")
    assert frame["paths_m"][0][0] == frame["paths_m"][0][-1]
    assert len(panels["(4) Segments (Algorithm 3)"]["lines"]) == len(panels["(5) Routes"]["robots"])


def test_the_page_shows_every_picture_and_names_what_cannot_be_reproduced(study: Study) -> None:
    files = study.files()
    links = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", study.page)
    assert links == [name for name in files if name.endswith(".png")]
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
    assert "| **cannot be told** |" in study.page  # two seeds
    for fault in ("61,025.99", "50 iterations", "168th", "T₁ > T₂ > T₃", "r_n = 2 r_s", "ξ₁ = 440", "5,709.0"):
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
    once, again = (sun2019_study((12,), settings=settings, seed=1).files() for _ in range(2))
    assert once == again
    assert once["sun2019-figure-12.png"] != study.files()["sun2019-figure-12.png"]  # of seed 2


def test_files_are_written_whole_and_others_stay(study: Study, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    (folder / "sun2019-figure-6.png").write_text("old")
    written = write_study(study, folder)
    assert {path.name for path in folder.iterdir()} == {"notes.txt", *(path.name for path in written)}
    assert {path.name: path.read_bytes() for path in written} == study.files()
    assert written[-1].name == "sun2019.md"
    assert (folder / "notes.txt").read_text() == "mine"


def test_a_stop_ends_the_study_between_two_runs(settings: StudySettings) -> None:
    told: list[str] = []
    with pytest.raises(StudyStopped):
        sun2019_study(
            (6, 8), settings=settings, progress=lambda _, doing: told.append(doing), should_stop=lambda: len(told) == 2
        )
    assert len(told) == 2
    assert all(one.startswith("sun2019-fig13: deploying sensors") for one in told)


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
    runs = Runs(settings, tell=told.append)
    printed = runs.printed(runs.map_13, runs.figure_13)
    assert runs.printed(runs.map_13, runs.figure_13, 0) is printed
    assert runs.sensors(runs.map_13, runs.figure_13.deployments[0], 0).count == printed.sensors.count
    assert told == [
        f"sun2019-fig13: {doing}, seed 0" for doing in ("deploying sensors and finding the frame", "cutting the frame")
    ]


def test_maps_whose_periods_have_one_order_share_sensors_and_frames(settings: StudySettings) -> None:
    told: list[str] = []
    runs = Runs(settings, tell=told.append)
    first, other = runs.maps_14[0], runs.maps_14[2]  # zone 2, zone 1 and the rest in both
    under = runs.figure_13
    one, two = (runs.printed(mission, under) for mission in (first, other))
    assert sum("deploying" in doing for doing in told) == 1
    np.testing.assert_array_equal(one.sensors.positions_m, two.sensors.positions_m)
    alone = Runs(settings).printed(other, under)
    assert alone.digest == two.digest
    assert [zone.period_s for zone in two.sensors.zones] == [7, 12, 40]


def test_mending_is_done_once_with_the_figure_s_own_tables(
    make_runs: Callable[..., Runs], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = make_runs()
    asked: list[tuple[str, PaperAlgorithms]] = []
    routes = runs.printed(runs.map_15, runs.figure_16).routes
    assert routes is not None

    def searched(context: Context, settings: PaperAlgorithms) -> SimpleNamespace:
        asked.append((PatrolSettings.of(context.problem.mission).effort, settings))
        return SimpleNamespace(plan=Plan(mission=runs.map_15, trajectories=routes), met=True, within_budgets=True)

    monkeypatch.setattr(runs_module, "fewest_robots_by_stages", searched)
    found = runs.mended(runs.map_15, runs.figure_16)
    assert runs.mended(runs.map_15, runs.figure_16) is found
    assert (found.robots, found.met) == (len(routes), True)
    ((effort, settings),) = asked
    assert (effort, settings.routes) == ("quick", "repaired")
    assert replace(settings, routes=runs.figure_16.routes) == runs.figure_16
    assert StudySettings().figure_16.sensors == TABLE_7


def test_the_cheapest_partition_costs_no_more_than_the_swarms(make_runs: Callable[..., Runs]) -> None:
    runs = make_runs()
    settings = runs.figure_13
    printed = runs.printed(runs.map_13, settings)
    own = Reading(settings.partition.joining_legs, settings.partition.weight_late)
    least = runs.cheapest(runs.map_13, settings, own, 0)
    assert least.cost <= printed.partition.cost * (1 + 1e-6)
    never = runs.cheapest(runs.map_13, settings, Reading(False, 1e6), 0)
    assert never.late == 0
    assert never.robots >= runs.cheapest(runs.map_13, settings, Reading(False, 200), 0).robots

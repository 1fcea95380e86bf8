"""The anytime curve: what a real search tells, and what is written of it."""

from __future__ import annotations

import csv
import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from shapely import MultiPolygon, box
from tests.stand_in import standing_in

from rota import search_plan
from rota.command.cli import run
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.progress import SearchState
from rota_studies.patrol_progress import (
    COLUMNS,
    PatrolProgress,
    patrol_progress,
    progress_table,
    progress_to_csv,
    progress_to_json,
)
from rota_studies.sun2019 import figure_13

MAKE_PLAN = importlib.import_module("rota.planning.make_plan")
EXAMPLES = Path(__file__).parents[2] / "examples"
YARD = """\
rota: 1
name: yard
area: [[0, 0], [10, 0], [10, 10], [0, 10]]
period_s: 40
fleet: {speed_m_s: 1, sensor: {shape: disc, radius_m: 20}}
"""


@pytest.fixture(scope="module")
def field() -> Mission:
    return Mission(
        name="field", area=MultiPolygon([box(0, 0, 40, 30)]), period_s=40,
        fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=5)), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def found(field: Mission) -> PatrolProgress:
    return patrol_progress(field, seed=1)


def test_a_search_is_watched_from_its_first_tours_to_the_plan_that_is_met(found: PatrolProgress) -> None:
    assert found.reason is None
    assert found.plan is not None
    states = [point.state for point in found.points]
    assert {state.stage for state in states} == {"searched", "checked"}
    assert all(0 <= state.unseen_share <= 1 and state.late_share >= 0 for state in states)
    best = found.points[-1].best
    assert (best.met, best.unseen_share, best.robots) == (True, 0.0, len(found.plan.trajectories))
    assert found.lower_bound_robots == 2
    times_s = [point.time_s for point in found.points]
    assert times_s == sorted(times_s)
    assert times_s[0] > 0
    assert times_s[-1] <= found.search_s
    # of what the check did not pass none counts as met, and what it passed is seen whole
    assert all(state.unseen_share == 0 for state in states if state.met)
    assert not any(state.met for state in states if state.stage == "searched")


def test_to_be_watched_changes_nothing(found: PatrolProgress, field: Mission) -> None:
    assert search_plan(field, seed=1).plan == found.plan


def test_table_json_and_csv_tell_the_same(found: PatrolProgress) -> None:
    told = progress_to_json(found)
    assert (told["rota_patrol_progress"], told["mission"], told["effort"], told["seed"]) == (1, "field", "quick", 1)
    assert (told["met"], told["lower_bound_robots"], told["reason"]) == (True, 2, None)
    rows = list(csv.DictReader(progress_to_csv(found).splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == len(told["points"]) == len(found.points)
    for row, point in zip(rows, told["points"], strict=True):
        assert [float(row[name]) for name in COLUMNS if name.endswith(("_s", "share", "robots"))] == [
            point[name] for name in COLUMNS if name.endswith(("_s", "share", "robots"))
        ]
        assert [row[name] for name in ("met", "best_met")] == [str(point[k]).lower() for k in ("met", "best_met")]
    lines = progress_table(found).splitlines()
    tried = list(dict.fromkeys(point.state.robots for point in found.points))
    assert [line.split()[0] for line in lines[1:-1]] == [str(robots) for robots in tried]
    assert sum(int(line.split()[3]) for line in lines[1:-1]) == len(found.points)
    assert lines[-1].startswith(f"{found.points[-1].best.robots} robots (proved: no fewer than 2) after ")


def test_the_map_of_the_study_is_that_of_the_example() -> None:
    assert figure_13() == read_mission(EXAMPLES / "sun2019-fig13.yaml").mission


# ---------------------------------------------------------------- the command


def stand_in(mission: Mission, *, seed: int, judge: Any, watch: Any, **_: Any) -> Plan:
    """Tells of two robots that leave a tenth unseen, then judges one that stands and sees all."""
    if watch is not None:  # nobody watches while compiled loops are loaded
        watch(SearchState(stage="searched", robots=2, unseen_share=0.1, late_share=0.0))
    alone = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[(5.0, 5.0)])
    plan = Plan(mission=mission, trajectories=(alone,), seed=seed, lower_bound_robots=1)
    judge(plan)
    return plan


def hopeless(mission: Mission, **wishes: Any) -> Plan:
    raise NoPlanFound("too far away", best=stand_in(mission, **wishes))


Use = Callable[[Callable[..., Plan]], None]


@pytest.fixture
def use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Use:
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(YARD)
    return lambda planner: monkeypatch.setattr(MAKE_PLAN, "planner_of", standing_in(planner))


def test_the_command_prints_a_table_and_writes_what_is_asked_for(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(stand_in)
    files = ["curve.png", "curve.svg", "curve.pdf", "curve.csv", "curve.json"]
    named = [word for name in files for word in ("-o", name)]
    assert run(["study", "patrol-progress", "yard.yaml", "--seed", "3", "--effort", "quick", *named]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:1] + line.split()[3:] for line in lines[1:3]] == [
        ["2", "1", "0", "10", "%", "-"],
        ["1", "1", "1", "0", "%", lines[2].split()[-1]],
    ]
    assert lines[3].startswith("1 robot (proved: no fewer than 1) after ")
    assert lines[4:] == files
    told = json.loads(Path("curve.json").read_text())
    assert (told["seed"], told["effort"]) == (3, "quick")
    assert [(p["robots"], p["unseen_share"], p["best_robots"], p["best_met"]) for p in told["points"]] == [
        (2, 0.1, 2, False),
        (1, 0.0, 1, True),
    ]
    assert len(Path("curve.csv").read_text().splitlines()) == 3
    assert all(Path(name).stat().st_size > 2000 for name in files[:3])
    with Image.open("curve.png") as picture:
        assert picture.size == (1280, 800)


def test_without_a_mission_it_is_the_papers_map(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(stand_in)
    assert run(["study", "patrol-progress", "-o", "curve.json"]) == 3  # one robot that stands does not do there
    told = json.loads(Path("curve.json").read_text())
    assert (told["mission"], told["effort"], told["met"]) == ("sun2019-fig13", "normal", False)


def test_a_search_without_a_plan_is_an_outcome_too(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(hopeless)
    assert run(["study", "patrol-progress", "yard.yaml", "-o", "curve.json", "-o", "curve.svg"]) == 3
    assert "no plan (proved: no fewer than 1); the search ended after " in capsys.readouterr().out
    told = json.loads(Path("curve.json").read_text())
    assert (told["met"], told["reason"], told["points"][0]["robots"]) == (False, "too far away", 2)


@pytest.mark.parametrize("name", ["curve.bmp", "missing/curve.png", "yard.yaml", "curve"])
def test_outputs_that_cannot_be_are_refused_before_any_search(
    use: Use, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(_: Mission, **__: Any) -> Plan:
        raise AssertionError("searched all the same")

    use(never)
    assert run(["study", "patrol-progress", "yard.yaml", "-o", "fine.csv", "-o", name]) == 2
    assert name.split("/")[0] in capsys.readouterr().err
    assert not Path("fine.csv").exists()


def test_the_input_is_not_overwritten(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(stand_in)
    Path("yard.json").write_text('{"rota": 1}')
    assert run(["study", "patrol-progress", "yard.json", "-o", "yard.json"]) == 2
    assert "is the input itself" in capsys.readouterr().err
    assert Path("yard.json").read_text() == '{"rota": 1}'

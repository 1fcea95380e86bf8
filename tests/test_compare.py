"""Methods side by side: the table, JSON, the picture, exit codes, and methods that find no plan."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from shapely import MultiPolygon, box
from tests.stand_in import standing_in

from rota.command.cli import run
from rota.compare import HEAD, compare_methods, comparison_table, draw_outcomes, named_methods
from rota.errors import MissionError, NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.method_table import METHODS
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.planner import Planner
from rota.routes.distinct_loops import distinct_loops

MAKE_PLAN = importlib.import_module("rota.planning.make_plan")
YARD = """\
rota: 1
name: yard
area: [[0, 0], [10, 0], [10, 10], [0, 10]]
period_s: 40
fleet: {speed_m_s: 1, sensor: {shape: disc, radius_m: 20}}
"""


def loop(name: str, corners: list[tuple[float, float]], begin_m: float = 0.0) -> Trajectory:
    """A closed loop at 1 m/s, begun so far along it."""
    ring = np.array([*corners, corners[0]], float)
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T))]
    marks = np.unique(np.r_[begin_m, along[along > begin_m], along[along < begin_m] + along[-1], begin_m + along[-1]])
    places = np.column_stack([np.interp(np.mod(marks, along[-1]), along, ring[:, k]) for k in (0, 1)])
    places[-1] = places[0]
    return Trajectory(robot=name, times_s=marks - begin_m, positions_m=places)


def stand_in(mission: Mission, **_: Any) -> Plan:
    """Two robots on one loop of 12 m; the method decomposition fails with a plan in hand, parallel without one."""
    square = [(2.0, 2.0), (5.0, 2.0), (5.0, 5.0), (2.0, 5.0)]
    plan = Plan(
        mission=mission, trajectories=(loop("robot-1", square), loop("robot-2", square, 4.5)), lower_bound_robots=1
    )
    if PatrolSettings.of(mission).method == "parallel":
        raise NoPlanFound("nobody can stand anywhere")
    if PatrolSettings.of(mission).method == "decomposition":
        stays = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[(-50.0, 0.0)])
        raise NoPlanFound("too far away", best=Plan(mission=mission, trajectories=(stays,), lower_bound_robots=1))
    return plan


@pytest.fixture
def yard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(MAKE_PLAN, "planner_of", standing_in(stand_in))
    path = tmp_path / "yard.yaml"
    path.write_text(YARD)
    return path


def mission() -> Mission:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=20))
    return Mission(name="yard", area=MultiPolygon([box(0, 0, 10, 10)]), period_s=40, fleet=fleet)


def rows(text: str) -> dict[str, list[str]]:
    """The cells of each row by its first; columns stand apart by two blanks or more."""
    return {cells[0]: cells for cells in ([c.strip() for c in line.split("  ") if c] for line in text.splitlines())}


def test_loops_that_robots_share_count_once() -> None:
    plan = stand_in(mission())
    assert [one.robot for one in distinct_loops(plan)] == ["robot-1"]
    smaller = loop("robot-3", [(2.0, 2.0), (5.0, 2.0), (5.0, 4.0), (2.0, 4.0)])
    moved = loop("robot-4", [(3.0, 2.0), (6.0, 2.0), (6.0, 5.0), (3.0, 5.0)])
    stays = Trajectory(robot="robot-5", times_s=[0.0], positions_m=[(1.0, 1.0)])
    more = Plan(mission=mission(), trajectories=(*plan, smaller, moved, stays))
    assert [one.robot for one in distinct_loops(more)] == ["robot-1", "robot-3", "robot-4"]


def test_every_method_is_a_row_and_failures_say_why(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", "yard.yaml"]) == 3
    out = capsys.readouterr().out
    table = rows(out)
    assert tuple(table) == ("method", *METHODS)
    assert tuple(table["method"]) == HEAD
    # from any place everything is in range: no gap at all
    assert table["tours"][1:5] == ["2", "1", "12.0", "0.000"]
    assert table["tours"][-1] == table["sequential"][-1] == "met"
    assert table["parallel"][1:5] == ["-", "-", "-", "-"]
    assert table["parallel"][-1] == "no plan: nobody can stand anywhere"
    assert table["decomposition"][1:5] == ["1", "1", "0.0", "never"]
    assert table["decomposition"][-1] == "no plan: too far away"


def test_exit_code_0_when_the_methods_asked_for_are_met(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", "yard.yaml", "--methods", "sequential, tours"]) == 0
    assert list(rows(capsys.readouterr().out)) == ["method", "sequential", "tours"]


def test_json_holds_the_same(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", "yard.yaml", "--json", "--seed", "3", "--effort", "quick"]) == 3
    told = json.loads(capsys.readouterr().out)
    assert (told["rota_comparison"], told["mission"], told["effort"], told["seed"]) == (1, "yard", "quick", 3)
    by_method = {entry["method"]: entry for entry in told["methods"]}
    assert list(by_method) == list(METHODS)
    assert by_method["tours"]["loops_m"] == pytest.approx(12)
    assert by_method["tours"]["met"] is True
    assert by_method["decomposition"]["worst_ratio"] is None
    assert by_method["parallel"] == {
        "method": "parallel", "met": False, "robots": None, "lower_bound_robots": None, "loops_m": None,
        "worst_ratio": None, "planning_s": by_method["parallel"]["planning_s"], "stopped_early": False,
        "reason": "nobody can stand anywhere",
    }  # fmt: skip


def test_seed_and_progress_reach_every_method() -> None:
    told: list[tuple[float, str]] = []
    field = Mission(
        name="field", area=MultiPolygon([box(0, 0, 30, 18)]), period_s=20,
        fleet=Fleet(speed_m_s=4, sensor=DiscSensor(radius_m=5)), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    methods = ("sequential", "parallel")
    outcomes = compare_methods(field, methods, seed=7, progress=lambda share, doing: told.append((share, doing)))
    assert [(o.method, o.met, o.plan.seed if o.plan else None) for o in outcomes] == [(m, True, 7) for m in methods]
    assert all(o.worst_ratio is not None and 0.3 < o.worst_ratio <= 1 for o in outcomes)
    assert [share for share, _ in told] == sorted(share for share, _ in told)
    assert {doing.split(":")[0] for _, doing in told} == {"loading", *methods}


@pytest.mark.parametrize(
    ("listed", "told"),
    [
        ("tours,spiral", f"'spiral' is not known; {', '.join(METHODS)} are"),
        ("tours,tours", "'tours' is given twice"),
        ("", "'' is not known"),
    ],
)
def test_wrong_methods_are_bad_input(yard: Path, capsys: pytest.CaptureFixture[str], listed: str, told: str) -> None:
    assert run(["compare", "yard.yaml", "--methods", listed]) == 2
    assert f"methods: {told}" in capsys.readouterr().err


def test_no_methods_at_all_are_refused() -> None:
    with pytest.raises(MissionError, match="none is given; tours, parallel"):
        compare_methods(mission(), ())
    assert named_methods(mission(), None) == tuple(METHODS)


@pytest.mark.parametrize("name", ["plans.png", "plans.svg", "plans.pdf"])
def test_the_picture_has_a_panel_per_method(yard: Path, name: str) -> None:
    assert run(["compare", "yard.yaml", "-o", name]) == 3
    assert Path(name).stat().st_size > 2000
    if name.endswith(".png"):
        with Image.open(name) as picture:
            assert picture.size[0] > 800


@pytest.mark.parametrize("name", ["plans.bmp", "missing/plans.png", "yard.yaml"])
def test_a_picture_that_cannot_be_is_refused_before_any_planning(
    yard: Path, name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(_: Mission) -> Planner:
        raise AssertionError("planned all the same")

    monkeypatch.setattr(MAKE_PLAN, "planner_of", never)
    assert run(["compare", "yard.yaml", "-o", name]) == 2
    assert name.split("/")[0] in capsys.readouterr().err


def test_captions_tell_what_a_plan_comes_to(yard: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    monkeypatch.setattr("rota.draw.draw_comparison", lambda mission, panels, path: seen.extend(panels))
    methods = ("tours", "parallel", "sequential", "decomposition", "sun2019")
    draw_outcomes(mission(), compare_methods(mission(), methods), "plans.png")
    assert [(panel.title, panel.caption, panel.met) for panel in seen] == [
        ("tours", "2 robots · loops 12 m · worst gap 0.00", True),
        ("parallel", "no plan: nobody can stand anywhere", False),
        ("sequential", "2 robots · loops 12 m · worst gap 0.00", True),
        ("decomposition", "1 robot · loops 0 m · some of it is never seen · not met", False),
        ("sun2019", "2 robots · loops 12 m · worst gap 0.00", True),
    ]


def test_a_table_without_rows_is_its_head() -> None:
    assert comparison_table(()).split("  ") == list(HEAD)

"""`rota replan`: what it writes and tells, its exit codes, and bad input."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.replanning.rings import ring_plan

from rota.command.cli import run
from rota.files.mission_writer import write_mission
from rota.files.plan_file import read_plan, write_plan


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ring") / "ring.rota.json"
    write_plan(ring_plan(45, {"a": 0.0, "b": 20.0}), path)
    return path


def test_a_lost_robot(pair: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new = tmp_path / "new.rota.json"
    assert run(["replan", str(pair), "--at", "100", "--lost", "b", "-o", str(new)]) == 0
    told = capsys.readouterr()
    assert "On their ways as before: a. On others: none." in told.out
    assert "Since the change at t = 100 s of the plan before (b lost): nothing is late." in told.out
    plan = read_plan(new)
    assert plan.seam is not None
    assert plan.seam.lost == ("b",)
    assert run(["check", str(new)]) == 0
    assert "(b lost): nothing is late" in capsys.readouterr().out


def test_those_that_remain_may_not_be_enough(pair: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed, new = tmp_path / "changed.yaml", tmp_path / "new.rota.json"
    write_mission(ring_plan(25, {"a": 0.0}).mission, changed)
    given = ["--lost", "b", "--mission", str(changed), "--time-limit", "0.1"]
    assert run(["replan", str(pair), "--at", "100", *given, "-o", str(new)]) == 1
    told = capsys.readouterr()
    assert "The robots that remain were not found to meet the demand." in told.out
    assert "after" in told.err
    assert '"meets_demand": false' in new.read_text()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--at", "nan"], "--at: nan is not allowed"),
        (["--at", "-3"], "--at: -3.0 is not allowed"),
        (["--at", "3", "--lost", "robot-9"], "--lost: robot 'robot-9' is not in the plan; the plan has a, b"),
        (["--at", "3", "--joined", "c=1"], "--joined: 'c=1' is not allowed; NAME=X,Y is needed"),
        (["--at", "3", "--joined", "c=1,x"], "'x' is no number"),
        (["--at", "3", "--joined", "c=5,5"], "robot c: at t = 3 s it is at (5.00, 5.00)"),
        (["--at", "3", "--late", "7"], "--late: '7' is not allowed; NAME=S is needed"),
        (["--at", "3", "--late", "a=nan"], "--late: a=nan is not allowed"),
        (["--at", "3", "--late", "a=2", "--late", "a=5"], "--late: robot 'a' is given twice; once is allowed"),
        (["--at", "3", "--joined", "c=1,2", "--joined", "c=2,1"], "--joined: robot 'c' is given twice"),
        (["--at", "3", "--mission", "nowhere.yaml"], "nowhere.yaml"),
        (["--at", "x"], '--at: "x" is not allowed; a number is needed'),
        (["--at", "3", "--seed", "-1"], '--seed: "-1" is not allowed; it must be at least 0'),
        (["--at", "3", "--joined", "c=1e300,2"], "--joined: c=1e+300,2.0 is not allowed; x,y in metres, from"),
        (["--at", "3", "--joined", " =1,2"], "robot.name: ' ' is not allowed; must not be empty, nor blank"),
        (["--at", "3", "--late", "a=1e12"], "seconds from 0 to 1e+10 are needed"),
        (["--at", "3", "--battery", "a=0.5"], "--battery: a=0.5 is not allowed; batteries never run low in this plan"),
    ],
)
def test_bad_input_is_told_and_nothing_written(
    pair: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], given: list[str], message: str
) -> None:
    new = tmp_path / "new.rota.json"
    assert run(["replan", str(pair), *given, "-o", str(new)]) == 2
    assert message in capsys.readouterr().err
    assert not new.exists()


def test_the_plan_itself_is_not_overwritten(pair: Path) -> None:
    assert run(["replan", str(pair), "--at", "3", "-o", str(pair)]) == 2

"""`rota straighten`: as far as a plan stays met, or as far as one says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from shapely import box
from tests.vehicles.small_plans import winding

from rota.command.cli import run
from rota.files.plan_file import read_plan, write_plan
from rota.model.mission import Obstacle
from rota.model.plan import Plan


def corridor(north_m: float) -> Plan:
    """A plan whose points are up to 0.3 m north of a straight way, in a corridor that ends so far north of it."""
    plan = winding(0.3)
    area = box(-1, -1, 61, north_m).union(box(59, -1, 61, 61))
    return replace(plan, mission=replace(plan.mission, area=area))


def test_as_much_goes_as_leaves_the_plan_met(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, straight = tmp_path / "plan.json", tmp_path / "straight.json"
    write_plan(corridor(0.3), path)
    assert run(["straighten", str(path), "-o", str(straight)]) == 0
    assert "50 points become 6, at any moment within 1 m: met" in capsys.readouterr().err
    assert run(["check", str(straight)]) == 0
    assert len(read_plan(straight).trajectories[0].times_s) == 6
    # a bollard on the straight way, which the plan passes in the north
    plan = corridor(0.3)
    bollard = Obstacle(shape=box(4.9, -0.2, 5.1, 0.15), blocks="motion")
    write_plan(replace(plan, mission=replace(plan.mission, obstacles=(bollard,))), path)
    assert run(["straighten", str(path), "-o", str(straight)]) == 0
    assert "at any moment within 0.2 m: met" in capsys.readouterr().err
    assert len(read_plan(straight).trajectories[0].times_s) > 20
    assert run(["straighten", str(path), "-o", "-", "--within-m", "0.1"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith('{"rota_plan": 1')
    assert "at any moment within 0.1 m: met" in told.err


def test_a_plan_that_is_not_met_is_straightened_only_when_one_says_how_far(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, straight = tmp_path / "plan.json", tmp_path / "straight.json"
    plan = corridor(1.3)
    write_plan(replace(plan, mission=replace(plan.mission, period_s=20)), path)
    assert run(["straighten", str(path), "-o", str(straight)]) == 2
    assert "not met within 0.01 m of its ways, either" in capsys.readouterr().err
    assert not straight.exists()
    assert run(["straighten", str(path), "-o", str(straight), "--within-m", "1"]) == 1
    assert len(read_plan(straight).trajectories[0].times_s) == 6
    for text, said in (("0", "within_m: 0 is not allowed"), ("-1", "within_m: -1 is not allowed")):
        assert run(["straighten", str(path), "-o", str(straight), "--within-m", text]) == 2
        assert said in capsys.readouterr().err
    assert run(["straighten", str(path), "-o", str(path)]) == 2

"""Stage algorithms where no other distribution offers any: plans are the same, and what others bring is refused."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import rota
from rota.errors import MissionError
from rota.files.plan_file import plan_from_json, plan_to_json
from rota.planners.patrol.methods.sun2019 import mission_settings, our_settings

YARD = """\
rota: 1
name: yard
area: [[0, 0], [24, 0], [24, 16], [0, 16]]
zones: [{name: gate, ring: [[14, 4], [20, 4], [20, 10], [14, 10]], period_s: 20}]
period_s: 60
fleet: {speed_m_s: 2, sensor: {shape: disc, radius_m: 4}}
patrol: {effort: quick, method: sun2019, sun2019: STAGES}
"""
OURS = [
    "{}",
    "{deployment: exact}",
]
THEIRS = [
    "{deployment: ccpso2}",
    "{tour: genetic}",
    "{partition: pso}",
    "{routes: printed}",
    "{segments: {swarms: 9}}",
    "{sensors: {iterations: 9}}",
    "{frame: {population: 40}}",
]
# what a plan file says of a mission that another distribution's algorithms have planned, without its digest
THEIR_PLAN = [("partition", "pso"), ("segments", {"swarms": 9})]
ALONE = """\
import importlib.metadata, json, sys
found = importlib.metadata.entry_points
importlib.metadata.entry_points = lambda **asked: () if asked == {"group": "rota.sun2019"} else found(**asked)
from pathlib import Path
from tests.planners.patrol.methods.sun2019.test_algorithms import plans, refusals
folder = Path(sys.argv[1])
plans(folder)
print(json.dumps({"told": refusals(folder), "studies": [name for name in sys.modules if "rota_studies" in name]}))
"""


def mission_of(folder: Path, stages: str, effort: str = "quick") -> rota.Mission:
    path = folder / "yard.yaml"
    path.write_text(YARD.replace("STAGES", stages).replace("quick", effort))
    return rota.read_mission(path).mission


def refusal_of(asked: Any) -> str:
    try:
        asked()
    except rota.RotaError as error:
        return f"{type(error).__name__}: {error}"
    return "nothing"


def plans(folder: Path) -> list[rota.Plan]:
    """Plans by ours, and at every effort; each is kept in a file as well."""
    asked = [mission_of(folder, stages) for stages in OURS]
    asked += [mission_of(folder, "{}", effort) for effort in ("normal", "high")]
    made = [rota.make_plan(mission, seed=3) for mission in asked]
    for k, plan in enumerate(made):
        rota.write_plan(plan, folder / f"{k}.rota.json")
    return made


def refusals(folder: Path) -> dict[str, str]:
    """What is said of theirs, in mission files, plan files and Python."""
    told = {stages: refusal_of(lambda stages=stages: mission_of(folder, stages)) for stages in THEIRS}
    mission = mission_of(folder, "{}")
    stay = rota.Trajectory(robot="robot-1", times_s=[0.0], positions_m=[[2.0, 2.0]])
    document = plan_to_json(rota.Plan(mission=mission, trajectories=(stay,)))
    del document["mission_sha256"]
    own = document["mission"]["patrol"]["sun2019"]
    for key, value in THEIR_PLAN:
        document["mission"]["patrol"]["sun2019"] = {**own, key: value}
        told[f"plan {key}"] = refusal_of(lambda: plan_from_json(document))
    told["Python"] = refusal_of(lambda: mission_settings.Sun2019(deployment="ccpso2"))
    return told


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The answers of a process that finds no other distribution."""
    folder = tmp_path_factory.mktemp("alone")
    root = Path(__file__).parents[5]
    done = subprocess.run(
        [sys.executable, "-c", ALONE, str(folder)], capture_output=True, text=True, check=True, cwd=root
    )
    return {**json.loads(done.stdout.splitlines()[-1]), "folder": folder}


@pytest.mark.slow  # plans in a process without rota_studies, and here
def test_plans_do_not_depend_on_what_is_installed(alone: dict[str, Any], tmp_path: Path) -> None:
    assert alone["studies"] == []
    for k, plan in enumerate(plans(tmp_path)):
        assert rota.read_plan(alone["folder"] / f"{k}.rota.json") == plan


@pytest.mark.slow  # from the same process
def test_what_the_studies_bring_is_refused_by_its_place_with_what_is_allowed_and_who_brings_it(
    alone: dict[str, Any],
) -> None:
    told = alone["told"]
    assert (
        '/yard.yaml:7:64: patrol.sun2019.deployment: "ccpso2" is not allowed; best, greedy or exact is needed; '
        in (told["{deployment: ccpso2}"])
    )
    assert 'patrol.sun2019.tour: "genetic" is not allowed; local_search is needed; ' in told["{tour: genetic}"]
    assert 'patrol.sun2019.partition: "pso" is not allowed; exact is needed; ' in told["{partition: pso}"]
    assert 'patrol.sun2019.routes: "printed" is not allowed; shortened is needed; ' in told["{routes: printed}"]
    known = "unknown key; known here: deployment, tour, partition, routes; "
    assert f"/yard.yaml:7:52: patrol.sun2019.segments: {known}" in told["{segments: {swarms: 9}}"]
    assert f"patrol.sun2019.sensors: {known}" in told["{sensors: {iterations: 9}}"]
    assert f"patrol.sun2019.frame: {known}" in told["{frame: {population: 40}}"]
    assert told["plan partition"].startswith("PlanError: ")
    assert 'patrol.sun2019.partition: "pso" is not allowed; exact is needed; ' in told["plan partition"]
    assert "patrol.sun2019.segments: unknown key; known here: " in told["plan segments"]
    assert told["Python"].startswith('MissionError: patrol.sun2019.deployment: "ccpso2" is not allowed; best, ')
    for sentence in told.values():
        assert sentence.count("come with the distribution rota-studies, which is not installed") == 1, sentence
        assert sentence.endswith("`pip install ./studies` in a checkout of Rota installs it"), sentence
        assert "\n" not in sentence


def test_with_the_studies_the_same_names_are_allowed(tmp_path: Path) -> None:
    told = refusals(tmp_path)
    allowed = (
        "{deployment: ccpso2}",
        "{routes: printed}",
        "{tour: genetic}",
        "{partition: pso}",
        "plan partition",
        "Python",
    )
    assert {told[where] for where in allowed} == {"nothing"}
    assert all("rota-studies" not in sentence for sentence in told.values())


def test_without_an_offer_settings_are_ours_and_a_broken_one_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mission_settings, "offers", lambda group: {})
    assert mission_settings.offered_settings() is our_settings.Sun2019
    monkeypatch.setattr(mission_settings, "offers", lambda group: {"settings": "rota_nowhere.settings:Sun2019"})
    told = r"patrol\.sun2019: its settings cannot be loaded from rota_nowhere\.settings:Sun2019: No module named"
    with pytest.raises(MissionError, match=told):
        mission_settings.offered_settings()

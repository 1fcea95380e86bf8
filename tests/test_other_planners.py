"""A planner that lives in another distribution is planned with, checked, drawn, exported and read like Rota's own."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent

import pytest

from rota.check import check_plan
from rota.command.cli import run
from rota.errors import MissionError, PlanError
from rota.files.mission_file import mission_schema, read_mission
from rota.files.plan_file import read_plan
from rota.model.planner_registry import door_of, offered_planners, planner_names
from rota.planning.planner import planner_named

CONTRIBUTING = Path(__file__).parents[1] / "docs" / "contributing.md"
BLOCK = re.compile(r"^ *```(\w+)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)

# one robot drives round the middle of the area
DOOR = '''
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from rota.model.plan import Plan, Trajectory
from rota.planning.planner import Answer, Planner
from rota.model.planner_settings import PlannerSettings, setting
from rota.model.refusals import inner


@dataclass(frozen=True, kw_only=True)
class MerryGoRoundSettings(PlannerSettings):
    """Settings of the merry-go-round."""

    planner: ClassVar[str] = "merry_go_round"
    radius_m: float = setting(2.0, "of the circle", above=0, most=100)
    way: Literal["left", "right"] = setting("left", "which way round")
    corners: int = setting(12, "of the circle", least=3)

    @classmethod
    def refusals(cls, data):
        if inner(data, "fleet", "robots") not in (1, None, "fewest"):
            yield ("fleet", "robots"), "only one robot fits on the merry-go-round"


class MerryGoRound(Planner):
    settings = MerryGoRoundSettings

    def plan(self, request):
        mission = request.mission
        settings = MerryGoRoundSettings.of(mission)
        request.progress(0.5, "going round")
        centre = np.array(mission.area.centroid.coords[0])
        turns = np.linspace(0, 2 * np.pi, settings.corners + 1) * (1 if settings.way == "left" else -1)
        places = centre + settings.radius_m * np.column_stack([np.cos(turns), np.sin(turns)])
        places[-1] = places[0]
        steps = np.hypot(*np.diff(places, axis=0).T) / mission.fleet.speed_m_s
        loop = Trajectory(robot="robot-1", times_s=np.r_[0, np.cumsum(steps)], positions_m=places)
        return Answer(plan=Plan(mission=mission, trajectories=(loop,)), facts=("It goes round and round.",))

    def sentences(self, answer, report):
        yield from super().sentences(answer, report)
        yield f"{len(answer.plan.trajectories[0].times_s) - 1} corners."
'''
MISSION = """\
rota: 1
name: fair
area: [[0, 0], [10, 0], [10, 10], [0, 10]]
period_s: 60
fleet: {speed_m_s: 1, sensor: {shape: disc, radius_m: 8}}
planner: merry_go_round
merry_go_round: {way: right, radius_m: 3}
"""


def install(site: Path, name: str, entries: str, group: str = "rota.planners") -> None:
    """The metadata of a distribution that offers planners or commands, beside its modules."""
    info = site / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{entries}")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of installed distributions, beside which is the folder of work."""
    site = tmp_path / "site-packages"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.chdir(tmp_path)
    for cached in (offered_planners, door_of):
        cached.cache_clear()
    yield site
    for cached in (offered_planners, door_of):
        cached.cache_clear()
    for name in [name for name in sys.modules if name.partition(".")[0] in ("merry", "posts")]:
        del sys.modules[name]


@pytest.fixture
def fair(site: Path) -> Path:
    """A folder with a mission, where the distribution of the merry-go-round is installed."""
    (site / "merry" / "go").mkdir(parents=True)
    (site / "merry" / "__init__.py").touch()
    (site / "merry" / "go" / "__init__.py").write_text(DOOR)
    (site / "merry" / "faulty.py").write_text("1 / 0\n")
    entries = "merry_go_round = merry.go:MerryGoRound\nbroken = merry.nowhere:Nothing\n"
    install(site, "merry_go_round", entries + "faulty = merry.faulty:Door\nrenamed = merry.go:MerryGoRound\n")
    (site.parent / "fair.yaml").write_text(MISSION)
    return site.parent


def test_it_is_planned_checked_drawn_and_exported(fair: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", "fair.yaml"]) == 0
    told = capsys.readouterr().out
    assert told.index("It goes round and round.") < told.index("12 corners.") < told.index("Check: met")
    assert run(["check", "fair.rota.json"]) == 0
    assert run(["draw", "fair.rota.json", "-o", "fair.png"]) == 0
    assert run(["animate", "fair.rota.json", "-o", "fair.gif", "--seconds", "0.5"]) == 0
    assert run(["export", "fair.rota.json", "--to", "geojson", "-o", "fair.geojson"]) == 0
    assert json.loads(Path("fair.geojson").read_text())["features"]
    assert all(Path(f"fair.{kind}").stat().st_size > 1000 for kind in ("png", "gif"))


def test_its_plans_and_settings_come_back_from_files(fair: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mission = read_mission("fair.yaml").mission
    assert mission.planning == planner_named("merry_go_round").settings(radius_m=3.0, way="right")
    assert run(["plan", "fair.yaml"]) == 0
    plan = read_plan("fair.rota.json")
    assert plan.mission.planning == mission.planning
    assert check_plan(plan).verdict == "met"
    block = mission_schema()["properties"]["merry_go_round"]["anyOf"][0]["properties"]
    assert block["radius_m"] == {
        "type": "number", "exclusiveMinimum": 0, "maximum": 100, "default": 2.0, "description": "of the circle",
    }  # fmt: skip


def test_its_faults_are_told_like_those_of_others(fair: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = MISSION.replace("fleet: {", "fleet: {robots: 2, ").replace("radius_m: 3}", "radius_m: 300, corner: 5}")
    wrong += "moving_obstacles: [{radius_m: 1, times_s: [0], positions_m: [[1, 1]]}]\n"
    Path("wrong.yaml").write_text(wrong)
    assert run(["plan", "wrong.yaml"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "rota: error: wrong.yaml:5:17: fleet.robots: only one robot fits on the merry-go-round",
        "rota: error: wrong.yaml:7:40: merry_go_round.radius_m: 300 is not allowed; it must be at most 100",
        "rota: error: wrong.yaml:7:45: merry_go_round.corner: unknown key; did you mean 'corners'?",
        "rota: error: wrong.yaml:8:19: moving_obstacles: the merry_go_round planner has no use for moving_obstacles:"
        " remove them",
    ]
    assert run(["plan", "fair.yaml", "--effort", "quick"]) == 2
    assert "the merry_go_round planner has no effort: leave it out" in capsys.readouterr().err
    assert run(["compare", "fair.yaml"]) == 2
    assert "the merry_go_round planner has none that could be compared" in capsys.readouterr().err
    Path("other.yaml").write_text(MISSION.replace("planner: merry_go_round", "planner: patrol"))
    with pytest.raises(MissionError, match=r"merry_go_round: settings of another planner; planner is patrol"):
        read_mission("other.yaml")


def test_a_door_that_cannot_be_opened_is_told(fair: Path) -> None:
    assert planner_names() == ("patrol", "swarm", "bounce", "broken", "faulty", "merry_go_round", "renamed")
    with pytest.raises(MissionError, match=r"planner: broken cannot be loaded from merry\.nowhere:Nothing: No module"):
        planner_named("broken")
    with pytest.raises(MissionError, match=r"faulty cannot be loaded from merry\.faulty:Door: division by zero"):
        planner_named("faulty")
    with pytest.raises(MissionError, match="offered as renamed, but its settings have the name merry_go_round"):
        planner_named("renamed")
    Path("broken.yaml").write_text(MISSION.partition("merry")[0].replace("planner: ", "planner: broken\n"))
    with pytest.raises(MissionError, match="planner: broken cannot be loaded"):
        read_mission("broken.yaml")


def test_without_its_distribution_it_is_not_known(fair: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(["plan", "fair.yaml"]) == 0
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if not entry.startswith(str(fair))])
    for cached in (offered_planners, door_of):
        cached.cache_clear()
    with pytest.raises(MissionError, match=r'planner: "merry_go_round" is not allowed; patrol, swarm or bounce is'):
        read_mission("fair.yaml")
    with pytest.raises(PlanError, match=r'planner: "merry_go_round" is not allowed; patrol, swarm or bounce is'):
        read_plan("fair.rota.json")


def test_the_planner_that_contributing_shows(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, _, page = CONTRIBUTING.read_text().partition("## Add a planner")
    blocks = {kind: [dedent(code) for told, code in BLOCK.findall(page) if told == kind] for kind in ("toml", "python")}
    (site / "posts.py").write_text("\n\n".join(blocks["python"]))
    (entry,) = blocks["toml"]
    (named,) = tomllib.loads(entry)["project"]["entry-points"]["rota.planners"].items()
    install(site, "posts", " = ".join(named))
    watched = MISSION.partition("planner")[0].replace("fleet: {", "fleet: {robots: 2, ") + "planner: posts\n"
    Path("watched.yaml").write_text(watched)
    assert run(["plan", "watched.yaml"]) == 0
    assert "1 demands are seen from the posts." in capsys.readouterr().out
    Path("close.yaml").write_text(watched + "posts: {apart_m: 6}\n")
    assert run(["plan", "close.yaml"]) == 3
    assert "the area is too narrow for so many posts" in capsys.readouterr().err
    Path("fewest.yaml").write_text(watched.replace("robots: 2, ", ""))
    assert run(["plan", "fewest.yaml"]) == 2
    assert "fleet.robots: fewest is not allowed: posts need a number of robots" in capsys.readouterr().err

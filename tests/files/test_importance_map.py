"""Maps of importance in mission and plan files: where they lie, what they are worth, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.files.test_height_map import geotiff

from rota import Plan, Trajectory
from rota.errors import MissionError, PlanError
from rota.files.mission_file import read_mission
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.mission import ImportanceMap, Mission

MISSION = """\
rota: 1
name: m
area: [[0, 0], [40, 0], [40, 20], [0, 20]]
importance: {importance}
fleet: {{robots: 2, speed_m_s: 1, sensor: {{shape: disc, radius_m: 5}}}}
planner: swarm
"""


def read(folder: Path, importance: str) -> Mission:
    path = folder / "m.yaml"
    path.write_text(MISSION.format(importance=importance))
    return read_mission(path).mission


def picture(folder: Path, values: object) -> None:
    Image.fromarray(np.array(values, np.uint8)).save(folder / "hot.png")


def test_black_and_white_are_worth_what_the_mission_says_with_north_up(tmp_path: Path) -> None:
    picture(tmp_path, [[0, 51, 102, 255], [0, 0, 0, 204]])
    light = read(tmp_path, "{map: hot.png, black: 1, white: 11}").importance
    dark = read(tmp_path, "{map: hot.png, black: 10, white: 0}").importance
    assert isinstance(light, ImportanceMap)
    assert isinstance(dark, ImportanceMap)
    assert light.values.tolist() == [[1, 1, 1, 9], [1, 3, 5, 11]]
    assert dark.values[1].tolist() == [10, 8, 6, 0]
    assert light.at(np.array([35.0, 20, 99]), np.array([15.0, 10, -9])).tolist() == [11, (3 + 5 + 1 + 1) / 4, 9]


def test_a_geotiff_holds_importance(tmp_path: Path) -> None:
    y, x = np.mgrid[30:-1:-1, 0:60].astype(float)
    geotiff(tmp_path / "hot.tif", x + 100 * y, (1.0, 1.0), (-0.5, 30.5))
    found = read(tmp_path, "{map: hot.tif}").importance
    assert isinstance(found, ImportanceMap)
    at_m = np.array([3.0, 39.0]), np.array([2.0, 17.0])
    assert found.at(*at_m) == pytest.approx([203, 1739], rel=1e-4)


def test_a_fine_map_is_averaged_down(tmp_path: Path) -> None:
    picture(tmp_path, np.kron(np.eye(2), np.full((600, 1200), 200)))
    found = read(tmp_path, "{map: hot.png, black: 0, white: 255}").importance
    assert isinstance(found, ImportanceMap)
    assert found.values.size <= 2**18
    assert found.values.mean() == pytest.approx(100, rel=1e-3)
    assert found.at(np.array([10.0, 30.0]), np.array([15.0, 15.0])).tolist() == [200, 0]


def test_a_plan_file_holds_the_map(tmp_path: Path) -> None:
    picture(tmp_path, [[0, 51, 102, 255], [0, 0, 0, 204]])
    mission = read(tmp_path, "{map: hot.png, black: 0.1, white: 7.3}")
    robots = mission.fleet.robots or ()
    still = tuple(Trajectory(robot=robot.name, times_s=[0.0], positions_m=[[1.0, 1.0]]) for robot in robots)
    plan = Plan(mission=mission, trajectories=still)
    again = plan_from_text(plan_text(plan), "p")
    assert again == plan
    assert hash(again.mission) == hash(mission)
    document = json.loads(plan_text(plan))
    document.pop("mission_sha256")
    for values, words in [
        ([[1, 2], [3]], "rows of different lengths"),
        ([[1, -2]], r"mission.importance.values\[0\]\[1\]: -2 is not allowed; it must be at least 0"),
        ([[0, 0]], "some ground must be worth more than 0"),
    ]:
        document["mission"]["importance"]["values"] = values
        with pytest.raises(PlanError, match=words):
            plan_from_text(json.dumps(document), "p")


@pytest.mark.parametrize(
    ("importance", "words"),
    [
        ("{map: hot.png}", "black and white are needed: a picture does not say"),
        ("{map: hot.png, black: 0, white: 0}", "is worth 0 all over the area; some ground must be worth more"),
        ("{map: tall.png, black: 0, white: 1}", "20 x 40 pixels over 40 m x 20 m; .* 20 x 10 are needed"),
        ("{map: low.tif}", "holds -3; a number from 0 to 1e[+]06 is needed"),
        ("{map: gaps.tif}", "has no importance for part of the mission's area"),
        ("{map: small.tif}", "covers 27% of the box round the mission's area; all is needed"),
    ],
)
def test_maps_that_say_too_little_or_lie_elsewhere_are_refused(tmp_path: Path, importance: str, words: str) -> None:
    picture(tmp_path, [[0, 51, 102, 255], [0, 0, 0, 204]])
    Image.fromarray(np.zeros((40, 20), np.uint8)).save(tmp_path / "tall.png")
    geotiff(tmp_path / "low.tif", np.full((20, 40), -3.0), (1.0, 1.0), (0.0, 20.0))
    geotiff(tmp_path / "gaps.tif", np.full((20, 40), np.nan), (1.0, 1.0), (0.0, 20.0))
    geotiff(tmp_path / "small.tif", np.ones((10, 20)), (1.0, 1.0), (0.0, 10.0))
    with pytest.raises(MissionError, match=rf"m.yaml:4:19: importance.map: .*{words}"):
        read(tmp_path, importance)

"""What is told of long work before it begins."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from benchmarks.missions import example_missions
from shapely import MultiPolygon, Polygon, box

from rota.command.terminal import reading_ahead
from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.work_ahead import planning_ahead
from rota.planning.planner import planner_of


def field(area: Polygon, *, period_s: float = 600, radius_m: float = 10, turn_rate: float | None = None) -> Mission:
    fleet = Fleet(speed_m_s=15, sensor=DiscSensor(radius_m=radius_m), turn_rate_rad_s=turn_rate)
    return Mission(name="field", area=MultiPolygon([area]), period_s=period_s, fleet=fleet)


def test_nothing_is_told_of_the_examples() -> None:
    for path in example_missions():
        mission = read_mission(path).mission
        assert list(planner_of(mission).long_work(mission)) == []
        assert reading_ahead(path) is None


def test_large_ground_and_many_robots_are_told_with_an_estimate() -> None:
    (told,) = planning_ahead(field(box(0, 0, 10_000, 10_000), period_s=36_000, radius_m=6))
    assert told == (
        "2,777,778 squares of the sensor's reach to watch: at effort quick about 16 minutes and 12 GB,"
        " more at the others"
    )
    (told,) = planning_ahead(field(box(0, 0, 1000, 1000), period_s=10))
    open_ground = "about 333 robots are needed to sweep the area in 10 s: at effort quick about 10 s in the open"
    assert told == open_ground
    (told,) = planning_ahead(field(box(0, 0, 1000, 1000).difference(box(500, 500, 501, 501)), period_s=10))
    assert told == f"{open_ground}, up to 7 minutes where walls are in the way"


def test_many_corners_and_slow_turning_are_told() -> None:
    angles = np.linspace(0, 2 * math.pi, 3000, endpoint=False)
    circle = Polygon(50 * np.column_stack([np.cos(angles), np.sin(angles)]))
    assert list(planning_ahead(field(circle))) == ["3,001 corners of walls: about 21 s to find the ways round them"]
    (told,) = planning_ahead(field(shapely.segmentize(circle, 0.01)))
    assert told.endswith("ways round them; close_gaps_m beside area.map counts narrow nooks as wall")
    assert list(planning_ahead(field(box(0, 0, 60, 40), turn_rate=0.0105))) == []
    (told,) = planning_ahead(field(box(0, 0, 60, 40), turn_rate=0.01))
    assert told.startswith("turning round once takes 628.3 s, longer than any period")


@pytest.mark.parametrize(
    ("megabytes", "told"), [(1, None), (4, "4.0 MB: about 28 s"), (60, "60.0 MB: about 7 minutes")]
)
def test_large_files_are_told(megabytes: int, told: str | None, tmp_path: Path) -> None:
    path = tmp_path / "mission.yaml"
    with path.open("wb") as file:
        file.truncate(megabytes * 1_000_000)
    found = reading_ahead(path)
    assert found is None if told is None else found is not None and found.endswith(told)
    assert reading_ahead(tmp_path / "nowhere.yaml") is None

"""Missions, plans and reports as Python and notebooks show them."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
import shapely

import rota
from rota import DiscSensor, Fleet, Mission, Obstacle, Plan, Trajectory, Zone

SVG = "{http://www.w3.org/2000/svg}"
MISSION = Mission(
    name="<yard> & co",
    area=shapely.box(0, 0, 40, 30),
    obstacles=(Obstacle(shape=shapely.box(10, 10, 12, 12)),),
    zones=(Zone(name="gate", shape=shapely.box(30, 20, 40, 30), period_s=20),),
    period_s=60,
    fleet=Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=4)),
)
LOOP = Trajectory(robot="robot-1", times_s=[0, 4, 8], positions_m=[[5, 5], [25, 5], [5, 5]])
POST = Trajectory(robot="robot-2", times_s=[0], positions_m=[[35, 25]])
PLAN = Plan(mission=MISSION, trajectories=(LOOP, POST), seed=3, lower_bound_robots=2)


def test_a_plan_is_asked_for_robots_by_name() -> None:
    assert len(PLAN) == 2
    assert PLAN["robot-2"] is POST
    assert [each.robot for each in PLAN] == ["robot-1", "robot-2"]
    with pytest.raises(KeyError, match="'robot-3'; the plan has 'robot-1', 'robot-2'"):
        PLAN["robot-3"]


def test_a_plan_without_robots_is_a_plan() -> None:
    none = Plan(mission=MISSION, trajectories=())
    assert len(none) == 0
    assert none
    assert len(none.to_dataframe()) == 0


def test_what_is_printed_is_short() -> None:
    assert repr(PLAN) == "<Plan of '<yard> & co': 2 robots, 2 at least, seed 3>"
    assert (
        repr(MISSION) == "<Mission '<yard> & co' for patrol: 1,200 m2, 1 zone, 1 obstacle, as few robots as possible>"
    )
    assert repr(LOOP) == "<Trajectory 'robot-1': 3 points, a loop of 40.0 m in 8.0 s>"
    assert repr(POST) == "<Trajectory 'robot-2': 1 point, stays>"
    assert repr(rota.check_plan(PLAN)).startswith("<Report violated: 2 robots, worst gap inf of its period")


def test_a_notebook_shows_a_map_and_a_table() -> None:
    page = ET.fromstring(f"<html>{PLAN._repr_html_()}</html>")
    picture = page.find(f".//{SVG}svg")
    assert picture is not None
    # 40 m by 30 m with 0.8 m beside them, in 480 by 360 pixels
    scale = 360 / 31.6
    assert (picture.get("width"), picture.get("height")) == (f"{41.6 * scale:.0f}", "360")
    (way,) = [
        p for p in picture.findall(f"{SVG}path") if p.get("stroke") == "#0072B2" and p.get("stroke-width") == "1.5"
    ]
    assert way.get("d", "").startswith(f"M{5.8 * scale:.1f} {25.8 * scale:.1f}L{25.8 * scale:.1f} ")
    assert [cell.text for cell in page.findall(".//td")][1:3] == ["40.0", "8.0"]
    zone = ET.fromstring(f"<html>{MISSION._repr_html_()}</html>").findall(".//td")
    assert [cell.text for cell in zone] == [
        "gate",
        "20 s",
        "every point",
        "ground outside zones",
        "60 s",
        "every point",
    ]


def test_all_timed_points_as_a_table() -> None:
    table = PLAN.to_dataframe()
    assert table["robot"].tolist() == ["robot-1"] * 3 + ["robot-2"]
    np.testing.assert_array_equal(table[["time_s", "x_m", "y_m"]], [[0, 5, 5], [4, 25, 5], [8, 5, 5], [0, 35, 25]])
    assert table["in_loop"].all()
    assert table["z_m"].isna().all()


def test_the_demands_of_a_report_as_a_table() -> None:
    report = rota.check_plan(PLAN)
    table = report.to_dataframe()
    assert table["name"].tolist() == [demand.name for demand in report.demands]
    assert table["worst_gap_s"].tolist() == [demand.worst_gap_s for demand in report.demands]
    assert "area: violated, worst gap never, period 60 s" in report._repr_html_()


def test_worst_gaps_at_points() -> None:
    # on the way: seen when it is within 4 m, from 3.2 s on until 4.8 s of 8 at the far end, 0.8 s on either side
    gaps_s = rota.worst_gaps_s(PLAN, [[25, 5], [35, 25], [2, 28]])
    assert gaps_s == pytest.approx([8 - 2 * 4 / 5, 0, np.inf])

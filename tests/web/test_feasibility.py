"""Missions whose every value is allowed, and that cannot work."""

from __future__ import annotations

import math
from typing import Any

import pytest
import shapely

from rota.model.mission import DiscSensor, Fleet, Mission, Robot, StartBox, StartPoints
from rota.web.tasks.feasibility import doubtful, hopeless

SIDE_M = 100.0


def mission(period_s: float | None = 120.0, **fleet: Any) -> Mission:
    usual: dict[str, Any] = {"speed_m_s": 5, "sensor": DiscSensor(radius_m=15), "body_radius_m": 0.5}
    area = shapely.MultiPolygon([shapely.box(0, 0, SIDE_M, SIDE_M)])
    return Mission(name="field", area=area, period_s=period_s, fleet=Fleet(**{**usual, **fleet}))


def test_starts_for_fewer_robots_than_any_plan_needs_are_a_fault() -> None:
    one = mission(start=StartPoints(points_m=((10, 10),)))
    (told,) = hopeless(one, 4)
    assert told["path"] == ["fleet", "start"]
    assert "1 start is given, and at least 4 robots" in told["message"]
    assert list(hopeless(one, 1)) == []
    assert [warning["path"] for warning in doubtful(one, 1)] == [["fleet", "start"]]


def test_a_box_holds_no_more_bodies_than_the_closest_packing() -> None:
    # four bodies of 0.5 m stand with their centres on the corners of a square of 1 m, and no five do
    square = StartBox(low_m=(10, 10), high_m=(11, 11))
    assert list(hopeless(mission(start=square), 4)) == []
    (told,) = hopeless(mission(start=square), 5)
    assert told["path"] == ["fleet", "start", "box"]
    # lying as close as discs can, in rows that are a whole number of bodies long, n of them always have room
    for rows in (1, 3, 20):
        high_m = (rows - 1) * math.sqrt(3) / 2
        box = StartBox(low_m=(10, 10), high_m=(29.5, 10 + high_m))
        assert list(hopeless(mission(start=box), 20 * rows)) == [], rows


@pytest.mark.parametrize(
    ("told", "given"),
    [
        ("5,000 m/s is 18,000 km/h", {"speed_m_s": 5000}),
        ("is it meant in metres", {"sensor": DiscSensor(radius_m=3000)}),
        ("watches as if it stood", {"speed_m_s": 1e-3}),
        ("watches as if it stood", {"period_s": 0.1}),
        ("can only stand", {"turn_radius_m": 51.0}),
        ("at least 4", {"robots": (Robot(name="a", speed_m_s=5, sensor=DiscSensor(radius_m=15)),)}),
        ("32,400 km/h", {"robots": (Robot(name="a", speed_m_s=9000, sensor=DiscSensor(radius_m=15)),)}),
    ],
)
def test_what_is_hardly_meant_is_a_warning(told: str, given: dict[str, Any]) -> None:
    assert any(told in warning["message"] for warning in doubtful(mission(**given), 4))


def test_a_usual_mission_has_no_warnings() -> None:
    for usual in (mission(), mission(turn_radius_m=49.0), mission(start=None, speed_m_s=0.5)):
        assert list(doubtful(usual, 1)) == []
        assert list(hopeless(usual, 4)) == []

"""Robots whose turns are wider than lanes lie apart: plans that the check passes, round a house as well."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shapely import MultiPolygon, Polygon, box
from tests.planners.patrol.searching import search_on

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.methods.sweeping.wide_turns import turns_widely
from rota.planners.patrol.planner_settings import PatrolSettings

CUT = Polygon([(4, 0), (156, 0), (160, 4), (160, 116), (156, 120), (4, 120), (0, 116), (0, 4)])
FIELD = Mission(
    name="field", area=MultiPolygon([CUT]), period_s=200.0, planning=PatrolSettings(effort="quick"),
    fleet=Fleet(speed_m_s=18.0, sensor=DiscSensor(radius_m=5.0), turn_radius_m=15.0),
)  # fmt: skip
HOUSE = Obstacle(shape=MultiPolygon([box(70, 50, 78, 56)]))
GATE = Zone(name="gate", shape=MultiPolygon([box(20, 20, 50, 50)]), period_s=60.0)


@pytest.mark.parametrize(
    ("mission", "ideal"),  # robots on lanes that lose nothing: area / (swath * speed * period) of each region
    [
        (FIELD, 19_168 / (10 * 18 * 200)),
        (replace(FIELD, obstacles=(HOUSE,)), 19_120 / (10 * 18 * 200)),
        (replace(FIELD, zones=(GATE,)), 18_268 / (10 * 18 * 200) + 900 / (10 * 18 * 60)),
        (replace(FIELD, period_s=40.0), 19_168 / (10 * 18 * 40)),
    ],
)
def test_lanes_and_rings_see_all(mission: Mission, ideal: float) -> None:
    context = search_on(mission)
    assert turns_widely(context.problem)
    lanes = sweep(context, EARLY)
    assert lanes is not None
    assert lanes.met
    assert lanes.robots <= 1 + len(mission.zones) + 2 * ideal  # turns take as long as lanes, and robots are whole


def test_robots_with_narrow_turns_have_lanes_as_ever() -> None:
    narrow = replace(FIELD.fleet, turn_radius_m=4.9)
    assert not turns_widely(search_on(replace(FIELD, fleet=narrow)).problem)

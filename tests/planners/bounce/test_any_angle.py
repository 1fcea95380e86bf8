"""``bouncing_angles_deg: any``: which angles work is told, and the best is taken into the plan's mission."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from tests.planners.bounce.test_bounce_plans import ROOM, ZONES, mission_on, visit

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.files.mission_json import mission_to_json
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.make_plan import make_plan, search_plan

LANE = """
rota: 1
name: lane
area: {text: "......", cell_m: 1}
zones: [{name: end, period_s: 60, demand: visit, ring: [[5, 0], [6, 0], [6, 1], [5, 1]]}]
fleet: {robots: 1, speed_m_s: 0.5, sensor: {shape: disc, radius_m: 0.5}, body_radius_m: 0.3}
planner: bounce
bounce: {headings: 4, bouncing_angles_deg: any}
"""


def test_a_mission_file_may_say_any(tmp_path: Path) -> None:
    (tmp_path / "lane.yaml").write_text(LANE)
    mission = read_mission(tmp_path / "lane.yaml").mission
    assert BounceSettings.of(mission).bouncing_angles_deg == ()
    assert mission_to_json(mission)["bounce"]["bouncing_angles_deg"] == "any"
    found = search_plan(mission)
    (angle,) = BounceSettings.of(found.plan.mission).bouncing_angles_deg
    assert angle in (90, 180, 270)
    assert check_plan(found.plan).verdict == "met"


def test_angles_that_fail_are_told_with_what_they_lack() -> None:
    # 45 degrees: every robot ends up along the border and never comes to the middle
    middle = (visit("middle", 400, 4, 6, 5, 7),)
    found = search_plan(mission_on(ROOM, 1, middle, bouncing_angles_deg="any"))
    assert "45 (zones middle: no limit cycle of any robot enters them" in found.facts[0]
    assert found.facts[0].startswith("Robots turn by ")
    (angle,) = BounceSettings.of(found.plan.mission).bouncing_angles_deg
    alone = replace(found.plan.mission, planning=replace(BounceSettings.of(found.plan.mission)))
    assert make_plan(alone) == found.plan
    assert f"{angle:g}" in found.facts[0].split("these work: ")[1].split(".")[0]


def test_where_no_angle_works_each_is_named() -> None:
    soon = tuple(replace(zone, period_s=1.0) for zone in ZONES)
    with pytest.raises(NoPlanFound, match=r"no bouncing angle works, of 7 degrees tried: 45: .*; 90: .*; 315: "):
        make_plan(mission_on(ROOM, 1, soon, bouncing_angles_deg="any"))

"""What the page has no fields for stays in a mission that it opens and writes: how much ground matters."""

from __future__ import annotations

from typing import Any

from rota.files.mission_changes import changes
from rota.files.mission_text import mission_text
from rota.files.yaml_text import parse_text
from rota.web.tasks.inlined import inline
from rota.web.tasks.sources import source_of

MISSION = b"""\
rota: 1
name: m
area: [[0, 0], [40, 0], [40, 20], [0, 20]]
importance: {map: maps/hot.png, black: 0, white: 3}
zones:
  - {name: gate, importance: 5, ring: [[0, 0], [9, 0], [9, 9]]}
fleet: {robots: 2, speed_m_s: 1, sensor: {shape: disc, radius_m: 5}}
planner: swarm
"""


def test_importance_and_its_map_are_opened_and_written() -> None:
    context: Any = None  # nothing is looked up
    opened = inline(context, source_of({"m.yaml": MISSION, "hot.png": b"picture"}))
    assert opened.warnings == []
    assert opened.files == {"hot.png": b"picture"}
    again = parse_text(mission_text(opened.document), "m.yaml", "a mission").value
    assert again["importance"] == {"map": "hot.png", "black": 0, "white": 3}
    assert again["zones"][0]["importance"] == 5


def test_a_plan_is_old_when_the_ground_matters_otherwise() -> None:
    before: Any = parse_text(MISSION.decode(), "m.yaml", "a mission").value
    after = {**before, "importance": 0.5, "zones": [{**before["zones"][0], "importance": 6}]}
    assert changes(before, after) == ["importance of the ground changed", "zone gate importance 5 → 6"]

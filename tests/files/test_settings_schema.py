"""Settings of planners in mission and plan files: their JSON Schemas say what they said before, and what is read."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from rota.errors import MissionError
from rota.files.mission_file import mission_schema, read_mission
from rota.files.plan_schema import plan_schema
from rota.model.planner_registry import PLANNERS
from rota.model.planner_settings import settings_of
from rota.planners.patrol.method_table import METHODS
from rota.planning.planner import planner_named

# the blocks as they were written out by hand, with references resolved
BEFORE = json.loads(Path(__file__).with_name("settings_of_version_1.json").read_text())
# what used to be refused by the reader only
ADDED = {"clock_drift": {"minimum", "maximum"}, "clock_signal_s": {"exclusiveMinimum"}, "most_steps": {"maximum"}}
ADDED |= {"turning_error_deg": {"minimum", "maximum"}, "altitudes_m": {"exclusiveMinimum"}}


def block_of(file: str, planner: str) -> dict[str, Any]:
    properties = mission_schema()["properties"] if file == "mission" else plan_fields()["properties"]
    return next(part for part in properties[planner]["anyOf"] if part["type"] == "object")


def plan_fields() -> dict[str, Any]:
    fields: dict[str, Any] = plan_schema()["properties"]["mission"]
    return fields


def differences(now: Any, before: Any, added: set[str], where: str = "") -> list[str]:
    """Where a schema differs from what it was, in whatever order its keys stand; some keys may be new."""
    if isinstance(before, dict):
        keys = {key for key in now if key not in ("description", "title")}
        found = [f"{where}.{key}" for key in (keys - set(before) - added) | (set(before) - keys)]
        for key in set(before) & keys:
            found += differences(now[key], before[key], ADDED.get(key, added), f"{where}.{key}")
        return found
    if isinstance(before, list) and all(isinstance(value, str) for value in before):
        return [] if sorted(now) == sorted(before) else [where]
    if isinstance(before, list):
        pairs = zip(now, before, strict=False)
        found = [] if len(now) == len(before) else [where]
        return found + [d for mine, other in pairs for d in differences(mine, other, added, where)]
    return [] if now == before else [where]


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("file", ["mission", "plan"])
def test_the_schema_of_settings_is_what_it_was(file: str, planner: str) -> None:
    before = deepcopy(BEFORE[file][planner])
    now = block_of(file, planner)
    if planner == "patrol":  # methods and settings may be added
        assert now["properties"].pop("prefer")["default"] == "shortest"
        stages = now["properties"]["sun2019"]
        stages = stages["anyOf"][0] if file == "mission" else stages
        defaults = [stages["properties"].pop(name)["default"] for name in ("sensors", "frame", "segments")]
        assert [default is None for default in defaults] == [file == "mission"] * 3
        if file == "plan":
            assert stages["default"] | BEFORE["plan"]["patrol"]["properties"]["sun2019"]["default"] == stages["default"]
            stages["default"] = BEFORE["plan"]["patrol"]["properties"]["sun2019"]["default"]
        named = before["properties"]["method"]["enum"]
        assert set(named) <= set(METHODS)
        named[:] = METHODS
    if planner == "swarm":  # further bands may follow
        altitudes = before["properties"]["altitudes_m"]["anyOf"][0]
        assert altitudes.pop("maxItems") == altitudes["minItems"] == 2
        altitudes["minItems"] = 1
    if planner == "bounce":  # all angles may be tried, and teams chosen for what inexact turns leave
        before["properties"]["purpose"]["enum"].append("robust")
        angles = now["properties"]["bouncing_angles_deg"]
        word, listed = angles.pop("anyOf")
        assert word == {"const": "any"}
        angles |= listed
    assert differences(now, before, set()) == []


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_fault_has_one_wording_in_files_and_in_python(planner: str, tmp_path: Path) -> None:
    block = planner_named(planner).settings
    path = tmp_path / "mission.json"
    wrong = {"number": -1e300, "whole": -5, "truth": "maybe", "option": "crawl", "pair": [1], "list": []}
    tried = 0
    for item in settings_of(block):
        if item.kind == "block" or (item.kind in ("number", "whole") and not item.bounds(in_mission_file=False)):
            continue
        value = wrong[item.kind]
        document = {
            "rota": 1, "name": "m", "area": [[0, 0], [9, 0], [9, 9]], "planner": planner, planner: {item.name: value},
            "fleet": {"speed_m_s": 1, "sensor": {"shape": "disc", "radius_m": 3}},
        }  # fmt: skip
        path.write_text(json.dumps(document))
        with pytest.raises(MissionError) as read:
            read_mission(path)
        with pytest.raises(MissionError) as made:
            block(**{item.name: value})
        told = [fault.split(": ", 1)[1] for fault in read.value.faults if f"{planner}.{item.name}" in fault]
        if item.written is None:
            assert told[0] == str(made.value)
        assert told[0].split(";")[0] == str(made.value).split(";")[0]
        tried += 1
    assert tried >= 4

"""Batteries by their data sheets, in watts and by presets, beside closed forms."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml

from rota import NoPlanFound, Plan, check_plan, make_plan
from rota.check.charging import docked_rows
from rota.files.mission_file import mission_schema, read_mission
from rota.model.battery_limits import BatteryLimits
from rota.model.fields import fields_of
from rota.model.mission import Mission
from rota.vehicles.battery_data import BatteryData

SCHEMA = jsonschema.Draft202012Validator(mission_schema())  # whether it is a schema is asked in another test


def read(tmp_path: Path, battery: dict[str, Any], **fleet: Any) -> Mission:
    document = {
        "rota": 1, "name": "post", "area": [[0, 0], [60, 0], [60, 40], [0, 40]],
        "zones": [{"name": "gate", "period_s": 20, "ring": [[50, 30], [60, 30], [60, 40], [50, 40]]}],
        "chargers": [{"name": "pad", "at": [5, 5], "places": 4}],
        "fleet": {"speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 15}, "battery": battery, **fleet},
        "patrol": {"effort": "quick"},
    }  # fmt: skip
    path = tmp_path / "mission.yaml"
    path.write_text(yaml.safe_dump(document))
    SCHEMA.validate(document)
    return read_mission(path).mission


SHEET = {"capacity_wh": 100, "moving_w": 200, "standing_w": 250, "charging_w": 50, "takeoff_wh": 5}


def test_watts_come_to_seconds(tmp_path: Path) -> None:
    assert set(SHEET) | {"preset", "reserve_percent"} == {item.name for item in fields_of(BatteryData)}
    # half an hour at 200 W, of which 5 Wh are a twentieth
    expected = BatteryLimits(endurance_s=1800, standing_endurance_s=1440, recharge_s=7200, takeoff_s=90, reserve_s=450)
    assert read(tmp_path, {**SHEET, "reserve_percent": 25}).fleet.battery == expected
    seconds = read(tmp_path, {"capacity_wh": 100, "moving_w": 200}, recharge_s=60, takeoff_s=5, reserve_s=40)
    assert seconds.fleet.battery == BatteryLimits(endurance_s=1800, recharge_s=60, takeoff_s=5, reserve_s=40)


def test_a_preset_has_what_its_maker_publishes(tmp_path: Path) -> None:
    # Bitcraze: 7 minutes of flight, 40 of charging, 250 mAh at 3.7 V; a tenth of that is 42 s
    small = read(tmp_path, {"preset": "crazyflie-2.1", "takeoff_wh": 0.0925, "reserve_percent": 10})
    assert small.fleet.battery == BatteryLimits(endurance_s=420, recharge_s=2400, takeoff_s=42, reserve_s=42)
    # DJI: 77 Wh, 45 minutes of flight, 38 of hovering; charged at 77 W in an hour
    other = read(tmp_path, {"preset": "dji-mavic-3e", "charging_w": 77}).fleet.battery
    assert other == BatteryLimits(endurance_s=2700, standing_endurance_s=2280, recharge_s=3600)
    # DeltaQuad: 1 h 50 min of flight and 6 h of charging; 23 Ah of 4 cells of 3.7 V, a tenth of which is 660 s
    wing = read(tmp_path, {"preset": "deltaquad-pro-v2", "takeoff_wh": 34.04}).fleet.battery
    assert wing.takeoff_s == pytest.approx(660)
    seconds = BatteryLimits(endurance_s=6600, standing_endurance_s=0, recharge_s=21600)
    assert dataclasses.replace(wing, takeoff_s=0) == seconds
    # MEDION: an hour at the highest power, charged in five; 2.4 Ah of 14.4 V
    cleaner = read(tmp_path, {"preset": "medion-md-19601", "takeoff_wh": 3.456}).fleet.battery
    assert cleaner.takeoff_s == pytest.approx(360)
    assert dataclasses.replace(cleaner, takeoff_s=0) == BatteryLimits(endurance_s=3600, recharge_s=18000)
    assert read(tmp_path, {"preset": "crazyflie-2.1"}, recharge_s=900).fleet.battery.recharge_s == 900


def test_one_with_a_battery_has_nothing_of_its_fleets(tmp_path: Path) -> None:
    robots = [{"name": "a"}, {"name": "b", "battery": {"capacity_wh": 100, "moving_w": 200}, "recharge_s": 60}]
    fleet = read(tmp_path, {"preset": "crazyflie-2.1", "reserve_percent": 10}, robots=robots).fleet
    assert fleet.robot("a").battery == fleet.battery == BatteryLimits(endurance_s=420, recharge_s=2400, reserve_s=42)
    assert fleet.robot("b").battery == BatteryLimits(endurance_s=1800, recharge_s=60)
    kinds = [{"name": "k", "cost": 1, "battery": SHEET}]
    (kind,) = read(tmp_path, {"preset": "crazyflie-2.1"}, kinds=kinds).fleet.kinds
    assert (kind.battery.endurance_s, kind.battery.takeoff_s) == (1800, 90)


def test_who_hovers_is_relieved_before_its_battery_is_low(tmp_path: Path) -> None:
    mission = read(tmp_path, {"preset": "dji-mavic-3e", "charging_w": 65, "takeoff_wh": 1.5, "reserve_percent": 20})
    plan = make_plan(mission)
    # it has 2107 s of flight, hovers at 45 / 38 of that and charges in 71 minutes: a third robot does
    assert len(plan) == 3
    assert least_m_s(plan) == 0
    assert check_plan(plan).verdict == "met"


def least_m_s(plan: Plan) -> float:
    """The least speed of its robots away from chargers."""
    found = []
    for one in plan:
        speeds_m_s = np.hypot(*np.diff(one.positions_m[:, :2], axis=0).T) / np.diff(one.times_s)
        found.append(float(speeds_m_s[~docked_rows(one.times_s, one.charges)].min()))
    return min(found)


@pytest.mark.parametrize("standing_endurance_s", [0, 900])
def test_a_wing_and_a_copter_come_by_a_place_without_a_stay(tmp_path: Path, standing_endurance_s: float) -> None:
    battery = {"capacity_wh": 100, "moving_w": 200, "charging_w": 100}
    plan = make_plan(read(tmp_path, battery, standing_endurance_s=standing_endurance_s))
    # the zone is seen from one place, at which both turn back at once
    assert least_m_s(plan) == pytest.approx(5, rel=1e-5)
    assert check_plan(plan).verdict == "met"


def test_a_wing_circles_at_its_speed_where_others_take_their_time(tmp_path: Path) -> None:
    battery = {"capacity_wh": 5, "moving_w": 180, "charging_w": 180}
    wing, other = (
        make_plan(read(tmp_path, battery, standing_endurance_s=standing_s, turn_radius_m=2)) for standing_s in (0, 90)
    )
    # round the circle in 2.5 s, which may take ten times as long
    assert least_m_s(wing) >= 0.85 * 5
    assert least_m_s(other) < 1
    assert len(wing) == len(other)
    assert check_plan(wing).verdict == "met"


def test_where_a_wing_would_have_to_stand_planning_says_so(tmp_path: Path) -> None:
    battery = {"capacity_wh": 100, "moving_w": 200, "charging_w": 10}
    with pytest.raises(NoPlanFound, match=r"robot-1 would stand at \(55, 35\), where its standing_endurance_s is 0"):
        make_plan(read(tmp_path, battery, standing_endurance_s=0))

"""Batteries told in Python as data sheets do, beside closed forms and beside files that say the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.files.test_batteries_of_missions import SHEET, read

from rota import BatteryData, BatteryLimits, DiscSensor, Fleet, MissionError

SHEETS: list[tuple[dict[str, Any], dict[str, float]]] = [
    (SHEET | {"reserve_percent": 25}, {}),
    ({"capacity_wh": 100, "moving_w": 200}, {"recharge_s": 60, "takeoff_s": 5, "reserve_s": 40}),
    ({"capacity_wh": 100, "moving_w": 200, "charging_w": 50}, {"standing_endurance_s": 0}),
    ({"preset": "dji-mavic-3e", "charging_w": 77, "takeoff_wh": 1.5, "reserve_percent": 20}, {}),
    ({"preset": "crazyflie-2.1"}, {"recharge_s": 900}),
]


def test_watts_come_to_seconds() -> None:
    # half an hour at 200 W, of which 5 Wh are a twentieth; 24 minutes at 250 W; two hours at 50 W
    expected = BatteryLimits(endurance_s=1800, standing_endurance_s=1440, recharge_s=7200, takeoff_s=90, reserve_s=450)
    battery = BatteryData(**SHEET, reserve_percent=25).limits()
    assert battery == expected
    assert Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=9), battery=battery).equal_robot("a").battery == expected


@pytest.mark.parametrize(("sheet", "seconds"), SHEETS)
def test_python_and_files_say_the_same(tmp_path: Path, sheet: dict[str, Any], seconds: dict[str, float]) -> None:
    assert BatteryData(**sheet).limits(**seconds) == read(tmp_path, sheet, **seconds).fleet.battery


@pytest.mark.parametrize(
    ("sheet", "seconds", "message"),
    [
        ({"capacity_wh": 77}, {}, "battery.moving_w: is missing; give it, or a preset: dji-mavic-3e, "),
        ({"capacity_wh": 77, "moving_w": 0}, {}, "battery.moving_w: 0 is not allowed; it must be greater than 0"),
        ({"capacity_wh": 77, "moving_w": "103"}, {}, 'battery.moving_w: "103" is not allowed; a number is needed'),
        ({"preset": "mavic"}, {}, "battery.preset: 'mavic' is not allowed; dji-mavic-3e, .* or turtlebot4 is needed"),
        ({"preset": "turtlebot4", "moving_w": 9}, {}, "battery.moving_w: given beside preset, which says it: remove"),
        (
            {"preset": "turtlebot4", "reserve_percent": 100},
            {},
            "battery.reserve_percent: 100 is not allowed; it must be less than 100",
        ),
        ({"preset": "turtlebot4"}, {"endurance_s": 9}, "endurance_s: given beside battery.preset, of which it follows"),
        (
            {"capacity_wh": 10, "moving_w": 100, "takeoff_wh": 9, "reserve_percent": 20},
            {},
            "battery.takeoff_wh: its takeoff_s of 324 is not allowed; it must be less than what .* reserve_s, 288",
        ),
        ({"capacity_wh": 10, "moving_w": 100}, {"reserve_s": 360}, "reserve_s: 360 is not allowed; it must be less"),
        ({"capacity_wh": 10, "moving_w": 100}, {"recharge_s": -1}, "recharge_s: -1 is not allowed; it must be greater"),
    ],
)
def test_what_is_wrong_is_told_by_its_field(sheet: dict[str, Any], seconds: dict[str, float], message: str) -> None:
    with pytest.raises(MissionError, match=f"^{message}"):
        BatteryData(**sheet).limits(**seconds)

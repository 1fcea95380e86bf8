"""What a fleet is by its vehicles, and by what the mission gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml

from rota.errors import MissionError
from rota.files.mission_file import mission_schema, read_mission
from rota.model.fleet import DiscSensor, Fleet
from rota.model.motion_limits import AT_ONCE, MotionLimits
from rota.vehicles.presets import VEHICLES

SCHEMA = jsonschema.Draft202012Validator(mission_schema())  # whether it is a schema is asked in another test


def read(tmp_path: Path, **fleet: Any) -> Fleet:
    return told(tmp_path, **fleet)[0]


def told(tmp_path: Path, **fleet: Any) -> tuple[Fleet, tuple[str, ...]]:
    document = {
        "rota": 1, "name": "yard", "area": [[0, 0], [60, 0], [60, 40], [0, 40]], "period_s": 60,
        "fleet": {"sensor": {"shape": "disc", "radius_m": 5}, **fleet},
        **({"chargers": [{"name": "pad", "at": [30, 20]}]} if "endurance_s" in fleet else {}),
    }  # fmt: skip
    path = tmp_path / "mission.yaml"
    path.write_text(yaml.safe_dump(document))
    SCHEMA.validate(document)
    done = read_mission(path)
    return done.mission.fleet, done.warnings


def test_an_arducopter_has_what_its_firmware_has_by_default(tmp_path: Path) -> None:
    # AC_WPNav.cpp and SCurve of ArduCopter 4.6
    fleet = read(tmp_path, vehicle="arducopter")
    assert fleet.speed_m_s == 10
    assert fleet.motion == MotionLimits(
        vehicle="arducopter",
        acceleration_m_s2=2.5,
        corner_acceleration_m_s2=5,
        corner_m=2,
        climb_m_s=2.5,
        descend_m_s=1.5,
        top_airspeed_m_s=10,
    )
    assert fleet.equal_robot("a").motion == fleet.motion


def test_what_is_given_wins_and_null_is_given(tmp_path: Path) -> None:
    fleet = read(tmp_path, vehicle="arducopter", speed_m_s=4, corner_m=0.5, jerk_m_s3=None, wind_m_s=3)
    assert fleet.speed_m_s == 4
    motion = fleet.motion
    assert (motion.corner_m, motion.jerk_m_s3, motion.wind_m_s, motion.acceleration_m_s2) == (0.5, None, 3, 2.5)


def test_a_speed_that_is_not_given_is_what_the_wind_leaves(tmp_path: Path) -> None:
    assert read(tmp_path, vehicle="arducopter", wind_m_s=4).speed_m_s == 6


def test_without_an_acceleration_nothing_that_needs_one_is_preset(tmp_path: Path) -> None:
    motion = read(tmp_path, vehicle="arducopter", acceleration_m_s2=None).motion
    assert (motion.jerk_m_s3, motion.corner_m, motion.corner_acceleration_m_s2) == (None, 0, None)
    assert motion.vehicle == "arducopter"


def test_no_vehicle_and_none_are_as_ever(tmp_path: Path) -> None:
    assert read(tmp_path, speed_m_s=3).motion == AT_ONCE
    assert read(tmp_path, speed_m_s=3, vehicle="none").motion == AT_ONCE
    assert read(tmp_path, speed_m_s=3, vehicle=None, corner_m=None, wind_m_s=None).motion == AT_ONCE


def test_robots_have_what_the_fleet_has_unless_they_say_otherwise(tmp_path: Path) -> None:
    robots = [
        {"name": "like"},
        {"name": "soft", "acceleration_m_s2": 1, "speed_m_s": 3},
        {"name": "other", "vehicle": "px4"},
        {"name": "free", "vehicle": "none"},
    ]
    fleet = read(tmp_path, vehicle="arducopter", wind_m_s=2, robots=robots)
    like, soft, other, free = fleet.robots or ()
    assert (like.motion, like.speed_m_s) == (fleet.motion, 8)
    assert (soft.motion.acceleration_m_s2, soft.motion.jerk_m_s3, soft.speed_m_s) == (1, None, 3)
    assert soft.motion.vehicle == "arducopter"
    px4 = MotionLimits(
        vehicle="px4", acceleration_m_s2=3, jerk_m_s3=4, corner_m=2, climb_m_s=3, descend_m_s=1.5, wind_m_s=2
    )
    assert (other.motion, other.speed_m_s) == (px4, 5)
    assert (free.motion, free.speed_m_s) == (MotionLimits(wind_m_s=2), 8)


def test_copters_that_charge_land_and_climb_as_their_firmware_does(tmp_path: Path) -> None:
    battery = {"endurance_s": 1200, "recharge_s": 2400}
    copter = read(tmp_path, vehicle="arducopter-targets", altitude_m=20, **battery).battery
    # 10 m at 1.5 m/s and 10 m at 0.5 m/s down; 5 s to take off and 20 m at 2.5 m/s up
    assert (copter.landing_s, copter.climbing_s) == (pytest.approx(10 / 1.5 + 20), pytest.approx(13))
    assert copter.departure_s == pytest.approx(10 / 1.5 + 33)  # as hovering
    assert read(tmp_path, vehicle="arducopter-targets", altitude_m=5, **battery).battery.landing_s == 10
    px4 = read(tmp_path, vehicle="px4", altitude_m=20, **battery).battery
    # PX4 slows down evenly with its height from 10 m on to 5 m
    heights_m = np.arange(0, 20, 1e-3) + 5e-4
    down_m_s = np.interp(heights_m, [5, 10], [0.7, 1.5])
    assert px4.landing_s == pytest.approx((1e-3 / down_m_s).sum(), rel=1e-5)
    assert px4.climbing_s == pytest.approx(8 + 10 / 1.5 + 10 / 3)
    own = read(tmp_path, vehicle="px4", landing_s=40, climbing_s=0, **battery).battery
    assert (own.landing_s, own.climbing_s, own.departure_s) == (40, 0, 40)
    robots = [{"name": "like"}, {"name": "floor", "vehicle": "agv"}, {"name": "own", "climbing_s": 7}]
    like, floor, own_robot = read(tmp_path, vehicle="arducopter-targets", robots=robots, **battery).robots or ()
    assert (like.battery.climbing_s, floor.battery.grounding_s, own_robot.battery.climbing_s) == (17, 0, 7)
    assert read(tmp_path, vehicle="arducopter-targets").battery.grounding_s == 0  # it never lands
    assert read(tmp_path, speed_m_s=3, **battery).battery.grounding_s == 0


def test_a_robot_on_the_floor_turns_as_its_vehicle_does(tmp_path: Path) -> None:
    fleet = read(tmp_path, vehicle="turtlebot4")
    assert (fleet.speed_m_s, fleet.turn_rate_rad_s, fleet.motion.acceleration_m_s2) == (0.26, 1.0, 0.9)
    assert read(tmp_path, vehicle="turtlebot4", turn_rate_rad_s=None).turn_rate_rad_s is None


def test_a_plane_turns_on_arcs_that_grow_with_its_speed(tmp_path: Path) -> None:
    # a level turn banked by 45 degrees: v^2 / g
    assert read(tmp_path, vehicle="arduplane").turn_radius_m == pytest.approx(12**2 / 9.81, rel=1e-3)
    fast = read(tmp_path, vehicle="arduplane", speed_m_s=18, wind_m_s=4)
    assert fast.turn_radius_m == pytest.approx(18**2 / 9.81, rel=1e-3)
    assert fast.motion == MotionLimits(vehicle="arduplane", climb_m_s=5, descend_m_s=5, top_airspeed_m_s=22, wind_m_s=4)
    assert read(tmp_path, vehicle="arduplane", turn_radius_m=50).turn_radius_m == 50
    assert read(tmp_path, vehicle="arduplane", turn_rate_rad_s=1).turn_radius_m == 0
    slow = read(tmp_path, vehicle="arduplane", robots=[{"name": "a"}, {"name": "b", "speed_m_s": 10}]).robots or ()
    assert [robot.turn_radius_m for robot in slow] == pytest.approx([12**2 / 9.81, 10**2 / 9.81], rel=1e-3)


def test_a_vehicle_whose_acceleration_no_source_tells_warns(tmp_path: Path) -> None:
    fleet, warnings = told(tmp_path, vehicle="dji")
    assert (fleet.speed_m_s, fleet.motion) == (15, MotionLimits(vehicle="dji"))
    assert len(warnings) == 1
    assert "fleet.vehicle: no source tells its acceleration" in warnings[0]
    fleet, warnings = told(tmp_path, vehicle="dji", acceleration_m_s2=3)
    assert (fleet.motion.corner_m, warnings) == (0.2, ())


@pytest.mark.parametrize("name", [name for name, vehicle in VEHICLES.items() if vehicle.speed_m_s is not None])
def test_each_vehicle_makes_a_fleet_by_itself(tmp_path: Path, name: str) -> None:
    vehicle, fleet = VEHICLES[name], read(tmp_path, vehicle=name)
    assert vehicle.speed_m_s is not None
    assert fleet.speed_m_s == vehicle.speed_m_s.value
    assert fleet.motion.vehicle == name


def test_the_mission_itself_refuses_what_the_file_refuses() -> None:
    with pytest.raises(MissionError, match=r"speed_m_s: 9 is not allowed; must be at most 6: top_airspeed_m_s, 8 less"):
        fleet_with(speed_m_s=9, motion=MotionLimits(top_airspeed_m_s=8, wind_m_s=2))
    soft = MotionLimits(acceleration_m_s2=1, corner_m=1)
    with pytest.raises(MissionError, match=r"corner_m: 1 is not allowed; must be 0 where turn_rate_rad_s is given"):
        fleet_with(speed_m_s=1, turn_rate_rad_s=1, motion=soft)
    with pytest.raises(MissionError, match=r"acceleration_m_s2: 1 is not allowed; does not go with turn_radius_m yet"):
        fleet_with(speed_m_s=1, turn_radius_m=1, motion=soft)


def fleet_with(**values: Any) -> Fleet:
    return Fleet(sensor=DiscSensor(radius_m=1), **values)


def test_wind_that_no_airspeed_withstands_is_told(tmp_path: Path) -> None:
    _, warnings = told(tmp_path, vehicle="px4", wind_m_s=3)
    assert len(warnings) == 1
    assert "fleet.wind_m_s: changes nothing without top_airspeed_m_s" in warnings[0]
    assert told(tmp_path, vehicle="px4", wind_m_s=3, top_airspeed_m_s=14)[1] == ()
    assert told(tmp_path, vehicle="arducopter", wind_m_s=3)[1] == ()

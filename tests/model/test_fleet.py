"""Fleets as Python makes them: robots by number, by list, and by what they do not say."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest

from rota.errors import MissionError
from rota.model.battery_limits import ENDLESS
from rota.model.fields import AS_FLEET
from rota.model.fleet import ABILITIES, DiscSensor, Fleet, Robot, SquareSensor, StartPoints
from rota.model.mission import GeoPoint, MovingObstacle, Zone
from rota.model.motion_limits import MotionLimits

WIDE = DiscSensor(radius_m=4)


def fleet_with(**values: Any) -> Fleet:
    return Fleet(**{"speed_m_s": 5, "sensor": WIDE, **values})


def test_robots_are_a_number_the_fewest_or_a_list() -> None:
    three = fleet_with(robots=3, body_radius_m=0.2)
    assert [robot.name for robot in three.robots or ()] == ["robot-1", "robot-2", "robot-3"]
    assert three.robots == tuple(three.equal_robot(f"robot-{k}") for k in (1, 2, 3))
    assert three == fleet_with(robots=[Robot(name=f"robot-{k}") for k in (1, 2, 3)], body_radius_m=0.2)
    assert fleet_with(robots="fewest") == fleet_with(robots=None) == fleet_with()
    assert (
        fleet_with(robots=(Robot(name=name) for name in "ab")).robots
        == fleet_with(robots=[Robot(name="a"), Robot(name="b")]).robots
    )


def test_a_robot_has_from_its_fleet_what_it_does_not_say() -> None:
    motion = MotionLimits(acceleration_m_s2=2, corner_m=0.5)
    robots = [
        Robot(name="like"),
        Robot(name="slow", speed_m_s=1),
        Robot(name="free", motion=MotionLimits(), start=(1, 2)),
    ]
    like, slow, free = fleet_with(robots=robots, body_radius_m=0.3, motion=motion).robots or ()
    assert like == Robot(
        name="like",
        speed_m_s=5,
        sensor=WIDE,
        body_radius_m=0.3,
        turn_rate_rad_s=None,
        turn_radius_m=0,
        motion=motion,
        battery=ENDLESS,
    )
    assert (slow.speed_m_s, slow.sensor, slow.motion) == (1, WIDE, motion)
    assert (free.motion, free.body_radius_m, free.start) == (MotionLimits(), 0.3, (1.0, 2.0))
    turning = fleet_with(turn_rate_rad_s=1, robots=[Robot(name="a"), Robot(name="b", turn_rate_rad_s=None)]).robots
    assert [robot.turn_rate_rad_s for robot in turning or ()] == [1, None]  # None is said: it turns in no time
    assert {name for name in ABILITIES if getattr(Robot(name="a"), name) is AS_FLEET} == set(ABILITIES)
    assert pickle.loads(pickle.dumps(Robot(name="a"))).speed_m_s is copy.deepcopy(Robot(name="a")).speed_m_s is AS_FLEET


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: fleet_with(sensor=4), r"^fleet\.sensor: 4 is not allowed; DiscSensor or SquareSensor is needed$"),
        (lambda: fleet_with(speed_m_s="5"), r'^fleet\.speed_m_s: "5" is not allowed; a number is needed; remove the q'),
        (lambda: fleet_with(speed_m_s=-1), r"^fleet\.speed_m_s: -1 is not allowed; it must be greater than 0$"),
        (lambda: fleet_with(motion=3), r"^fleet\.motion: 3 is not allowed; MotionLimits is needed$"),
        (lambda: fleet_with(start=(1, 2)), r"^fleet\.start: \[1, 2\] is not allowed; StartBox or StartPoints is n"),
        (lambda: fleet_with(entrances=[(1, 2, 3)]), r"^fleet\.entrances\[0\]: \[1, 2, 3\] is too long; 2 numbers are"),
        (lambda: fleet_with(robots="many"), r"^fleet\.robots: 'many' is not allowed; fewest, a whole number or a list"),
        (lambda: fleet_with(robots=0), r"^fleet\.robots: 0 is not allowed; must be at least 1$"),
        (lambda: fleet_with(robots=[]), r"^fleet\.robots: \[\] is not allowed; it must not be empty$"),
        (lambda: fleet_with(robots=["a"]), r'^fleet\.robots\[0\]: "a" is not allowed; Robot is needed$'),
        (lambda: Robot(name=3), r"^robot 3: name: 3 is not allowed; text is needed; put it in quotes$"),
        (lambda: Robot(name="a", speed_m_s=True), r"^robot a: speed_m_s: true is not allowed; a number is needed$"),
        (lambda: SquareSensor(side_m=None), r"^sensor\.side_m: null is not allowed; a number is needed$"),
        (lambda: StartPoints(points_m=[]), r"^fleet\.start\.points_m: \[\] is not allowed; it must not be empty$"),
        (lambda: GeoPoint(lat="54", lon=12), r'^lat: "54" is not allowed; a number is needed; remove the quotes$'),
        (lambda: Zone(name="z", shape=4, period_s=9), r"^zone z: 'int' is not allowed; must be a polygon"),
        (lambda: Zone(name="z", shape=4, period_s="9"), r'^zone z: period_s: "9" is not allowed; a number is needed'),
        (lambda: MovingObstacle(radius_m=1, times_s=[0, 1], positions_m=4), "^moving obstacle: positions_m: 4 is not"),
    ],
)  # fmt: skip
def test_a_wrong_type_is_refused_where_it_is_given_and_by_name(make: Any, told: str) -> None:
    with pytest.raises(MissionError, match=told):
        make()


def test_a_mission_error_is_a_value_error() -> None:
    with pytest.raises(ValueError, match="speed_m_s"):
        fleet_with(speed_m_s="fast")

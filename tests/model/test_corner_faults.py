"""Corners are cut by less than the ground is wide."""

from __future__ import annotations

import pytest
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot
from rota.model.motion_limits import MotionLimits
from rota.planners.swarm.planner_settings import SwarmSettings

SENSOR = DiscSensor(radius_m=3)


def mission(corner_m: float, *obstacles: MultiPolygon, **more: object) -> Mission:
    motion = MotionLimits(acceleration_m_s2=1, corner_m=corner_m)
    fleet = Fleet(speed_m_s=1, sensor=SENSOR, motion=motion, **more)  # type: ignore[arg-type]
    blocks = tuple(Obstacle(shape=shape) for shape in obstacles)
    return Mission(name="hall", area=MultiPolygon([box(0, 0, 30, 10)]), period_s=60, fleet=fleet, obstacles=blocks)


def test_the_widest_circle_of_the_free_space_bounds_them() -> None:
    assert mission(4.99).fleet.motion.corner_m == 4.99  # a hall 10 m wide has circles of 5 m
    with pytest.raises(MissionError, match=r"fleet.corner_m: 5.01 is not allowed; .* free space, 5 m"):
        mission(5.01)
    row = MultiPolygon([box(0, 4, 30, 10)])
    assert mission(1.99, row)
    with pytest.raises(MissionError, match=r"fleet.corner_m: 2.01 is not allowed; .* free space, 2 m"):
        mission(2.01, row)


def test_a_robot_of_its_own_is_named() -> None:
    wide = MotionLimits(acceleration_m_s2=1, corner_m=6)
    robots = (
        Robot(name="a", speed_m_s=1, sensor=SENSOR),
        Robot(name="b", speed_m_s=1, sensor=SENSOR, motion=wide),
    )
    with pytest.raises(MissionError, match=r"^fleet.robots\[1\].corner_m: 6 is not allowed"):
        mission(1, robots=robots)


def test_planners_that_do_not_heed_motion_refuse_it_by_name() -> None:
    fleet = Fleet(
        speed_m_s=1,
        sensor=SENSOR,
        robots=(Robot(name="a", speed_m_s=1, sensor=SENSOR, motion=MotionLimits(acceleration_m_s2=1)),),
    )
    with pytest.raises(
        MissionError, match=r"fleet.robots\[0\].acceleration_m_s2: the swarm planner does not heed it: remove it"
    ):
        Mission(name="hall", area=MultiPolygon([box(0, 0, 30, 10)]), fleet=fleet, planning=SwarmSettings())

"""Ground that cannot be reached, doors that are too narrow, and what is seen through no wall."""

from __future__ import annotations

import pytest
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sentences import covered_sentence, reach_sentences, unreached_ground


def halves(*walls: tuple[float, float, float, float]) -> Mission:
    """One robot 0.4 m wide in the left half of 40 m x 20 m, between walls."""
    sensor = DiscSensor(radius_m=30)
    robot = Robot(name="a", speed_m_s=1, sensor=sensor, body_radius_m=0.2, start=(5, 10))
    return Mission(
        name="halves",
        area=MultiPolygon([box(0, 0, 40, 20)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([box(*wall)])) for wall in walls),
        fleet=Fleet(speed_m_s=1, sensor=sensor, body_radius_m=0.2, robots=(robot,)),
        planning=SwarmSettings(most_steps=5),
    )


def test_a_wall_through_the_area_cuts_half_of_it_off() -> None:
    plan = run_mission(halves((19, 0, 21, 20)), seed=0).plan
    (part,) = unreached_ground(plan)
    assert part.area_m2 == pytest.approx(19 * 20)
    assert part.door_m is None
    assert list(reach_sentences(plan)) == ["380.0 m2, 50.0% of the ground, cannot be reached: there is no door to it."]
    assert " and see 50.0%, through no wall" in covered_sentence(plan)


def test_a_door_that_is_too_narrow_is_named() -> None:
    plan = run_mission(halves((19, 0, 21, 12), (19, 12.3, 21, 20)), seed=0).plan
    (part,) = unreached_ground(plan)
    assert part.door_m == pytest.approx(0.3, abs=1e-4)
    assert part.door_at_m == pytest.approx((20, 12.15), abs=1.05)
    (told,) = reach_sentences(plan)
    assert "is 0.3 m wide, and the smallest body 0.4 m." in told


def test_nothing_is_cut_off_by_a_door_that_the_body_fits_through() -> None:
    assert not unreached_ground(run_mission(halves((19, 0, 21, 12), (19, 12.4, 21, 20)), seed=0).plan)

"""Bodies and moving obstacles: closest approaches worked by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.check.accelerated import accelerated
from tests.seeds import seeds

from rota import SwarmSettings
from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, Robot
from rota.model.plan import Plan, Trajectory

SENSOR = DiscSensor(radius_m=5)


def found(trajectory: dict[str, Any], times_s: tuple[float, ...], positions_m: Any, radius_m: float = 1.0) -> list[Any]:
    robot = Robot(name="a", speed_m_s=4, sensor=SENSOR, body_radius_m=0.5)
    mission = Mission(
        name="crossing", area=MultiPolygon([box(-50, -50, 50, 50)]), planning=SwarmSettings(),
        fleet=Fleet(speed_m_s=2, sensor=SENSOR, robots=(robot,)),
        moving_obstacles=(MovingObstacle(radius_m=radius_m, times_s=times_s, positions_m=positions_m),),
    )  # fmt: skip
    return list(check_plan(Plan(mission=mission, trajectories=(Trajectory(robot="a", **trajectory),))).violations)


WALK = {"times_s": [0, 10], "positions_m": [[-10, 0], [10, 0]], "loop_start_s": 10}


def test_two_that_cross_at_right_angles_are_closest_between() -> None:
    # relative motion (-2, 2) from (10, -12): the line's distance from the origin is 2 / sqrt(2), at time 5.5
    (violation,) = found(WALK, (0, 10), ((0, -12), (0, 8)))
    assert (violation.kind, violation.who) == ("moving obstacle", "a, moving obstacle 1")
    assert (violation.value, violation.limit) == pytest.approx((math.sqrt(2), 1.5))
    assert violation.time_s == pytest.approx(5.5)
    assert violation.place_m == pytest.approx((1, 0))
    assert found(WALK, (0, 10), ((0, -12.5), (0, 7.5))) == []  # 2.5 / sqrt(2) > 1.5


def test_the_obstacle_stands_before_it_moves_and_after() -> None:
    assert found(WALK, (100, 110), ((0, 1.4), (0, 40)))[0].time_s == pytest.approx(5)
    assert found(WALK, (0, 1), ((0, 40), (0, 1.4)))[0].value == pytest.approx(1.4)


def test_a_robot_that_starts_from_rest_is_met_where_it_is() -> None:
    """At 0.5 m/s2 it comes along x in 8 s to 16 m; what comes down y = 4 - t at x = 4 is met at 4 s, in the middle."""
    starts = {"times_s": [0, 8], "positions_m": [[0, 0], [16, 0]], "accelerations_m_s2": [0.5], "loop_start_s": 8}
    (violation,) = found(starts, (0, 8), ((4, 4), (4, -4)))
    assert (violation.value, violation.time_s) == pytest.approx((0, 4), abs=1e-9)
    assert violation.place_m == pytest.approx((4, 0))
    even = {**starts, "accelerations_m_s2": None}
    assert "moving obstacle" in [each.kind for each in found(even, (0, 8), ((8, 4), (8, -4)))]
    assert found(starts, (0, 8), ((8, 4), (8, -4))) == []  # it is there 1.7 s later


@pytest.mark.parametrize("seed", seeds(10, at_once=4))
def test_random_loops_with_accelerations_beside_small_steps_of_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform(-6, 6, (4, 2))
    loop = Trajectory(robot="a", times_s=[0, 4, 9, 13, 20], positions_m=[*places, places[0]], loop_start_s=0)
    loop = accelerated(loop, rng)
    times, theirs = (0.0, 7.0, 15.0, 33.0), rng.uniform(-6, 6, (4, 2))
    kept = {name: getattr(loop, name) for name in ("times_s", "positions_m", "accelerations_m_s2", "loop_start_s")}
    (violation,) = [each for each in found(kept, times, theirs.tolist(), 20.0) if each.kind == "moving obstacle"]
    steps = np.arange(0, 60, 1e-3)
    there = np.stack([np.interp(steps, times, theirs[:, axis]) for axis in (0, 1)], axis=1)
    assert violation.value == pytest.approx(np.hypot(*(loop.at(steps) - there).T).min(), abs=5e-3)
    assert violation.value <= np.hypot(*(loop.at(steps) - there).T).min() + 1e-9
    assert violation.place_m == pytest.approx(loop.at(violation.time_s), abs=1e-6)


def test_a_robot_that_holds_is_run_down_later() -> None:
    (violation,) = found(WALK, (50, 60), ((10, 40), (10, 1.45)))
    assert (violation.value, violation.time_s) == pytest.approx((1.45, 60))
    assert found(WALK, (50, 60), ((10, 40), (10, 1.5))) == []


def test_a_loop_is_followed_until_the_obstacle_stands_and_round_once_more() -> None:
    square = {"times_s": [0, 5, 10, 15, 20], "positions_m": [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]}
    # it comes to a stand on the path at 97 s, when the robot is elsewhere
    (violation,) = found(square, (90, 97), ((40, 5), (10, 5)))
    assert violation.value == pytest.approx(0)
    assert violation.time_s == pytest.approx(107.5)


def test_a_loop_of_very_many_turns_is_held_against_the_whole_way() -> None:
    # 1e13 turns until the obstacle stands: nobody follows them
    quick = {"times_s": [0, 5e-4, 1e-3], "positions_m": [[0, 0], [1e-3, 0], [0, 0]]}
    (violation,) = found(quick, (1e9, 1e10), ((-9, 1.4), (9, 1.4)))
    assert (violation.value, violation.time_s) == (pytest.approx(1.4), None)
    assert found(quick, (1e9, 1e10), ((-9, 1.6), (9, 1.6))) == []

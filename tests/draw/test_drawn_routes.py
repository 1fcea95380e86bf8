"""Where robots are, which share a loop, and where arrowheads go."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import box

from rota.draw.routes import arrowheads, corners, routes_of
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory
from rota.routes.moments import corner_times_s

SQUARE = np.array([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)], float)


def plan_of(*trajectories: Trajectory) -> Plan:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    return Plan(
        mission=Mission(name="routes", area=box(-5, -5, 30, 30), period_s=60, fleet=fleet), trajectories=trajectories
    )


def on_square(name: str, shift_m: float, speed_m_s: float = 1.0, ring: np.ndarray = SQUARE) -> Trajectory:
    """A robot on the square, beginning ``shift_m`` along it, with its corners as timed points."""
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T))]
    marks = np.unique(np.r_[shift_m, shift_m + 40, along[along > shift_m], along[1:][along[1:] < shift_m] + 40])
    places = np.column_stack([np.interp(np.mod(marks, 40), along, ring[:, k]) for k in (0, 1)])
    places[-1] = places[0]
    return Trajectory(robot=name, times_s=(marks - shift_m) / speed_m_s, positions_m=places)


def test_positions_go_round_for_ever_after_the_way_to_the_loop():
    way = np.array([(-5, 0), *SQUARE], float)
    there = Trajectory(robot="a", times_s=[0, 5, 15, 25, 35, 45], positions_m=way, loop_start_s=5)
    # one lap of 40 s: at 5 + 40 k + 12 the robot is 2 m up the second side
    times = np.array([-1, 0, 2.5, 5, 17, 57, 5 + 4000 + 12])
    expected = [(-5, 0), (-5, 0), (-2.5, 0), (0, 0), (10, 2), (10, 2), (10, 2)]
    np.testing.assert_allclose(there.at(times), expected, atol=1e-9)


def test_a_robot_without_a_loop_stays_and_heights_are_dropped():
    still = Trajectory(robot="a", times_s=[0, 2], positions_m=[(0, 0, 30), (4, 0, 30)], loop_start_s=2)
    np.testing.assert_array_equal(still.at([1.0, 2, 99])[:, :2], [(2, 0), (4, 0), (4, 0)])


def test_corner_times_repeat_with_the_loop():
    way = np.array([(-5, 0), *SQUARE], float)
    there = Trajectory(robot="a", times_s=[0, 5, 15, 25, 35, 45], positions_m=way, loop_start_s=5)
    np.testing.assert_allclose(corner_times_s(there, 0, 50), [5, 15, 25, 35, 45])
    np.testing.assert_allclose(corner_times_s(there, 84, 106), [85, 95, 105])
    still = Trajectory(robot="a", times_s=[0, 2], positions_m=[(0, 0), (4, 0)], loop_start_s=2)
    np.testing.assert_allclose(corner_times_s(still, -1, 9), [0, 2])


def test_corners_drop_waits_and_points_on_a_leg_but_keep_a_turn_back():
    ring = [(0, 0), (4, 0), (10, 0), (10, 0), (10, 10), (0, 10), (0, 0)]
    np.testing.assert_array_equal(corners(np.array(ring, float)), [(0, 0), (10, 0), (10, 10), (0, 10)])
    there_and_back = [(3, 0), (10, 0), (3, 0), (0, 0), (3, 0)]
    np.testing.assert_array_equal(corners(np.array(there_and_back, float)), [(10, 0), (0, 0)])


def test_robots_on_one_loop_are_one_route_wherever_they_begin():
    routes = routes_of(plan_of(on_square("a", 0), on_square("b", 13.7), on_square("c", 25)))
    assert [route.robots for route in routes] == [(0, 1, 2)]
    assert routes[0].length_m == pytest.approx(40)
    assert routes[0].duration_s == pytest.approx(40)


def test_another_direction_place_or_time_is_another_route():
    slow = on_square("slow", 0, 0.5)
    back = on_square("back", 0, ring=SQUARE[::-1])
    moved = on_square("moved", 0, ring=SQUARE + 1e-3)
    still = [Trajectory(robot=name, times_s=[0], positions_m=[(1, 1)]) for name in ("x", "y")]
    routes = routes_of(plan_of(on_square("a", 0), slow, back, moved, *still))
    assert [route.robots for route in routes] == [(0,), (1,), (2,), (3,), (4,), (5,)]
    assert routes[4].length_m == 0


def test_arrowheads_are_even_point_ahead_and_keep_off_corners():
    places, directions = arrowheads(SQUARE, 8, 1.0)
    np.testing.assert_allclose(places[:4], [(2.5, 0), (7.5, 0), (10, 2.5), (10, 7.5)])
    np.testing.assert_allclose(directions[:4], [(1, 0), (1, 0), (0, 1), (0, 1)])
    places, _ = arrowheads(SQUARE, 40, 3.0)
    corner_distance = np.hypot(*(places[:, None] - SQUARE[None]).transpose(2, 0, 1)).min(axis=1)
    assert corner_distance.min() >= 3 - 1e-9
    assert [len(part) for part in arrowheads(np.zeros((3, 2)), 5, 1.0)] == [0, 0]

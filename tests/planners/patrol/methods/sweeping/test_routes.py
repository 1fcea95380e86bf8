"""Closed routes along lanes: short against brute force, all lanes driven, closed forms in a rectangle."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.methods.sweeping.routes import (
    SweepGround,
    angles,
    best_route,
    closed_route,
    driving_order,
    missed_m2,
    promising_angles,
    sweep_grounds,
    without_small_holes,
)
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.tour import tour_length_m


def problem_over(area: MultiPolygon, **more: object) -> Problem:
    fleet = Fleet(speed_m_s=2, sensor=more.pop("sensor", DiscSensor(radius_m=5)), **more.pop("fleet", {}))
    settings = PatrolSettings(effort="quick", method="sequential")
    return set_up_problem(Mission(name="m", area=area, period_s=100, fleet=fleet, planning=settings, **more))


@pytest.fixture(scope="module")
def rectangle() -> Problem:
    return problem_over(MultiPolygon([box(0, 0, 60, 39)]))


def only(problem: Problem) -> SweepGround:
    (ground,) = sweep_grounds(problem, ((0,),))
    return ground


def test_no_lanes_are_laid_across_a_long_corridor() -> None:
    corridor = problem_over(MultiPolygon([box(0, 0, 3000, 16)]))
    assert len(angles(corridor, corridor.mission.area)) > 1
    assert np.sin(promising_angles(corridor, corridor.mission.area)) == pytest.approx([0.0])
    hall = problem_over(MultiPolygon([box(0, 0, 50, 40)]))
    assert len(promising_angles(hall, hall.mission.area)) > 1


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_four_lanes_is_the_best_there_is(rectangle: Problem, seed: int) -> None:
    random = np.random.default_rng(seed)
    lanes = [random.uniform((0, 0), (60, 39), (2, 2)) for _ in range(4)]

    def travel_m(order: list[tuple[int, bool]]) -> float:
        way = np.vstack([lanes[k][::-1] if back else lanes[k] for k, back in order])
        return float(np.hypot(*np.diff(np.vstack([way, way[:1]]), axis=0).T).sum())

    found = driving_order(rectangle, lanes)
    assert sorted(k for k, _ in found) == [0, 1, 2, 3]
    best = min(
        travel_m([(0, False), *zip(rest, backs, strict=True)])
        for rest in itertools.permutations([1, 2, 3])
        for backs in itertools.product([False, True], repeat=3)
    )
    assert travel_m(found) == pytest.approx(best)


def test_a_lane_that_leads_back_beats_going_to_and_fro_and_back(rectangle: Problem) -> None:
    # to and fro: four lanes that stop 1.1 m before the border, three steps of 9.75 m, and as much back
    inset = (5**2 - (39 / 8) ** 2) ** 0.5
    to_and_fro_m = 4 * (60 - 2 * inset) + 6 * 39 / 4
    tour = best_route(rectangle, only(rectangle), only(rectangle).shape, [0.0, np.pi / 2])
    assert tour is not None
    assert 60 * 39 / 10 < tour_length_m(tour) < to_and_fro_m - 10
    assert missed_m2(rectangle, tour, only(rectangle).shape) < 0.05


def test_routes_go_round_obstacles_and_pass_by_stops() -> None:
    wall = Obstacle(shape=MultiPolygon([box(20, 0, 22, 30)]))
    zone = Zone(name="tap", shape=MultiPolygon([box(50, 2, 54, 6)]), period_s=100, demand="visit")
    problem = problem_over(MultiPolygon([box(0, 0, 60, 39)]), obstacles=(wall,), zones=(zone,))
    ground = only(problem)
    assert ground.stops_m == pytest.approx(np.array([[52.0, 4.0]]))
    tour = best_route(problem, ground, ground.shape, angles(problem, ground.shape))
    assert tour is not None
    ring = LineString(np.vstack([tour.vertices_m, tour.vertices_m[:1]]))
    assert ring.intersection(shapely.box(20.001, 0, 21.999, 29.999)).length == 0
    assert ring.distance(shapely.Point(52, 4)) < 1e-9


def test_lanes_in_other_parts_of_the_space_are_left_out() -> None:
    split = Obstacle(shape=MultiPolygon([box(28, -1, 32, 40)]))
    problem = problem_over(MultiPolygon([box(0, 0, 60, 39)]), obstacles=(split,))
    here = sweep_grounds(problem, ((0,),))
    assert [ground.component for ground in here] == [0, 1]
    assert [ground.shape.area for ground in here] == pytest.approx([28 * 39] * 2)
    lanes = [np.array([[5.0, 5.0], [20.0, 5.0]]), np.array([[40.0, 5.0], [55.0, 5.0]])]
    tours = [closed_route(problem, lanes, ground) for ground in here]
    assert all(tour is not None and tour_length_m(tour) == pytest.approx(30) for tour in tours)
    assert closed_route(problem, [], here[0]) is None


def test_directions_follow_the_longest_edges_and_square_sensors_also_their_diagonals(rectangle: Problem) -> None:
    slanted = MultiPolygon([shapely.affinity.rotate(box(0, 0, 40, 10), 20)])
    found = np.degrees(angles(rectangle, slanted))
    assert found == pytest.approx([0, 90, 20, 110])
    square = problem_over(MultiPolygon([box(0, 0, 60, 39)]), sensor=SquareSensor(side_m=10))
    assert np.degrees(angles(square, slanted)) == pytest.approx([0, 90, 45, 135, 20, 110])


def test_small_holes_are_filled_and_large_ones_are_not() -> None:
    shape = shapely.difference(box(0, 0, 60, 40), shapely.union_all([box(10, 10, 13, 12), box(30, 10, 36, 12)]))
    assert without_small_holes(MultiPolygon([shape]), 5.0).area == pytest.approx(60 * 40 - 12)
    assert without_small_holes(MultiPolygon([shape]), 1.0).area == pytest.approx(60 * 40 - 18)

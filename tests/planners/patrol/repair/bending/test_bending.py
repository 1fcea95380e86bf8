"""Tours moved by linear programs: shortest tours in closed form, budgets, borders, and who sees what by brute force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, box

from rota.geometry.kernels import free_segments
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.ground.samples import SamplePoints, points_of, prepare
from rota.planners.patrol.loop_settings import BendingSettings
from rota.planners.patrol.repair.bending.layout import Layout, lay_out_tours, sightings
from rota.planners.patrol.repair.bending.search import Bending, can_bend
from rota.planners.patrol.tours.tour import Tour, excesses, over_budget_share, tour_length_m

Floats = NDArray[np.float64]
REACH_M = 3.0
BENDING = BendingSettings()


def problem_of(*obstacles: shapely.Polygon, square: bool = False) -> Problem:
    sensor = SquareSensor(side_m=2 * REACH_M) if square else DiscSensor(radius_m=REACH_M)
    return set_up_problem(
        Mission(
            name="field",
            area=MultiPolygon([box(0, 0, 60, 60)]),
            obstacles=tuple(Obstacle(shape=MultiPolygon([shape])) for shape in obstacles),
            period_s=100,
            fleet=Fleet(speed_m_s=2, sensor=sensor),
        )
    )


@pytest.fixture(scope="module")
def field() -> Problem:
    return problem_of()


def tour(problem: Problem, corners_m: object, **fields: object) -> Tour:
    values: dict[str, object] = {"period_class": 0, "period_s": 100.0, "robots": 1, "robot": problem.robot}
    return Tour(vertices_m=np.array(corners_m, dtype=np.float64), **(values | fields))  # type: ignore[arg-type]


def samples_at(problem: Problem, places_m: object) -> tuple[SamplePoints, object]:
    points = points_of(np.array(places_m, dtype=np.float64), 1.0, 0, 0)
    _, samples, order = prepare(
        points, problem.walls, reach_m=problem.robot.sensor.reach_m, weight=np.ones(len(points)), wall_margin_m=1e-3
    )
    return points[order], samples


def shortest(problem: Problem, begun: Tour, places_m: object) -> Tour:
    far_too_long = replace(begun, period_s=1.0)
    search = Bending(problem, [far_too_long], samples_at(problem, places_m)[1], BENDING)  # type: ignore[arg-type]
    search.run(300, should_stop=lambda: False)
    return search.tours[0]


def sight_m(problem: Problem) -> float:
    """The range that plans count on."""
    return REACH_M - problem.range_margin_m


def test_there_and_back_between_two_points(field: Problem) -> None:
    # two discs of radius r, d apart: there and back between them is 2 (d - 2 r)
    found = shortest(field, tour(field, [[10, 30], [30, 31], [50, 30]]), [[10, 30], [50, 30]])
    assert tour_length_m(found) == pytest.approx(2 * (40 - 2 * sight_m(field)), rel=2e-3)


def test_round_the_corners_of_a_square(field: Problem) -> None:
    # by symmetry and reflection the shortest closed tour that touches discs on the corners of a square is a square
    # whose corners lie r further in along the diagonals
    corners = [[15, 15], [45, 15], [45, 45], [15, 45]]
    found = shortest(field, tour(field, corners), corners)
    assert tour_length_m(found) == pytest.approx(4 * (30 - math.sqrt(2) * sight_m(field)), rel=2e-3)


def test_round_the_corners_of_a_square_by_a_robot_that_turns_on_the_spot(field: Problem) -> None:
    # four right angles wherever the corners lie: the shortest way is the fastest, and no leg is bent
    turning = replace(field.robot, turn_rate_rad_s=0.2)
    corners = [[15, 15], [45, 15], [45, 45], [15, 45]]
    found = shortest(field, tour(field, corners, robot=turning), corners)
    legs_m = 4 * (30 - math.sqrt(2) * sight_m(field))
    assert tour_length_m(found) == pytest.approx(legs_m + 2 * math.pi / 0.2 * field.robot.speed_m_s, rel=2e-3)


def test_within_its_budget_a_tour_is_shortened_where_metres_cost(field: Problem) -> None:
    corners = [[15, 15], [45, 15], [45, 45], [15, 45]]
    samples = samples_at(field, corners)[1]
    begun = tour(field, corners, period_s=1000.0)
    for weight, least_m in ((0.0, 120.0), (1.0, 4 * (30 - math.sqrt(2) * sight_m(field)))):
        settings = replace(BENDING, length_weight=weight, range_weight=20.0, least_gain=1e-6)
        search = Bending(field, [begun], samples, settings)  # type: ignore[arg-type]
        search.run(300, should_stop=lambda: False)
        assert tour_length_m(search.tours[0]) == pytest.approx(least_m, rel=2e-3)


def test_a_square_sensor_on_the_corners_of_a_square() -> None:
    problem = problem_of(square=True)
    corners = [[15, 15], [45, 15], [45, 45], [15, 45]]
    found = shortest(problem, tour(problem, corners), corners)
    assert tour_length_m(found) == pytest.approx(4 * (30 - 2 * sight_m(problem)), rel=2e-3)


def test_what_is_missed_is_seen_and_what_need_not_move_stays(field: Problem) -> None:
    begun = tour(field, [[10, 10], [50, 10], [50, 50], [10, 50]])
    _, samples = samples_at(field, [[30, 13.2], [30, 47.5]])  # the first is 3.2 m from the nearest leg
    search = Bending(field, [begun], samples, BENDING)  # type: ignore[arg-type]
    search.run(20, should_stop=lambda: False)
    ring = LineString(np.vstack([search.tours[0].vertices_m, search.tours[0].vertices_m[:1]]))
    assert ring.distance(shapely.Point(30, 13.2)) <= sight_m(field) + 1e-6
    assert tour_length_m(search.tours[0]) < 160.2
    far = search.tours[0].vertices_m[search.tours[0].vertices_m[:, 1] > 20]
    assert np.abs(np.abs(far - 30).max(axis=1) - 20).max() < 1e-9


def test_within_the_budget_before_it_sees_what_it_cannot(field: Problem) -> None:
    # 160 m of tour, a budget of 150 m, and corners that it sees from inside: 4 (40 - sqrt 2 r) is 143.3 m
    corners = [[10, 10], [50, 10], [50, 50], [10, 50]]
    search = Bending(field, [tour(field, corners, period_s=75.0)], samples_at(field, corners)[1], BENDING, reserve=1e-6)  # type: ignore[arg-type]
    assert over_budget_share(search.tours) > 0.06
    search.run(60, should_stop=lambda: False)
    assert over_budget_share(search.tours) == 0
    layout, places = lay_out_tours(search.tours, 10.0)
    assert (look(field, layout, places, samples_at(field, corners)[1]) < 1e-6).all()


def test_a_nest_keeps_its_meeting_place_and_all_its_budgets(field: Problem) -> None:
    nest = [
        tour(field, [[30, 30], [20, 30], [20, 20], [30, 20]], period_s=40.0, nest=2),
        tour(field, [[30, 30], [50, 30], [50, 40]], nest=2, robots=0),
        tour(field, [[30, 30], [30, 55]], nest=2, robots=0),
        tour(field, [[5, 5], [55, 5]], period_class=0),
    ]
    layout, places = lay_out_tours(nest, 4.0)
    lengths = layout.lengths_m(places)
    assert lengths == pytest.approx([tour_length_m(one) for one in nest])
    assert layout.counts @ lengths - layout.budget_m == pytest.approx([over for over, _ in excesses(nest)])
    assert layout.budget_m == pytest.approx([budget for _, budget in excesses(nest)])
    ends = [[20, 20], [50, 40], [30, 55], [5, 5], [55, 5]]
    search = Bending(field, nest, samples_at(field, ends)[1], BENDING, reserve=1e-6)  # type: ignore[arg-type]
    assert over_budget_share(nest) > 0.1
    search.run(100, should_stop=lambda: False)
    assert len({tuple(one.vertices_m[0].tolist()) for one in search.tours[:3]}) == 1
    assert over_budget_share(search.tours) < 0.5 * over_budget_share(nest)


def test_petals_keep_the_vertices_of_the_hub_at_which_they_begin(field: Problem) -> None:
    nest = [
        tour(field, [[30, 30], [20, 30], [20, 20], [30, 20]], period_s=40.0, nest=2),
        tour(field, [[30, 20], [50, 30], [50, 40]], nest=2, robots=0),
        tour(field, [[20, 30], [30, 55]], nest=2, robots=0),
        tour(field, [[20, 30]], nest=2, robots=0),
    ]
    layout, places = lay_out_tours(nest, 4.0)
    lengths = layout.lengths_m(places)
    assert lengths == pytest.approx([tour_length_m(one) for one in nest])
    assert layout.counts @ lengths - layout.budget_m == pytest.approx([over for over, _ in excesses(nest)])
    ends = [[20, 20], [50, 40], [30, 55]]
    search = Bending(field, nest, samples_at(field, ends)[1], BENDING, reserve=1e-6)  # type: ignore[arg-type]
    assert over_budget_share(nest) > 0.1
    search.run(100, should_stop=lambda: False)
    hub, *petals = (one.vertices_m for one in search.tours)
    assert all((hub == petal[0]).all(axis=1).any() for petal in petals)
    assert (petals[1][0] == petals[2][0]).all()
    assert (petals[0][0] != petals[1][0]).any()
    assert over_budget_share(search.tours) < 0.5 * over_budget_share(nest)


def test_what_others_nearly_see_is_handed_over_by_who_has_nothing_to_spare(field: Problem) -> None:
    # one drives 40 m there and back to see both ends, and has 39.98 m for it; another passes 0.03 m out of range
    r = sight_m(field)
    tours = [
        tour(field, [[10, 30], [30, 30]], period_s=19.99),
        tour(field, [[30 + 2 * r + 0.03, 20], [30 + 2 * r + 0.03, 40]]),
    ]
    ends = samples_at(field, [[10 - r, 30], [30 + r, 30], [30 + 2 * r + 0.03, 20 - r]])[1]
    search = Bending(field, tours, ends, BENDING, reserve=1e-6)  # type: ignore[arg-type]
    search.run(60, should_stop=lambda: False)
    assert over_budget_share(search.tours) > 2e-4  # each keeps to what it sees best
    search.hand_over(60, should_stop=lambda: False)
    assert over_budget_share(search.tours) == 0
    layout, places = lay_out_tours(search.tours, 10.0)
    assert (look(field, layout, places, ends) < 1e-6).all()
    # with nobody to take it, everything stays as it is
    alone = Bending(field, tours[:1], ends, BENDING, reserve=1e-6)  # type: ignore[arg-type]
    before = alone.tours[0].vertices_m
    alone.hand_over(60, should_stop=lambda: False)
    assert (alone.tours[0].vertices_m == before).all()


def test_two_lanes_move_aside_together(field: Problem) -> None:
    # no gap between what they see may open, but what one leaves the other can come to
    r = sight_m(field)
    left, right = 30 - 0.99 * r, 30 + 0.99 * r
    between = [[x, y] for x in np.arange(30 - r, 30 + r, 0.1) for y in np.arange(10, 51, 0.5)]
    samples = samples_at(field, [*between, *([left - r - 0.25, y] for y in np.arange(10, 51, 5))])[1]
    lanes = tour(field, [[left, 10], [left, 50], [right, 50], [right, 10]])
    short = replace(BENDING, length_weight=1.0, range_weight=20.0, least_gain=1e-6, shares=True)
    search = Bending(field, [lanes], samples, short)  # type: ignore[arg-type]
    search.run(60, should_stop=lambda: False)
    layout, places = lay_out_tours(search.tours, 10.0)
    assert (look(field, layout, places, samples) < field.range_margin_m).all()


def test_nobody_leaves_the_space() -> None:
    problem = problem_of(box(20, 20, 40, 40))
    # the short way leads through the obstacle, and everything pulls there
    corners = [[18, 18], [42, 18], [42, 42], [18, 42]]
    begun = tour(problem, corners, period_s=1.0)
    search = Bending(problem, [begun], samples_at(problem, corners)[1], BENDING)  # type: ignore[arg-type]
    search.run(60, should_stop=lambda: False)
    ring = search.tours[0].vertices_m
    assert free_segments(ring, np.roll(ring, -1, axis=0), problem.paths.grid).all()
    assert 80 <= tour_length_m(search.tours[0]) < 0.9 * tour_length_m(begun)


def test_who_sees_what_by_brute_force() -> None:
    rng = np.random.default_rng(7)
    for square in (False, True):
        problem = problem_of(box(25, 20, 35, 40), square=square)
        points, samples = samples_at(problem, rng.uniform(0, 60, (300, 2)))
        begun = tour(problem, [[12, 12], [22, 45], [48, 50], [44, 14]])
        layout, places = lay_out_tours([begun], 8.0)
        lack = look(problem, layout, places, samples)
        expected = brute_lack(problem, begun, points.xy_m, square)
        near = expected < 0.5
        assert near.sum() > 40
        assert lack[near] == pytest.approx(expected[near], abs=0.02)
        assert (lack[expected > 1.2] > 1).all()


def look(problem: Problem, layout: Layout, places_m: Floats, samples: object) -> Floats:
    return sightings(layout, places_m, samples, range_margin_m=0.0, further_m=1.0).range_deficit_m[:, 0]  # type: ignore[arg-type]


def brute_lack(problem: Problem, begun: Tour, xy_m: Floats, square: bool) -> Floats:
    """By how much range is short of the nearest of many places on the tour from which nothing hides the point."""
    ring = LineString(np.vstack([begun.vertices_m, begun.vertices_m[:1]]))
    places = shapely.get_coordinates(ring.interpolate(np.linspace(0, ring.length, 8001)))
    hidden_by = shapely.union_all([o.shape for o in problem.mission.obstacles]).buffer(-1e-6)
    found = np.full(len(xy_m), np.inf)
    for i, point in enumerate(xy_m):
        if hidden_by.buffer(2e-6).covers(shapely.Point(point)):
            continue
        apart = np.abs(places - point)
        ranges = apart.max(axis=1) if square else np.hypot(*apart.T)
        order = np.argsort(ranges)
        order = order[ranges[order] < REACH_M + 1.5]
        lines = shapely.linestrings(np.stack([np.broadcast_to(point, (len(order), 2)), places[order]], axis=1))
        clear = np.flatnonzero(~shapely.intersects(lines, hidden_by))
        if len(clear):
            found[i] = ranges[order[clear[0]]] - REACH_M
    return found


def test_where_it_is_of_no_use() -> None:
    problem = problem_of()
    assert can_bend(problem)
    assert can_bend(replace(problem, robot=replace(problem.robot, turn_rate_rad_s=1.0)))
    assert not can_bend(replace(problem, robot=replace(problem.robot, turn_radius_m=1.0)))
    standing = replace(problem, regions=(*problem.regions, replace(problem.regions[0], period_s=0.01)))
    assert not can_bend(standing)

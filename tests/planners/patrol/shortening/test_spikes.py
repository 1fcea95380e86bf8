"""Spikes: what is one, what is none, and tours without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import search_on

from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.shortening.spikes import detours, samples_near, spikes, unseen_m2, without
from rota.planners.patrol.tours.tour import Tour

HALL = Mission(
    name="hall", area=MultiPolygon([box(0, 0, 20, 10)]), period_s=60,
    fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=4)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip
ROUND = [(2.0, 2.0), (18.0, 2.0), (18.0, 8.0), (2.0, 8.0)]


@pytest.fixture(scope="module")
def context() -> Context:
    return search_on(HALL)


def tour_by(context: Context, *corners: tuple[float, float]) -> Tour:
    return Tour(vertices_m=np.array(corners), period_class=0, period_s=60.0, robots=1, robot=context.problem.robot)


def test_a_detour_over_ground_that_others_see_is_a_spike(context: Context) -> None:
    tour = tour_by(context, *ROUND[:1], (10.0, 2.0), (10.2, 5.0), (10.4, 2.0), *ROUND[1:])
    (spike,) = spikes(context.problem, [tour])
    assert (spike.tour, spike.first, spike.corners) == (0, 2, 1)
    assert spike.saved_m == pytest.approx(2 * np.hypot(0.2, 3.0) - 0.4)
    (straight,) = without([tour], [spike])
    assert len(straight.vertices_m) == len(tour.vertices_m) - 1
    assert spikes(context.problem, [straight]) == []


def test_what_a_detour_alone_sees_is_told_by_the_samples_near_it(context: Context) -> None:
    problem = context.problem
    tour = tour_by(context, (2.0, 5.0), (2.2, 5.0), (8.0, 5.1), (2.2, 5.2), (2.2, 8.0), (1.8, 8.0))
    points, samples = prepare_with(problem, no_points())
    for spike in detours(problem, [tour]):
        near = samples_near(problem, tour, spike, points, samples)
        assert near is not None
        assert len(near.x) < len(samples.x)
        straight = without([tour], [spike])
        lost_m2 = [unseen_m2(problem, straight, some) - unseen_m2(problem, [tour], some) for some in (samples, near)]
        assert lost_m2[0] > 0
        assert lost_m2[1] == pytest.approx(lost_m2[0])


def test_a_spike_over_the_seam_of_its_tour(context: Context) -> None:
    tour = tour_by(context, (10.2, 5.0), (10.4, 5.0), (10.4, 2.0), *ROUND[1:], ROUND[0], (10.0, 2.0), (10.1, 5.0))
    (spike,) = spikes(context.problem, [tour])
    assert (spike.first, spike.corners) == (8, 3)
    np.testing.assert_array_equal(without([tour], [spike])[0].vertices_m, tour.vertices_m[2:8])


def test_a_detour_that_alone_sees_its_ground_is_none(context: Context) -> None:
    tour = tour_by(context, (2.0, 5.0), (2.2, 5.0), (18.0, 5.1), (2.2, 5.2))
    assert len(list(detours(context.problem, [tour]))) > 0
    assert spikes(context.problem, [tour]) == []


def test_no_way_past_a_wall(context: Context) -> None:
    wall = replace(HALL, area=MultiPolygon([box(0, 0, 20, 10) - box(9.9, 0, 10.1, 6)]))
    over = tour_by(context, (2.0, 2.0), (9.5, 2.0), (9.8, 7.0), (10.2, 7.0), (10.5, 2.0), (18.0, 2.0), (18.0, 8.0))
    assert all(spike.first != 2 for spike in detours(search_on(wall).problem, [over]))


def test_tours_of_nests_keep_their_corners(context: Context) -> None:
    tour = tour_by(context, *ROUND[:1], (10.0, 2.0), (10.2, 5.0), (10.4, 2.0), *ROUND[1:])
    petal = replace(tour, vertices_m=np.array([ROUND[0], (4.0, 4.0)]), nest=0)
    assert list(detours(context.problem, [replace(tour, nest=0), petal])) == []


def test_of_two_that_meet_only_one_is_taken(context: Context) -> None:
    tour = tour_by(context, *ROUND[:1], (10.0, 2.0), (10.2, 6.0), (10.4, 4.0), (10.6, 6.0), (10.8, 2.0), *ROUND[1:])
    (spike,) = spikes(context.problem, [tour])
    assert len(list(detours(context.problem, [tour]))) > 1
    assert spike.corners == 3
    np.testing.assert_array_equal(without([tour], [spike])[0].vertices_m, tour.vertices_m[[0, 1, 5, 6, 7, 8]])

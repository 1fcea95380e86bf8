"""Mending: the least detour past a further place, whatever is looked at first; how near to it tours are asked to go."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.mission import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings
from rota.planners.patrol.annealing.tour import Tour, tour_length_m
from rota.planners.patrol.problem import Problem, set_up_problem
from rota.planners.patrol.repair import least_detour, shorter_m


@pytest.fixture(scope="module")
def problem() -> Problem:
    blocks = [box(x, y, x + 6, y + 6) for x in (4, 16, 28) for y in (4, 16)]
    return set_up_problem(
        Mission(
            name="yard",
            area=MultiPolygon([box(0, 0, 38, 26)]),
            obstacles=tuple(Obstacle(shape=MultiPolygon([block])) for block in blocks),
            period_s=30,
            fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=4)),
            planning=PatrolSettings(effort="quick"),
        )
    )


def test_the_least_detour_is_that_of_all_legs_looked_at(problem: Problem) -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform((0, 0), (38, 26), (400, 2))
    places = places[shapely.intersects_xy(problem.space, *places.T)]
    tour, others = problem.paths.paths_along(places[:120]), places[120:180]
    assert len(tour) > 120
    for place in others:
        ways = problem.paths.distances(tour, place[None])[:, 0]
        legs = np.hypot(*(np.roll(tour, -1, axis=0) - tour).T)
        detours = ways + np.roll(ways, -1) - legs
        leg, detour = least_detour(problem, tour, place)
        assert detour == pytest.approx(detours.min(), abs=1e-9)
        assert detours[leg] == pytest.approx(detours.min(), abs=1e-9)


def test_no_way_is_no_detour(problem: Problem) -> None:
    assert least_detour(problem, np.array([[1.0, 1.0], [2.0, 1.0]]), np.array([7.0, 7.0]))[1] == np.inf


def test_tight_tours_are_asked_for_hardly_more_in_later_rounds(problem: Problem) -> None:
    ring = np.array([[0.0, 0], [15, 0], [15, 15], [0, 15]])
    roomy = Tour(vertices_m=ring / 2, serves=0, period_s=30, robots=1, robot=problem.robot, part=0)
    tight = Tour(vertices_m=ring, serves=0, period_s=30, robots=1, robot=problem.robot, part=0)
    assert (tour_length_m(roomy), tour_length_m(tight), tight.budget_m) == pytest.approx((30, 60, 60), rel=0.01)

    def asked(tour: Tour, *, bends: bool) -> list[float]:
        return [shorter_m(problem, [tour], turn, bends=bends) / problem.reach_m for turn in (1, 20)]

    margin = problem.range_margin_m / problem.reach_m
    for tour in (roomy, tight):
        first, last = asked(tour, bends=False)
        assert (first, last) == pytest.approx((margin / 4, 5 * margin))
    assert asked(roomy, bends=True)[1] > asked(roomy, bends=True)[0] > asked(tight, bends=True)[1]
    # all rounds together may take a tight tour no more than its range margin
    assert np.diff(asked(tight, bends=True))[0] < margin

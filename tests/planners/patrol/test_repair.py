"""Where a tour is led past a further place: the least detour of all legs, whatever is looked at first."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.mission import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings
from rota.planners.patrol.problem import Problem, set_up_problem
from rota.planners.patrol.repair import least_detour


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

"""Tours led to what they do not see yet."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import cheap_search_on

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground import problem as ground_problem
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.samples import SamplePoints, lay_out, points_of
from rota.planners.patrol.repair.repair import seeing_missed
from rota.planners.patrol.repair.seeing import annealing_of, lead_to_the_rest
from rota.planners.patrol.tours.tour import Tour

SCREENS = [box(x, y, x + 3.0, y + 0.5) for x in (2.0, 8.0) for y in (3.0, 8.0)]


@pytest.fixture
def hall(monkeypatch: pytest.MonkeyPatch) -> Context:
    """A hall with screens, taken for ragged ground."""
    monkeypatch.setattr(ground_problem, "MOST_DENSE", 0)
    return cheap_search_on(
        Mission(
            name="hall",
            area=MultiPolygon([box(0, 0, 14, 12)]),
            obstacles=tuple(Obstacle(shape=MultiPolygon([screen])) for screen in SCREENS),
            fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0), body_radius_m=0.2),
            period_s=200.0,
        )
    )


def short_tour(context: Context) -> Tour:
    return Tour(
        vertices_m=np.array([[1.0, 1.0], [2.0, 1.0], [1.5, 1.5]]), period_class=0, period_s=200.0, robots=1,
        robot=context.problem.robot, component=0,
    )  # fmt: skip


def unseen(context: Context, tours: list[Tour], points: SamplePoints) -> int:
    _, samples, _ = lay_out(points, context.problem.walls, context.problem.robot)
    return annealing_of(context, tours, samples, length_weight=1.0, seed=0).unseen


def test_detours_lead_to_all_samples_and_go_through_no_wall(hall: Context) -> None:
    assert hall.problem.is_ragged
    points, samples = prepare_with(hall.problem, no_points())
    tours = [short_tour(hall)]
    assert unseen(hall, tours, points) > 100
    longer = lead_to_the_rest(hall, tours, points, samples, seed=0)
    assert unseen(hall, longer, points) == 0
    ring = shapely.linestrings(np.vstack([longer[0].vertices_m, longer[0].vertices_m[:1]]))
    assert shapely.covers(hall.problem.space.buffer(1e-6), ring)


def test_what_is_missed_is_led_to_and_nothing_else_moves(hall: Context) -> None:
    missed = points_of(np.array([[12.0, 11.5], [9.0, 9.0]]), 1.0, 0, 0)
    [led] = seeing_missed(hall, [short_tour(hall)], missed, seed=0)
    assert unseen(hall, [led], missed) == 0
    places = {tuple(place) for place in led.vertices_m}
    assert all(tuple(place) in places for place in short_tour(hall).vertices_m)
    assert len(led.vertices_m) < 30
    assert seeing_missed(hall, [led], missed[np.zeros(0, np.int64)], seed=0) == [led]

"""Repairs over samples that hardly overlap: they find room where others leave tours a little over their budgets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import search_on

from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.little_overlap import repair_with_little_overlap, with_little_overlap
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour, tour_length_m

FIELD = Mission(
    name="field", area=MultiPolygon([box(0, 0, 24, 18)]), period_s=120,
    fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2.5)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


@pytest.fixture(scope="module")
def context() -> Context:
    return search_on(FIELD)


def repaired(context: Context, tours: list[Tour]) -> Repaired:
    """The tours after the usual repair."""
    rounds = context.settings.repair.rounds
    return repair_until_feasible(context, tours, no_points(), may_add=False, rounds=rounds, annealed=True)


def test_lanes_hardly_overlap_where_every_metre_counts(context: Context) -> None:
    problem, less = context.problem, with_little_overlap(context.problem)
    on_lattice = problem.points.row >= 0
    assert (problem.points.shrink_m[on_lattice] >= 0.2 * problem.spacing_m - 1e-9).all()
    np.testing.assert_allclose(less.points.shrink_m[on_lattice], 0.1 * problem.spacing_m)
    np.testing.assert_allclose(less.samples.frames[:, 3], 0.1 * problem.spacing_m)
    np.testing.assert_array_equal(less.points.shrink_m[~on_lattice], problem.points.shrink_m[~on_lattice])
    np.testing.assert_array_equal(less.samples.shrink_m, less.points.shrink_m)
    np.testing.assert_array_equal(less.samples.frames[:, :3], problem.samples.frames[:, :3])


def test_tours_a_little_over_their_budgets_are_brought_within_them(context: Context) -> None:
    lanes_m = [(x, y) for i, x in enumerate(np.arange(1.8, 23.0, 4.0)) for y in ((4.0, 16.5), (16.5, 4.0))[i % 2]]
    loop_m = np.array([*lanes_m, (22.5, 1.5), (1.5, 1.5)])
    robot = FIELD.fleet.equal_robot("one")
    loose = repaired(context, [Tour(vertices_m=loop_m, period_class=0, period_s=120.0, robots=1, robot=robot)])
    period_s = 0.926 * tour_length_m(loose.tours[0]) / robot.speed_m_s  # a hair less than the usual repair needs
    hurried = search_on(replace(FIELD, period_s=period_s))
    failed = repaired(hurried, [replace(loose.tours[0], period_s=period_s)])
    assert not failed.met
    assert not failed.within_budgets
    tighter = repair_with_little_overlap(hurried, failed, no_points())
    assert tighter.within_budgets
    assert check_plan(tighter.plan).verdict == "met"

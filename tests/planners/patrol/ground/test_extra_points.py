"""The problem's points laid out again with what they are worth: nothing else of them changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.planners.patrol.searching import YARD

from rota.planners.patrol.ground.extra_points import UNSEEN_WEIGHT, no_points, prepare_with
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.ground.samples import known_walls, lay_out


def test_without_further_points_all_stays_but_the_weights() -> None:
    problem = set_up_problem(YARD)
    points, samples = prepare_with(problem, no_points())
    laid_out, anew, order = lay_out(problem.points, problem.walls, problem.robot, known=known_walls(problem.samples))
    np.testing.assert_array_equal(order, np.arange(len(points)))
    np.testing.assert_array_equal(points.xy_m, laid_out.xy_m)
    for name in samples._fields:
        if name != "weight":
            np.testing.assert_array_equal(getattr(samples, name), getattr(anew, name), err_msg=name)
    # by hand: three times the metres of a lane of 4 m
    assert UNSEEN_WEIGHT == 3.0
    np.testing.assert_allclose(samples.weight, 3.0 * points.area_m2 / 4.0)


def test_points_that_stand_for_themselves_alone_are_laid_out_as_that() -> None:
    problem = set_up_problem(YARD)
    alone = replace(problem, points=replace(problem.points, shrink_m=0.0 * problem.points.shrink_m))
    _, samples = prepare_with(alone, no_points())
    assert problem.samples.shrink_m.max() > 0
    assert samples.shrink_m.max() == samples.frames[:, 3].max() == 0

"""Points that the search adds to those of the problem, and all of them laid out with their weights."""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Floats
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, join, known_walls, lay_out, points_of, thin

UNSEEN_WEIGHT = 3.0  # what a sample is worth, as a multiple of the metres that its ground costs to sweep


def no_points() -> SamplePoints:
    """No further points."""
    return points_of(np.zeros((0, 2)), 0.0, 0, 0)


def prepare_with(problem: Problem, extra: SamplePoints, *, coarse: bool = False) -> tuple[SamplePoints, Samples]:
    """The problem's points and further ones, laid out for the kernels with their weights in metres of travel.

    coarse: of the points on lattices only every other one of every other row, each with four times the area.
    """
    are_laid_out = problem.points.shrink_m is problem.samples.shrink_m  # not so where they stand for themselves alone
    if are_laid_out and not coarse and not len(extra):
        return problem.points, problem.samples._replace(weight=metres_worth(problem, problem.points))
    points = thin(problem.points) if coarse else problem.points
    points = join([points, extra]) if len(extra) else points
    known = None if coarse else known_walls(problem.samples)
    points, samples, _ = lay_out(
        points, problem.walls, problem.robot, weight=metres_worth(problem, points), known=known
    )
    return points, samples


def metres_worth(problem: Problem, points: SamplePoints) -> Floats:
    """The metres (n,) that it is worth to see each of the points."""
    # no way is too long for a visit, however small the zone
    longest_m = np.array(problem.periods_s)[points.period] * problem.pace_m_s
    return np.where(points.visit_m > 0, longest_m, UNSEEN_WEIGHT * points.area_m2 / problem.swath_m)

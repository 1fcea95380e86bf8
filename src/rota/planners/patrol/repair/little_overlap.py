"""A repair over samples that hardly overlap, of tours that another left a little over their budgets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible


def repair_with_little_overlap(context: Context, failed: Repaired, extra: SamplePoints) -> Repaired:
    """The tours of a repair that failed after another one, in which they may exceed their budgets by 1 % on the way.

    extra: the points with which the failed repair began; what it found unmet is found again where it still is.
    What eight rounds do not mend is left to the next annealing, which knows what they found unmet.
    """
    repair = replace(context.settings.repair, over_budget_limit=0.01)
    settings = replace(context.settings, repair=repair)
    own = replace(context, problem=with_little_overlap(context.problem), settings=settings)
    return repair_until_feasible(own, failed.tours, extra, may_add=False, rounds=min(8, repair.rounds), annealed=True)


def with_little_overlap(problem: Problem) -> Problem:
    """The problem with sensors that are taken to reach less by a tenth of the samples' spacing at most.

    More makes lanes overlap by so much, and loops longer; what is then missed between samples takes rounds of repair.
    """
    shrink_m, frames = 0.1 * problem.spacing_m, problem.samples.frames.copy()
    frames[:, 3] = np.minimum(frames[:, 3], shrink_m)  # as the lattices' rows have it
    less_m = np.minimum(problem.points.shrink_m, shrink_m)
    points, samples = replace(problem.points, shrink_m=less_m), problem.samples._replace(shrink_m=less_m, frames=frames)
    return replace(problem, points=points, samples=samples)

"""Tours led to where they see what they do not see yet: bent a little, or by detours to what is left."""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Ints
from rota.planners.patrol.annealing.search import Annealing, budget_penalties
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, known_walls, lay_out
from rota.planners.patrol.repair.detours import visit_places
from rota.planners.patrol.tours.tour import Tour


def see_the_rest(
    context: Context, tours: list[Tour], points: SamplePoints, samples: Samples, *, seed: int
) -> list[Tour]:
    """Bend the tours a little until they see all samples; lead them by a detour to what is left."""
    search = annealing_of(context, tours, samples, length_weight=0.3, seed=seed)  # metres are cheap
    search.see_more(500 + 40 * search.unseen, context.should_stop)
    return lead_to_the_rest(context, search.tours, points, samples, seed=seed, unseen=search.unseen_samples)


def lead_to_the_rest(
    context: Context,
    tours: list[Tour],
    points: SamplePoints,
    samples: Samples,
    *,
    seed: int,
    unseen: Ints | None = None,
) -> list[Tour]:
    """The tours led by detours to the samples that they do not see. unseen: these, where they are known.

    Detours take nothing out of sight, and end when the search is to stop. On ragged ground, which has very many
    samples, only what was unseen is therefore looked at again.
    """
    problem, left = context.problem, 0
    for turn in range(5):
        if unseen is None:
            unseen = annealing_of(context, tours, samples, length_weight=1.0, seed=seed).unseen_samples
        if len(unseen) in (0, left) or context.should_stop():
            break  # none is left, or what is left is seen only by a hair
        left = len(unseen)
        if problem.is_ragged:
            known, weight = known_walls(samples, unseen), samples.weight[unseen]
            points, samples, _ = lay_out(points[unseen], problem.walls, problem.robot, weight=weight, known=known)
            unseen = np.arange(left)
        further = turn == 0 or not problem.is_ragged
        longer = visit_places(problem, tours, points, samples, unseen, further=further)
        if longer is None:
            break
        tours, unseen = longer, None
    return tours


def annealing_of(
    context: Context, tours: list[Tour], samples: Samples, *, length_weight: float, seed: int, reserve: float = 0.0
) -> Annealing:
    """The tours as random moves see them, with a high penalty on metres over their budgets less the reserve."""
    problem = context.problem
    return Annealing(
        tours, samples, problem.paths.grid,
        length_weight=np.full(len(tours), length_weight),
        budget_penalty=budget_penalties(tours, 6.0),
        seed=seed, range_margin_m=problem.range_margin_m, reserve=reserve,
    )  # fmt: skip

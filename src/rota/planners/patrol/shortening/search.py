"""Shorter loops at the same number of robots: annealed once more for length, then bent and repaired until they pass.

The search for fewest robots ends as soon as the tours keep within their budgets. What is left of the budgets is spent
here: every metre costs a metre, an unseen sample several times what it takes to see it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.planners.patrol.annealing.search import Annealing, budget_penalties
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepared_with
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.bending.search import can_bend
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.settings import ShorteningStage
from rota.planners.patrol.shortening.measures import is_better, rounds_of
from rota.planners.patrol.shortening.turning import as_if_turning_cost, as_they_were
from rota.planners.patrol.tours.tour import Tour


def with_better_loops(context: Context, found: Repaired) -> Repaired:
    """The plan with the loops that the mission prefers; the plan found where no better ones pass the judge.

    Each attempt begins with the tours found: the first with much heat, which gives them another shape where the
    budgets leave room for one, the next with little. Ground where turning takes time or the limit of sight is asked
    for is left as it is, for no linear program closes the gaps there; and so is very large ground.
    """
    settings, problem = context.settings.shortening, context.problem
    if not can_bend(problem) or reaches(problem) > settings.largest:
        return found
    fewest_turns = PatrolSettings.of(problem.mission).prefer == "fewest_turns"
    for turn, stages in enumerate(settings.attempts):
        if context.should_stop():
            break
        context.progress(0.91 + 0.04 * turn / len(settings.attempts), "looking for shorter loops")
        shorter = annealed_and_repaired(
            context, found.tours, stages, fewest_turns=fewest_turns, seed=context.seed + 10 * turn
        )
        if is_better(shorter, found, fewest_turns=fewest_turns):
            return shorter
    return found


def annealed_and_repaired(
    context: Context, tours: list[Tour], stages: tuple[ShorteningStage, ...], *, fewest_turns: bool, seed: int
) -> Repaired:
    """The tours annealed in stages, then repaired by linear programs that keep them short; met or not."""
    settings = context.settings.shortening
    tried = as_if_turning_cost(tours, settings.turn_reaches * context.problem.reach_m) if fewest_turns else tours
    for turn, stage in enumerate(stages):
        tried = annealed_for_length(context, tried, stage, seed=seed + turn)
    repair = replace(context.settings.repair, bending_steps=settings.bending_steps)
    own = replace(context, settings=replace(context.settings, bending=settings.bending, repair=repair))
    return repair_until_feasible(
        own, as_they_were(tried, tours), no_points(), may_add=False, rounds=settings.rounds, annealed=True
    )


def annealed_for_length(context: Context, tours: list[Tour], stage: ShorteningStage, *, seed: int) -> list[Tour]:
    """The tours after one annealing in which every metre that is driven costs a metre."""
    problem, settings = context.problem, context.settings.shortening
    _, samples = prepared_with(problem, no_points())
    search = Annealing(
        tours, samples._replace(weight=stage.coverage_weight * samples.weight), problem.paths.grid,
        length_weight=np.array(rounds_of(tours), dtype=np.float64),
        budget_penalty=budget_penalties(tours, settings.budget_penalty),
        seed=seed, range_margin_m=problem.range_margin_m, reserve=settings.reserve,
    )  # fmt: skip
    search.run(
        int(stage.moves * reaches(problem)), hot_m=stage.hot * problem.reach_m, cold_m=stage.cold * problem.reach_m,
        should_stop=context.should_stop,
    )  # fmt: skip
    return search.tours


def reaches(problem: Problem) -> float:
    """The length of an ideal loop over all ground, in reaches of the sensor; at least one."""
    asked_m2 = sum(region.shape.area for region in problem.regions if region.demand == "every_point")
    return max(1.0, float(asked_m2 / problem.swath_m / problem.reach_m))

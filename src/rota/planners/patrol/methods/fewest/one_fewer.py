"""Fewer robots than the best plan so far has, by annealing the tours of that plan."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from rota.planners.patrol.annealing.schedule import anneal_all
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.methods.fewest.racing import first_to_pass
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour, excesses, tour_length_m


def give_up_robots(context: Context, best: Repaired, fewer: int = 1) -> Repaired | None:
    """A plan with so many robots less that the judge passes, begun with the tours of the best plan so far; or None.

    Its tours see everything already, and only have to become shorter. As little annealing as a screening shows whether
    they can, and longer annealing gains nothing before the repairs. It fails where a plan needs other groups of periods
    or nested loops. The tour that gives up the first robot is the one with which the least is missing.
    """
    context = context.with_all_moves()
    seed = context.seed + 1000 * (best.robots + 1 - fewer) + 500
    begun, moves = list(tours_with_fewer(best.tours, fewer)), context.settings.screening.moves
    tried = anneal_all(context, begun, moves=moves, seed=seed, coarse=False)
    nearest = sorted(tried, key=lambda search: search.shortfall_m)[:1]
    most = context.settings.alternation.unseen_limit
    return first_to_pass(context, [s for s in nearest if s.unseen_share <= most], seed=seed)


def leave_out_needless_robots(context: Context, found: Repaired) -> Repaired:
    """The plan with as few robots on each loop as keep its period, if the judge passes it; else the plan found."""
    tours = [with_few_robots(tour) for tour in found.tours]
    if sum(tour.robots for tour in tours) >= sum(tour.robots for tour in found.tours):
        return found
    rounds = context.settings.shortening.rounds
    fewer = repair_until_feasible(context, tours, no_points(), may_add=False, rounds=rounds, annealed=True)
    return fewer if fewer.met and fewer.robots < found.robots else found


def with_few_robots(tour: Tour) -> Tour:
    """The tour with the fewest robots that go round it in time; loops within loops are left as they are."""
    if tour.nest >= 0:
        return tour
    alone = replace(tour, robots=1)
    return replace(tour, robots=min(tour.robots, max(1, math.ceil(tour_length_m(alone) / alone.budget_m))))


def tours_with_fewer(tours: list[Tour], fewer: int) -> Iterator[list[Tour]]:
    """The tours with so many robots less: each that several share gives up the first, whoever is least loaded the rest.

    Nothing where that would leave a tour without a robot.
    """
    if fewer > sum(tour.robots - 1 for tour in tours):
        return
    for k in (k for k, tour in enumerate(tours) if tour.robots > 1):
        smaller = with_one_less(tours, k)
        for _ in range(fewer - 1):
            left = [with_one_less(smaller, j) for j, tour in enumerate(smaller) if tour.robots > 1]
            smaller = min(left, key=loads)
        yield smaller


def loads(tours: list[Tour]) -> list[float]:
    """By how much of them budgets are exceeded, the most first; less than 0 where there is room."""
    return sorted((excess_m / budget_m for excess_m, budget_m in excesses(tours)), reverse=True)


def with_one_less(tours: list[Tour], k: int) -> list[Tour]:
    """The tours with a robot less on one of them."""
    return [*tours[:k], replace(tours[k], robots=tours[k].robots - 1), *tours[k + 1 :]]

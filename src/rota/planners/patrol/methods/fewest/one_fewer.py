"""One robot fewer than the best plan so far, by annealing the tours of that plan."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rota.planners.patrol.annealing.schedule import anneal_all
from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.fewest.racing import first_to_pass
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.tours.tour import Tour

UNSEEN_LIMIT = 0.01  # share of the ground: tours that leave more unseen hardly ever pass after repairs


def one_fewer(context: Context, best: Repaired) -> Repaired | None:
    """A plan with one robot less that the judge passes, begun with the tours of the best plan so far; or None.

    Its tours see everything already, and only have to become shorter. As little annealing as a screening shows whether
    they can, and longer annealing gains nothing before the repairs. It fails where a plan needs other groups of periods
    or nested loops. The tour that gives up a robot is the one with which the least is missing.
    """
    seed = context.seed + 1000 * best.robots + 500
    begun, moves = list(with_one_fewer(best.tours)), context.settings.screening.moves
    tried = anneal_all(context, begun, moves=moves, seed=seed, coarse=False)
    nearest = sorted(tried, key=lambda search: search.shortfall_m)[:1]
    return first_to_pass(context, [s for s in nearest if s.unseen_share <= UNSEEN_LIMIT], seed=seed)


def with_one_fewer(tours: list[Tour]) -> Iterator[list[Tour]]:
    """The tours with a robot less on one of those that several share."""
    for k, tour in enumerate(tours):
        if tour.robots > 1:
            yield [*tours[:k], replace(tour, robots=tour.robots - 1), *tours[k + 1 :]]

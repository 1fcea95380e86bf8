"""Annealing cooler and cooler, with repairs in between, until the judge passes the tours or it does not pay."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence

from rota.planners.patrol.annealing.schedule import anneal_tours
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.repair.bending.search import can_bend
from rota.planners.patrol.repair.little_overlap import repair_with_little_overlap
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.settings import AlternationSettings, Stage
from rota.planners.patrol.tours.tour import Tour, excesses


def anneal_and_repair(context: Context, search: Annealed, *, seed: int) -> Iterator[Repaired | None]:
    """After every repair None, or at last the plan that the judge passed within the budgets.

    Tours that come near to their budgets once may do so with other seeds, so that other attempts are made.
    """
    settings = context.settings.alternation
    least_excess = math.inf
    attempts = 1 if context.problem.robot.motion.has_mass else settings.attempts  # a second one passes too rarely
    for attempt in range(attempts):
        excess = yield from attempt_with_seed(context, search, seed=seed + 10 * attempt)
        least_excess = min(excess, least_excess)
        if math.isinf(excess) or least_excess > settings.near_budget_limit or context.should_stop():
            return


def attempt_with_seed(context: Context, search: Annealed, *, seed: int) -> Generator[Repaired | None, None, float]:
    """Anneal, then repair; while that fails narrowly, anneal again, cooler, with what the judge found unmet.

    Yields as ``anneal_and_repair`` does. Returns the least share by which repaired tours were over their budgets; inf
    calls for no other attempt. The weight of seeing grows and the reserve shrinks from one annealing to the next, since
    a repair takes many times the metres that annealing does. A repair that could not find the rest is left out, and so
    is all that comes after it.
    """
    settings = context.settings.alternation
    extra = no_points()
    least_excess = math.inf
    for turn, stage in enumerate(settings.stages):
        over_limit = excess_share(context, search.tours) > settings.over_budget_limit
        if context.should_stop() or search.unseen_share > settings.unseen_limit or over_limit:
            break
        search = context.run(anneal_once_more, search, extra, stage, seed=seed + 1 + turn)
        if turn + 1 < len(settings.first_stages):
            continue
        repaired = context.run(
            repair_until_feasible,
            search.tours,
            extra,
            may_add=False,
            rounds=context.settings.repair.rounds,
            annealed=True,
        )
        if is_near(context, repaired):
            repaired = context.run(repair_with_little_overlap, repaired, extra)
        if repaired.met:
            if context.executor is not None:
                context.judge(repaired.plan)  # who looks on was not told of what is judged elsewhere
            yield repaired
            return math.inf
        yield None
        if repaired.within_budgets and not len(repaired.verdict.unmet_points_m):
            return math.inf  # everything is seen in time, but bodies touch: they would on any tour much like this
        excess = excess_share(context, repaired.tours)
        if not goes_on(excess, least_excess, settings):
            break
        least_excess, extra = min(excess, least_excess), repaired.extra
    return least_excess


def anneal_once_more(context: Context, search: Annealed, extra: SamplePoints, stage: Stage, *, seed: int) -> Annealed:
    """The annealing that begins with the tours of another, with this stage's heat, weight and reserve."""
    stage = stage._replace(heat=max(stage.heat, 1 / 32))  # cooler ones hardly move
    moves = context.settings.alternation.moves
    return anneal_tours(context, search.tours, extra, moves=moves, seed=seed, stage=stage)


def excess_share(context: Context, tours: Sequence[Tour]) -> float:
    """The greatest excess over a budget, as a share of it or of twenty reaches, if that is more.

    What a lattice of samples misses costs metres in proportion to the reach, however short a tour is.
    """
    least_m = 20 * context.problem.reach_m
    return max(0.0, *(excess_m / max(budget_m, least_m) for excess_m, budget_m in excesses(tours)))


def is_near(context: Context, repaired: Repaired) -> bool:
    """Whether a repair has failed so narrowly that one over samples that hardly overlap may pass."""
    over, unmet = excess_share(context, repaired.tours), len(repaired.verdict.unmet_points_m)
    near = over <= context.settings.alternation.near_budget_limit and (over > 0 or unmet > 0)
    return near and not repaired.met and can_bend(context.problem) and not context.should_stop()


def goes_on(excess: float, least_excess: float, settings: AlternationSettings) -> bool:
    """Whether another annealing may bring the tours within budgets that they exceed by this share after a repair."""
    gains = excess < least_excess or excess <= settings.near_budget_limit
    return gains and excess <= settings.over_budget_limit

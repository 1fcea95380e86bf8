"""Annealing cooler and cooler, and mending in between, until the judge passes the tours or it does not pay."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator

from rota.planners.patrol.annealing.schedule import PRICE, Stage, annealed
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.context import Context, Work
from rota.planners.patrol.ground.extra_points import no_points, prepared_with
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.repair.bending.search import Polish, can_polish
from rota.planners.patrol.repair.repair import TIGHT, Settled, as_near_as_tight, settle
from rota.planners.patrol.tours.tour import Tour, over_budget_share

GAINING = 0.8  # of what tours are over budget after the last mending: more, and they will not come within it
CLOSE = 0.006  # share of the budgets that another annealing gains or not, as luck has it
LUCK = 0.002  # the same of all annealings from cold on: as much nearer may they come with other seeds
SEEDS_APART = 10  # the annealings of one cooling take seeds of their own
SHORTENING = 40  # steps of linear programs before the first mending
COOLEST = 1 / 32  # of the reach: heat of the last annealings
LAST_RESERVE = 0.0075  # of annealings that begin from mended tours
LAST_STAGES = (Stage(1 / 4, 3.0, 0.01), Stage(1 / 16, 12.0, 0.005))  # before the first mending
UNSEEN, OVER = 0.015, 0.03  # shares of the ground and of the budgets that mending and cooler annealing may still gain


def cool_and_settle(context: Context, search: Annealing, *, seed: int) -> Iterator[Settled | None]:
    """After every mending None, or at last the settled plan that the judge passed within the budgets.

    Tours that come nearly within their budgets once may do so with other seeds: they are cooled as often as pays.
    """
    least_over = math.inf
    for turn in range(context.work.chances):
        over = yield from cooled_and_settled(context, search, seed=seed + SEEDS_APART * turn)
        least_over = min(over, least_over)
        if math.isinf(over) or least_over > LUCK or context.should_stop():
            return


def cooled_and_settled(context: Context, search: Annealing, *, seed: int) -> Generator[Settled | None, None, float]:
    """Anneal cooler, then mend; while that fails narrowly, anneal again, cooler still, knowing what the judge missed.

    Yields as ``cool_and_settle`` does, and returns the least share by which the tours were over their budgets after a
    mending (inf: no other cooling is called for). What is unseen becomes dearer and the reserve smaller as it cools:
    mending takes many times the metres that a little more annealing does. Where it could not find the rest it is left
    out, and so is all that comes after it.
    """
    extra = no_points()
    problem, work = context.problem, context.work
    reach_m = problem.reach_m
    least_over = math.inf
    near = CLOSE if work.chances == 1 else LUCK  # who has other chances does not hang on to a poor one
    bends = can_polish(problem)
    stages = [*LAST_STAGES, *(later_stage(work, turn) for turn in range(1, work.coolings))]
    for turn, stage in enumerate(stages):
        unseen = work.cooled_unseen if turn and bends else UNSEEN
        if context.should_stop() or search.unseen_share > unseen or search.over_budget_share > OVER:
            break
        search = annealed(
            context, search.tours, extra,
            heat_m=max(stage.heat, COOLEST) * reach_m, moves=work.cooling_moves, seed=seed + 1 + turn, stage=stage,
        )  # fmt: skip
        if turn + 1 < len(LAST_STAGES):
            continue
        tours = shortened(context, search.tours, extra)
        if bends and over_budget_share(tours) > work.bent_over:
            break
        found = settle(context, tours, extra, may_add=False, rounds=work.repairs, annealed=True)
        if found.met and found.fits:
            yield found
            return math.inf
        yield None
        over = over_budget_share(found.tours)
        if over > OVER:
            break
        if found.fits and not len(found.verdict.unmet_points_m):
            return math.inf  # all is seen in time, but bodies meet: they would on any tour much like this
        if over > max(GAINING * least_over, near):
            break
        least_over, extra = min(over, least_over), found.extra
    return least_over


def later_stage(work: Work, turn: int) -> Stage:
    """The stage before the mending of number ``turn``, from 1 on, which begins from mended tours."""
    return Stage(work.later_heat / 2**turn, work.later_dear, LAST_RESERVE / 2**turn)


def shortened(context: Context, tours: list[Tour], extra: SamplePoints) -> list[Tour]:
    """The tours as short as they can be bent while they see as much, so that mending has most to spend."""
    problem = context.problem
    if not can_polish(problem) or over_budget_share(tours, TIGHT) == 0:
        return tours
    _, samples = prepared_with(problem, extra)
    search = Polish(as_near_as_tight(context, tours), tours, samples, length_price=PRICE)
    search.run(SHORTENING, should_stop=context.should_stop)
    return search.tours

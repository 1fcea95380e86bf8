"""Annealing from hot to cold: the shape of the tours first, then what is worth ever more to be seen, then mending."""

from __future__ import annotations

import math
import os
from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.annealing.tour import Tour, over_budget_share
from rota.planners.patrol.context import Context, Work
from rota.planners.patrol.polish.search import Polish, can_polish
from rota.planners.patrol.problem import Problem
from rota.planners.patrol.repair import TIGHT, Settled, as_near_as_tight, no_points, prepared_with, settle
from rota.planners.patrol.samples import SamplePoints
from rota.planners.patrol.start.standing import over_prices
from rota.planners.patrol.watching import searched

Floats = NDArray[np.float64]

# of a metre of the slowest tour, of any metre at most, of a metre over budget; unseen ground costs UNSEEN_WEIGHT
PRICE, MOST_PRICE, OVER_PRICE = 0.3, 0.8, 4.0
RESERVE = 0.03  # share of the budgets left for the mending while most of the tour's shape is found
UNSEEN, OVER = 0.015, 0.03  # shares of the ground and of the budgets that mending and cooler annealing may still gain
HALFWAY = 0.033  # share of the ground unseen after half of the moves, of which the others bring down half at best
COOLEST = 1 / 32  # of the reach: heat of the last annealings
LAST_RESERVE = 0.0075  # of annealings that begin from mended tours
GAINING = 0.8  # of what tours are over budget after the last mending: more, and they will not come within it
CLOSE = 0.006  # share of the budgets that another annealing gains or not, as luck has it
LUCK = 0.002  # the same of all annealings from cold on: as much nearer may they come with other seeds
SEEDS_APART = 10  # the annealings of one cooling take seeds of their own
SHORTENING = 40  # steps of linear programs before the first mending
CORNERS_A_REACH = 2.0  # of ideal tours: on ragged ground no more count
COARSE = 0.167  # of the reach: spacing of samples while most of the tours' shape is found, where they are dense


class Stage(NamedTuple):
    """Of an annealing: its heat, of the reach; how many times more than usual it is worth to see anything; the reserve.

    The heat is that of its beginning.
    """

    heat: float
    dear: float
    reserve: float


LAST_STAGES = (Stage(1 / 4, 3.0, 0.01), Stage(1 / 16, 12.0, 0.005))  # before the first mending


def annealed_all(context: Context, begun: list[list[Tour]], *, moves: int, seed: int, coarse: bool) -> list[Annealing]:
    """Each of the splits after annealing, in their order, whatever the number of threads."""
    heat_m = context.problem.reach_m / 2
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        jobs = [
            pool.submit(annealed, context, tours, no_points(), heat_m=heat_m, moves=moves, seed=seed + i, coarse=coarse)
            for i, tours in enumerate(begun)
        ]
        return [job.result() for job in jobs]


def shaped(context: Context, tours: list[Tour], *, seed: int) -> Annealing:
    """The search that finds the shape of the tours; what comes after it makes little of that anew."""
    work, heat_m = context.work, context.problem.reach_m / 2
    return annealed(
        context, tours, no_points(), heat_m=heat_m, moves=work.moves, seed=seed, halfway=HALFWAY, coarse=True
    )


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


def annealed(
    context: Context,
    tours: list[Tour],
    extra: SamplePoints,
    *,
    heat_m: float,
    moves: int,
    seed: int,
    stage: Stage | None = None,
    halfway: float = math.inf,
    coarse: bool = False,
) -> Annealing:
    """The search after annealing: everything seen if it can be, within the budgets if it can be, then short.

    stage: how many times more than usual it is worth to see anything, for corners are not worth their detours
    otherwise, and the reserve (None: as the context says, and ``RESERVE``). halfway: the share of the ground that may
    be unseen after half of the moves; with more the others are not made. coarse: with a quarter of the samples, where
    they are dense, and twice the moves, which then take the same time.
    """
    dear = context.dear if stage is None else max(context.dear, stage.dear)
    problem = context.problem
    coarse = coarse and can_be_thinned(problem)
    points, samples = prepared_with(problem, extra, coarse=coarse)
    search = Annealing(
        tours,
        samples._replace(weight=dear * samples.weight),
        problem.space_grid,
        price=prices(tours),
        over_price=over_prices(tours, OVER_PRICE),
        seed=seed,
        range_margin_m=problem.range_margin_m,
        reserve=RESERVE if stage is None else stage.reserve,
    )
    corners = corners_that_count(problem, tours)
    moves = min(context.work.most_moves, int((2 if coarse else 1) * moves * max(1.0, corners / 300)))
    cold_m = problem.reach_m / 200
    tell = searched(context, search, points)

    def stop() -> bool:
        hopeless = search.moves_made >= moves / 2 and search.unseen_share > halfway
        return hopeless or context.should_stop()

    search.run(moves, hot_m=heat_m, cold_m=cold_m, should_stop=stop, done=tell)
    return search


def corners_that_count(problem: Problem, tours: list[Tour]) -> float:
    """Corners of the tours, by which annealing takes more moves.

    First tours along the ragged walls of a scan have several times more than they keep: there no more count than such
    ground asks for.
    """
    corners = sum(len(tour.vertices_m) for tour in tours)
    if not problem.is_ragged:
        return corners
    ideal_m = sum(r.shape.area for r in problem.regions if r.demand == "every_point") / problem.swath_m
    return float(min(corners, CORNERS_A_REACH * ideal_m / problem.reach_m))


def can_be_thinned(problem: Problem) -> bool:
    """Whether the samples are so dense that a quarter of them shows well enough which way tours should run."""
    return problem.spacing_m <= COARSE / 2 * problem.reach_m


def prices(tours: list[Tour]) -> Floats:
    """Price (k,) of a metre of each tour: the shorter its period, the more of a robot a metre takes."""
    slowest_s = max(tour.period_s for tour in tours)
    return np.array([min(MOST_PRICE, PRICE * slowest_s / tour.period_s) for tour in tours])

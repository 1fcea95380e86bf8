"""Annealing from hot to cold: the shape of the tours first, then what is worth ever more to be seen, then mending."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.annealing.progress import searched
from rota.planners.patrol.annealing.search import Annealing, over_prices
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepared_with
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]

# of a metre of the slowest tour, of any metre at most, of a metre over budget; unseen ground costs UNSEEN_WEIGHT
PRICE, MOST_PRICE, OVER_PRICE = 0.3, 0.8, 4.0
RESERVE = 0.03  # share of the budgets left for the mending while most of the tour's shape is found
UNSEEN, OVER = 0.015, 0.03  # shares of the ground and of the budgets that mending and cooler annealing may still gain
HALFWAY = 0.033  # share of the ground unseen after half of the moves, of which the others bring down half at best
CORNERS_A_REACH = 2.0  # of ideal tours: on ragged ground no more count
COARSE = 0.167  # of the reach: spacing of samples while most of the tours' shape is found, where they are dense


class Stage(NamedTuple):
    """Of an annealing: its heat, of the reach; how many times more than usual it is worth to see anything; the reserve.

    The heat is that of its beginning.
    """

    heat: float
    dear: float
    reserve: float


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
        problem.paths.grid,
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

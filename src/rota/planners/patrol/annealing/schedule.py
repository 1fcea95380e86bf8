"""Annealing from hot to cold, of one set of tours or of several side by side."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from rota.model.arrays import Floats
from rota.planners.patrol.annealing.search import Annealed, Annealing, budget_penalties
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.settings import Stage
from rota.planners.patrol.tours.tour import Tour
from rota.planning.progress import SearchState


def anneal_all(context: Context, begun: list[list[Tour]], *, moves: int, seed: int, coarse: bool) -> list[Annealed]:
    """The annealings that begin with each of these sets of tours, in their order, on any number of threads."""
    with ThreadPoolExecutor(max_workers=context.threads) as pool:
        jobs = [
            pool.submit(context.run, anneal_tours, tours, no_points(), moves=moves, seed=seed + i, coarse=coarse)
            for i, tours in enumerate(begun)
        ]
        return [job.result() for job in jobs]


def anneal_shape(context: Context, tours: list[Tour], *, seed: int) -> Annealed:
    """The full annealing that finds the shape of the tours; later stages change little of it.

    It ends if half of its moves leave 3.3 % of the ground unseen: what it misses then takes more than repairs have.
    """
    settings = context.settings.annealing
    return anneal_tours(
        context, tours, no_points(), moves=settings.moves, seed=seed,
        halfway_unseen_limit=0.033, coarse=True,
    )  # fmt: skip


def anneal_tours(
    context: Context,
    tours: list[Tour],
    extra: SamplePoints,
    *,
    moves: int,
    seed: int,
    stage: Stage | None = None,
    halfway_unseen_limit: float = math.inf,
    coarse: bool = False,
) -> Annealed:
    """One annealing: everything seen if it can be, within the budgets if it can be, then short.

    stage: its heat, weight of seeing and reserve; None: hot, with the context's weight and a reserve for repairs.
    halfway_unseen_limit: it ends if half of the moves leave a larger share of the ground unseen.
    coarse: a quarter of the samples where a sixth of the reach then lies between them at most, and twice the moves,
        which then take the same time.
    """
    problem, settings = context.problem, context.settings.annealing
    stage = stage or Stage(1 / 2, context.coverage_weight, 0.03)
    coarse = coarse and problem.spacing_m <= 0.0835 * problem.reach_m
    points, samples = prepare_with(problem, extra, coarse=coarse)
    search = Annealing(
        tours,
        samples._replace(weight=max(context.coverage_weight, stage.coverage_weight) * samples.weight),
        problem.paths.grid,
        length_weight=length_weights(tours),
        budget_penalty=budget_penalties(tours, 4.0),  # more than a metre costs in any tour
        seed=seed,
        range_margin_m=problem.range_margin_m,
        reserve=stage.reserve,
    )
    moves = min(settings.most_moves, int((2 if coarse else 1) * moves * share_of_moves(context, tours)))

    def stop() -> bool:
        misses_much = search.moves_made >= moves / 2 and search.unseen_share > halfway_unseen_limit
        return misses_much or context.should_stop()

    search.run(
        moves, hot_m=stage.heat * problem.reach_m, cold_m=problem.reach_m / 200,
        should_stop=stop, done=progress_teller(context, search, points),
    )  # fmt: skip
    return search.annealed


def share_of_moves(context: Context, tours: list[Tour]) -> float:
    """The multiple of the usual moves that these tours take: in proportion to their corners, with a least share.

    Short tours find their shape in few moves, and another seed then gains more than other moves do. Not so those of
    robots that turn along arcs: they are few corners far apart, whatever their length.
    """
    settings = context.settings.annealing
    least = 1.0 if context.problem.robot.turn_radius_m > 0 else settings.least_share
    return max(least, relevant_corners(context, tours) / settings.reference_corners)


def relevant_corners(context: Context, tours: list[Tour]) -> float:
    """Corners of the tours, with which annealing takes more moves.

    First tours along the ragged walls of a scan have several times more corners than they keep. There no more count
    than two in each reach of ideal tour.
    """
    problem = context.problem
    corners = sum(len(tour.vertices_m) for tour in tours)
    if not problem.is_ragged:
        return corners
    ideal_m = sum(r.shape.area for r in problem.regions if r.demand == "every_point") / problem.swath_m
    return float(min(corners, 2 * ideal_m / problem.reach_m))


def length_weights(tours: list[Tour]) -> Floats:
    """Cost (k,) of a metre of each tour: the shorter its period, the more of a robot a metre takes.

    It is 0.3 for the slowest tour, and 0.8 for any at most: a metre less is not worth what it sees.
    """
    slowest_s = max(tour.period_s for tour in tours)
    return np.minimum([0.3 * slowest_s / tour.period_s for tour in tours], 0.8)


def progress_teller(context: Context, search: Annealing, points: SamplePoints) -> Callable[[int], None]:
    """What to call after every stretch of annealing: tells how the tours then stand, if anybody watches.

    points: the samples of the search, in its order.
    """
    watch = context.watch
    if watch is None:
        return lambda moves: None
    whole_m2 = float(points.area_m2.sum())
    robots = sum(tour.robots for tour in search.tours)

    def tell(moves: int) -> None:
        """Tell the watcher how the tours stand, whatever number of moves was made."""
        unseen_m2 = float(points.area_m2[search.unseen_samples].sum())
        watch(
            SearchState(
                stage="searched",
                robots=robots,
                unseen_share=unseen_m2 / whole_m2 if whole_m2 else 0.0,
                late_share=search.over_budget_share,
            )
        )

    return tell

"""The method ``tours``: closed tours over all zones at once, with as few robots as the search finds."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.mission import Effort, Mission
from rota.plan import Plan
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.annealing.tour import Tour, over_budget_share
from rota.planners.patrol.classic.methods import METHODS
from rota.planners.patrol.classic.search import fewest_robots_of
from rota.planners.patrol.context import Context, Judge
from rota.planners.patrol.districts.search import fewest_on_large, is_large
from rota.planners.patrol.fixed_fleet import counted, worst_reached
from rota.planners.patrol.polish.search import Polish, can_polish
from rota.planners.patrol.problem import Problem, bounded_as_asked, set_up_problem
from rota.planners.patrol.proved_bound import ProvedBound
from rota.planners.patrol.repair import TIGHT, Settled, no_points, prepared_with, settle
from rota.planners.patrol.samples import SamplePoints
from rota.planners.patrol.splits import Split, Start, robots_each, splits, squeeze, starts, winding
from rota.planners.patrol.start.standing import over_prices
from rota.planners.patrol.sun2019.search import fewest_robots_by_stages
from rota.planners.patrol.watching import searched
from rota.search_state import Watch

Floats = NDArray[np.float64]

EFFORTS: tuple[Effort, ...] = ("quick", "normal", "high")
# of a metre of the slowest tour, of any metre at most, of a metre over budget; unseen ground costs UNSEEN_WEIGHT
PRICE, MOST_PRICE, OVER_PRICE = 0.3, 0.8, 4.0
RESERVE = 0.03  # share of the budgets left for the mending while most of the tour's shape is found
UNSEEN, OVER = 0.015, 0.03  # shares of the ground and of the budgets that mending and cooler annealing may still gain
HALFWAY = 0.033  # share of the ground unseen after half of the moves, of which the others bring down half at best
HOPELESS = 0.045  # share of the ground unseen after a quarter of the moves: all of them bring down a fifth of it
NEST_HOPELESS = 0.09  # the same for loops within loops, of which they bring down four fifths
COMFORT = 1.3  # budgets of the robots tried first, as a multiple of the ideal lengths
COOLEST = 1 / 32  # of the reach: heat of the last annealings
OPEN = 1.5  # first tours on open ground are at most so many times longer than ideal
COOL, DEAR, LAST_RESERVE = 1 / 8, 6.0, 0.0075  # of annealings that begin from mended tours
GAINING = 0.8  # of what tours are over budget after the last mending: more, and they will not come within it
CLOSE = 0.006  # share of the budgets that another annealing gains or not, as luck has it
SHORTENING = 40  # steps of linear programs before the first mending
SCREENING = 50_000  # moves that all splits get before the best of them get all
COARSE = 0.167  # of the reach: spacing of samples while most of the tours' shape is found, where they are dense
NEST_GAIN = 0.8  # what loops within loops lack then, over what others lack that come as far in the end


class Stage(NamedTuple):
    """Of an annealing: its heat, of the reach; how many times more than usual it is worth to see anything; the reserve.

    The heat is that of its beginning.
    """

    heat: float
    dear: float
    reserve: float


LAST_STAGES = (Stage(1 / 4, 3.0, 0.01), Stage(1 / 16, 12.0, 0.005))  # before the first mending


def plan_patrol(
    mission: Mission,
    *,
    asked: Mission,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: Watch | None = None,
) -> Plan:
    """A plan of closed tours that the judge passes, with as few robots as the mission's method finds within the effort.

    asked: the mission with its starts and before any reserve: the bound is proved for it, and a fixed fleet's spare
    robots go where their starts are. judge: the verdict on a plan. progress: told a share in 0..1 and what is going
    on. should_stop: polled often; once true the best plan so far is returned. watch: told of every state on the way,
    from several threads. Raises NoPlanFound, with the best plan found, when the demand is not met.
    """
    progress(0.0, "looking at the mission")
    problem = bounded_as_asked(set_up_problem(mission), asked)
    context = Context(problem=problem, seed=seed, judge=judge, progress=progress, should_stop=should_stop, watch=watch)
    if mission.fleet.robots is not None:
        from rota.planners.patrol.worst_ratio import plan_with_least_ratio  # it searches with this module's loops

        return plan_with_least_ratio(context, asked)
    best = fewest_by_method(context)
    if not best.met:
        raise NoPlanFound(unmet_reason(problem, best), best=best.plan)
    return best.plan


def fewest_by_method(context: Context) -> Settled:
    """The best settled plan that the method of the mission's settings finds."""
    method = context.problem.mission.patrol.method
    if method == "sun2019":
        return fewest_robots_by_stages(context)
    if method != "tours":
        return fewest_robots_of(METHODS[method], context)
    return fewest_on_large(context, fewest_robots) if is_large(context.problem) else fewest_robots(context)


def unmet_reason(problem: Problem, best: Settled) -> str:
    """Why the best plan is none: the demand it misses most, by how much, and the proved bound."""
    reached = worst_reached(best.verdict)
    return (
        f"the best plan found, with {counted(len(best.plan.trajectories))}, does not meet the demand: {reached};"
        f" proved: at least {counted(problem.lower_bound)}: {problem.lower_bound_reason}"
    )


def fewest_robots(context: Context) -> Settled:
    """The settled plan with the fewest robots found (met unless all repair failed).

    Every effort begins with what the lesser ones find and looks for fewer: more effort never takes more robots.
    """
    asked = context.problem.mission
    efforts = EFFORTS[: EFFORTS.index(asked.patrol.effort) + 1]
    best = None
    for turn, effort in enumerate(efforts):
        here = context if effort == asked.patrol.effort else with_less_effort(context, effort)
        best = with_fewer(replace(here, progress=part_of(context.progress, turn, len(efforts))), best)
        if context.should_stop() or (best.met and robots_of(best) <= context.problem.enough_robots):
            break
    assert best is not None
    return best if best.plan.mission is asked else replace(best, plan=replace(best.plan, mission=asked))


def with_less_effort(context: Context, effort: Effort) -> Context:
    """The same search with less effort: a coarser lattice, less work, the same bound."""
    problem = context.problem
    bound = ProvedBound(robots=problem.lower_bound, reason=problem.lower_bound_reason)
    coarse = set_up_problem(problem.mission.with_effort(effort), bound=bound)
    return replace(context, problem=replace(coarse, enough_robots=problem.enough_robots))


def part_of(progress: Callable[[float, str], None], turn: int, turns: int) -> Callable[[float, str], None]:
    """Progress told within one of so many turns."""
    return lambda share, what: progress((turn + share) / turns, what)


def robots_of(settled: Settled) -> int:
    """The robots of all its tours."""
    return sum(tour.robots for tour in settled.tours)


def with_fewer(context: Context, best: Settled | None) -> Settled:
    """The settled plan with the fewest robots found, the best one given if none has fewer.

    Begins with a number that should be comfortable and goes up until a plan is met; or, when the first one was, down
    one by one until none is, no further than the proved bound.
    """
    problem, work = context.problem, context.work
    ways = starts(problem, work.groupings)
    context = replace(context, dear=worth_of_seeing(ways))
    comfortable = max(problem.enough_robots, min(fewest_with_room(ways, COMFORT), surely_enough(ways)))
    if best is None or not best.met or robots_of(best) > comfortable + 1:
        best = comfortably(context, ways, comfortable, best)
        if robots_of(best) > comfortable:
            return best  # fewer were tried on the way up
    robots = first = robots_of(best)
    least = problem.enough_robots
    while best.met and robots > least and not context.should_stop():
        robots -= 1
        share = (first - robots) / (first - least)
        context.progress(0.4 + 0.5 * share, f"trying {robots} robots")
        found = with_so_many(context, ways, robots, least_squeeze=work.least_squeeze)
        if found is None or robots_of(found) >= robots_of(best):
            break  # mending may post robots of their own
        best = found
    return best


def worth_of_seeing(ways: list[Start]) -> float:
    """How many times more than on open ground it is worth to see anything: the more, the more the ways wind."""
    return min(DEAR, max(1.0, winding(ways) / OPEN))


def comfortably(context: Context, ways: list[Start], robots: int, best: Settled | None) -> Settled:
    """A plan with so many robots or more, fewer than the best has; else the best; else as many as surely do.

    After some numbers tried one by one, the steps are an eighth.
    """
    fewest, most = robots, surely_enough(ways)
    turn = 0
    while turn < context.work.tries or robots < most:
        if best is not None and best.met and robots >= robots_of(best):
            return best
        context.progress(0.1 + 0.3 * (robots - fewest) / max(most, robots + 1 - fewest), f"trying {robots} robots")
        found = with_so_many(context, ways, robots, least_squeeze=1.0)
        if found is not None:
            return found
        if context.should_stop():
            break
        turn += 1
        robots += 1 if turn < context.work.tries else max(1, robots // 8)
    if best is not None and best.met:
        return best
    context.progress(0.4, "finishing with the robots that surely suffice")
    return settle(context, ways[0].tours, no_points(), may_add=True, rounds=3 * context.work.repairs)


def fewest_with_room(ways: list[Start], room: float) -> int:
    """The fewest robots with which the budgets of some way are so many times the ideal lengths."""
    robots = min(len(way.tours) for way in ways)
    while not any(
        counts is not None and squeeze(way, counts) >= room
        for way, counts in ((way, robots_each(way, robots)) for way in ways)
    ):
        robots += 1
    return robots


def surely_enough(ways: list[Start]) -> int:
    """The fewest robots that the first tours of some way need as they are."""
    return min(sum(tour.robots for tour in way.tours) for way in ways)


def with_so_many(context: Context, ways: list[Start], robots: int, *, least_squeeze: float) -> Settled | None:
    """A plan with so many robots that the judge passes, or None.

    All splits are annealed a little; then the most promising ones in full, as many at a time as there are cores. Of
    those that pass, the most promising one is taken, whichever was ready first.
    """
    begun = promising(context, splits(context.problem, ways, robots, least_squeeze), seed=context.seed + 1000 * robots)
    passed = [False] * context.work.tries

    def settled(turn: int) -> Settled | None:
        here = replace(context, should_stop=lambda: context.should_stop() or any(passed[:turn]))
        found = anneal_and_settle(here, begun[turn], seed=context.seed + 1000 * robots + 100 * turn)
        passed[turn] = found is not None
        return found

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for found in pool.map(settled, range(min(len(begun), context.work.tries))):
            if found is not None:
                return found
    return None


def promising(context: Context, begun: list[Split], *, seed: int) -> list[list[Tour]]:
    """The tours of the splits after a little annealing, the least shortfall first; none of those without hope.

    Loops within loops take longer to find their shape.
    """
    if len(begun) < 2:
        return [split.tours for split in begun]
    some = (context.work.screened + 1) // 2
    begun = [
        *[split for split in begun if not split.nests][:some],
        *[split for split in begun if split.nests][:some],
    ]
    searches = annealed_all(context, [split.tours for split in begun], moves=SCREENING, seed=seed)
    ranked = []
    for split, search in zip(begun, searches, strict=True):
        if search.unseen_share <= (NEST_HOPELESS if split.nests else HOPELESS):
            ranked.append(((NEST_GAIN if split.nests else 1.0) * search.shortfall_m, search.tours))
    return [tours for _, tours in sorted(ranked, key=lambda one: one[0])]


def annealed_all(context: Context, begun: list[list[Tour]], *, moves: int, seed: int) -> list[Annealing]:
    """Each of the splits after annealing, in their order, whatever the number of threads."""
    heat_m = context.problem.reach_m / 2
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        jobs = [
            pool.submit(annealed, context, tours, no_points(), heat_m=heat_m, moves=moves, seed=seed + i)
            for i, tours in enumerate(begun)
        ]
        return [job.result() for job in jobs]


def anneal_and_settle(context: Context, tours: list[Tour], *, seed: int) -> Settled | None:
    """Anneal, then mend; while that fails narrowly, anneal again from there, cooler, knowing what the judge missed.

    The settled plan if the judge passed it within the budgets. What is unseen becomes dearer and the reserve smaller as
    it cools: mending takes many times the metres that a little more annealing does.
    """
    extra = no_points()
    problem, work = context.problem, context.work
    reach_m = problem.reach_m
    search = annealed(
        context, tours, extra, heat_m=reach_m / 2, moves=work.moves, seed=seed, halfway=HALFWAY, coarse=True
    )
    least_over = math.inf
    stages = [*LAST_STAGES, *(Stage(COOL / 2**turn, DEAR, LAST_RESERVE / 2**turn) for turn in range(1, work.coolings))]
    for turn, stage in enumerate(stages):
        if search.unseen_share > UNSEEN or search.over_budget_share > OVER:
            break
        search = annealed(
            context, search.tours, extra,
            heat_m=max(stage.heat, COOLEST) * reach_m, moves=work.moves // 2, seed=seed + 1 + turn, stage=stage,
        )  # fmt: skip
        if turn + 1 < len(LAST_STAGES):
            continue
        tours = shortened(context, search.tours, extra)
        found = settle(context, tours, extra, may_add=False, rounds=work.repairs, annealed=True)
        if found.met and found.fits:
            return found
        if context.should_stop() or over_budget_share(found.tours) > OVER:
            break
        if found.fits and not len(found.verdict.unmet_points_m):
            break  # everything is seen in time, but bodies meet: they would on any tour much like this
        over = over_budget_share(found.tours)
        if over > max(GAINING * least_over, CLOSE):
            break
        least_over, extra = over, found.extra
    return None


def shortened(context: Context, tours: list[Tour], extra: SamplePoints) -> list[Tour]:
    """The tours as short as they can be bent while they see as much, so that mending has most to spend."""
    problem = context.problem
    if not can_polish(problem) or over_budget_share(tours, TIGHT) == 0:
        return tours
    _, samples = prepared_with(problem, extra)
    search = Polish(problem, tours, samples, length_price=PRICE)
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
    corners = sum(len(tour.vertices_m) for tour in tours)
    moves = min(context.work.most_moves, int((2 if coarse else 1) * moves * max(1.0, corners / 300)))
    cold_m = problem.reach_m / 200
    tell = searched(context, search, points)

    def stop() -> bool:
        hopeless = search.moves_made >= moves / 2 and search.unseen_share > halfway
        return hopeless or context.should_stop()

    search.run(moves, hot_m=heat_m, cold_m=cold_m, should_stop=stop, done=tell)
    return search


def can_be_thinned(problem: Problem) -> bool:
    """Whether the samples are so dense that a quarter of them shows well enough which way tours should run."""
    return problem.spacing_m <= COARSE / 2 * problem.reach_m


def prices(tours: list[Tour]) -> Floats:
    """Price (k,) of a metre of each tour: the shorter its period, the more of a robot a metre takes."""
    slowest_s = max(tour.period_s for tour in tours)
    return np.array([min(MOST_PRICE, PRICE * slowest_s / tour.period_s) for tour in tours])

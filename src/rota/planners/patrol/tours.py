"""The method ``tours``: closed tours over all zones at once, with as few robots as the search finds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.mission import Effort, Mission
from rota.plan import Plan
from rota.planners.patrol.annealing.search import Annealing, Tour, tour_length_m
from rota.planners.patrol.classic.search import fewest_robots_of
from rota.planners.patrol.context import Context, Judge
from rota.planners.patrol.fixed_fleet import plan_for_fixed_fleet
from rota.planners.patrol.problem import Problem, set_up_problem
from rota.planners.patrol.repair import Settled, no_points, prepared_with, settle
from rota.planners.patrol.samples import SamplePoints
from rota.planners.patrol.start.first_tours import class_groups, first_tours, with_robots_needed

Floats = NDArray[np.float64]

GROUPINGS = 2  # ways to group the period classes that are tried
HOLDS_MUCH = 0.15  # footprint over what is swept in the shortest period
FRUGAL = 0.62  # robots of their own, as a share of those of a shared tour, to begin with
# of a metre of the slowest tour, of any metre at most, of a metre over budget; unseen ground costs UNSEEN_WEIGHT
PRICE, MOST_PRICE, OVER_PRICE = 0.3, 1.5, 4.0
RESERVE = 0.03  # share of the budgets left for the mending
NARROW = 0.03  # share of the ground, and of the budgets, that mending and cooler annealing may still gain
# travel of the tightest plan worth a try, as a multiple of area / swath
SQUEEZE: dict[Effort, float] = {"quick": 1.3, "normal": 1.2, "high": 1.1}


def plan_patrol(
    mission: Mission,
    *,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
) -> Plan:
    """A plan of closed tours that the judge passes, with as few robots as the mission's method finds within the effort.

    judge: the verdict on a plan. progress: told a share in 0..1 and what is going on. should_stop: polled often; once
    true the best plan so far is returned. Raises NoPlanFound, with the best plan found, when the demand is not met.
    """
    progress(0.0, "looking at the mission")
    problem = set_up_problem(mission)
    context = Context(problem=problem, seed=seed, judge=judge, progress=progress, should_stop=should_stop)
    if mission.fleet.robots is not None:
        free = replace(mission, fleet=replace(mission.fleet, robots=None))
        as_many = replace(context, problem=replace(problem, mission=free))
        return plan_for_fixed_fleet(context, fewest_by_method(as_many))
    best = fewest_by_method(context)
    if not best.met:
        raise NoPlanFound(unmet_reason(problem, best), best=best.plan)
    return best.plan


def fewest_by_method(context: Context) -> Settled:
    """The best settled plan that the method of the mission's settings finds."""
    method = context.problem.mission.planning.method
    return fewest_robots(context) if method == "tours" else fewest_robots_of(method, context)


def unmet_reason(problem: Problem, best: Settled) -> str:
    """Why the best plan is none: the worst demand and the proved bound."""
    worst = max(best.verdict.demands, key=lambda demand: demand.worst_gap_s / demand.period_s)
    ratio = worst.worst_gap_s / worst.period_s
    reached = "some of it is never seen" if math.isinf(ratio) else f"the worst gap is {ratio:.3f} of its period"
    what = f"zone {worst.name}" if worst.name != "area" else "the area"
    if ratio <= 1:
        what, reached = "the check", "it finds the routes themselves at fault"
    return (
        f"the best plan, with {len(best.plan.trajectories)} robots, does not meet the demand: {what}: {reached};"
        f" proved: {problem.lower_bound} robots at least"
    )


def fewest_robots(context: Context) -> Settled:
    """Search downwards from tours that surely suffice; the best settled plan (met unless all repair failed)."""
    problem = context.problem
    best: Settled | None = None
    extra = no_points()
    variants = starts(problem)
    for turn, (groups, separate) in enumerate(variants):
        if (
            best is not None
            and best.met
            and (context.should_stop() or len(best.plan.trajectories) <= problem.lower_bound)
        ):
            break
        frugal = FRUGAL if best is not None and best.met else 1.0
        start = first_tours(problem, groups, separate=separate, frugal=frugal)
        context.progress(0.1 + 0.8 * turn / len(variants), f"{sum(t.robots for t in start)} robots suffice")
        hopes = hoped_robots(problem, start)
        goal = [replace(tour, robots=1 if separate else hope) for tour, hope in zip(start, hopes, strict=True)]
        found = reduce_robots(context, start, goal, extra, best)
        if found is not None and (best is None or better(found, best)):
            best = found
            extra = found.extra
    if best is None:
        raise NoPlanFound("the search found no tours at all")
    return best


def starts(problem: Problem) -> list[tuple[tuple[tuple[int, ...], ...], bool]]:
    """What the search begins with, one after the other: groups of period classes, and whether robots keep apart.

    Keeping apart is worth a try for bodies, and where a robot holds much of what it sweeps in a period.
    """
    groups = list(class_groups(problem))[:GROUPINGS]
    shared = [(group, False) for group in groups]
    swept_m = problem.robot.speed_m_s * problem.periods_s[0]
    if problem.robot.body_radius_m > 0 or math.pi * problem.reach_m > HOLDS_MUCH * 2 * swept_m:
        shared.insert(1, (groups[0], True))
    return shared


def better(one: Settled, other: Settled) -> bool:
    """Whether one plan is to be preferred: met first, then fewer robots, then less travel."""

    def rank(settled: Settled) -> tuple[bool, int, float]:
        return (not settled.met, len(settled.plan.trajectories), sum(tour_length_m(t) for t in settled.tours))

    return rank(one) < rank(other)


def hoped_robots(problem: Problem, tours: list[Tour]) -> list[int]:
    """Robots per tour for a first try: annealing shortens a first tour by a fifth, or to little above the ideal."""
    ideal = ideal_shares(problem, tours)
    shares = [tour_length_m(tour) / replace(tour, robots=1).budget_m for tour in tours]
    return [max(1, math.ceil(min(0.8 * share, 1.3 * best))) for share, best in zip(shares, ideal, strict=True)]


def ideal_shares(problem: Problem, tours: list[Tour]) -> list[float]:
    """Robots that each tour would need if it swept its ground in perfect lanes.

    A tour's ground: what asks for its period or a longer one, up to the next longer period of a tour; shared among the
    tours of one period in proportion to their lengths.
    """
    served = sorted({tour.serves for tour in tours})
    swept_m2_s = problem.swath_m * problem.robot.speed_m_s
    found = []
    for tour in tours:
        later = [c for c in served if c > tour.serves]
        classes = range(tour.serves, min(later, default=len(problem.periods_s)))
        ground_m2 = sum(
            region.shape.area
            for region, c in zip(problem.regions, problem.region_class, strict=True)
            if c in classes and region.demand == "every_point"
        )
        alike_m = sum(tour_length_m(other) for other in tours if other.serves == tour.serves)
        part = tour_length_m(tour) / alike_m if alike_m > 0 else 1.0
        found.append(part * ground_m2 / (swept_m2_s * tour.period_s))
    return found


def reduce_robots(
    context: Context, start: list[Tour], goal: list[Tour], extra: SamplePoints, incumbent: Settled | None
) -> Settled | None:
    """Anneal for the hoped numbers of robots; add one where a tour outgrows its budget, take one where slack allows."""
    work = context.work
    best: Settled | None = None
    tried: set[tuple[int, ...]] = set()
    tours = goal
    for turn in range(work.tries):
        robots = tuple(tour.robots for tour in tours)
        if robots in tried or context.should_stop():
            break
        tried.add(robots)
        rival = best or incumbent
        if rival is not None and rival.met and sum(robots) >= len(rival.plan.trajectories):
            break
        context.progress(0.1 + 0.8 * turn / work.tries, f"trying {sum(robots)} robots")
        tours, extra, found = anneal_and_settle(context, tours, extra, seed=context.seed + 1000 * turn)
        if found is not None and (best is None or better(found, best)):
            best = found
            smaller = one_robot_fewer(context.problem, found.tours)
            if smaller is None:
                break
            tours = smaller
        elif best is not None:
            break
        else:
            tours = one_robot_more(tours)
    if best is None and (incumbent is None or not incumbent.met):
        context.progress(0.9, "finishing with the robots that surely suffice")
        tours = [with_robots_needed(tour) for tour in (tours if tried else start)]
        best = settle(context, tours, extra, may_add=True, rounds=3 * work.repairs)
    return best


def anneal_and_settle(
    context: Context, tours: list[Tour], extra: SamplePoints, *, seed: int
) -> tuple[list[Tour], SamplePoints, Settled | None]:
    """Anneal, then mend; while that fails narrowly, anneal again from there, cooler, knowing what the judge missed.

    The tours, the points known in the end, and the settled plan if the judge passed it within the budgets.
    """
    reach_m, moves = context.problem.reach_m, context.work.moves
    heat_m = reach_m / 2
    while True:
        search = annealed(context, tours, extra, heat_m=heat_m, moves=moves, seed=seed)
        tours = search.tours
        near = search.unseen_share < NARROW and search.over_budget_share < NARROW
        if near:
            found = settle(context, tours, extra, may_add=False, rounds=context.work.repairs)
            tours, extra = found.tours, found.extra
            if found.met and found.fits:
                return tours, extra, found
        if heat_m < reach_m / 16 or not near or context.should_stop():
            return tours, extra, None
        heat_m, moves, seed = heat_m / 2, moves // 2, seed + 1


def annealed(
    context: Context, tours: list[Tour], extra: SamplePoints, *, heat_m: float, moves: int, seed: int
) -> Annealing:
    """The search after annealing: everything seen if it can be, within the budgets if it can be, then short."""
    problem = context.problem
    _, samples = prepared_with(problem, extra)
    search = Annealing(
        tours,
        samples,
        problem.space_grid,
        price=prices(tours),
        over_price=np.full(len(tours), OVER_PRICE),
        seed=seed,
        range_margin_m=problem.range_margin_m,
        reserve=RESERVE,
    )
    corners = sum(len(tour.vertices_m) for tour in tours)
    moves = min(context.work.most_moves, int(moves * max(1.0, corners / 300)))
    cold_m = problem.reach_m / 200
    search.run(moves, hot_m=heat_m, cold_m=cold_m, should_stop=context.should_stop)
    return search


def prices(tours: list[Tour]) -> Floats:
    """Price (k,) of a metre of each tour: the shorter its period, the more of a robot a metre takes."""
    slowest_s = max(tour.period_s for tour in tours)
    return np.array([min(MOST_PRICE, PRICE * slowest_s / tour.period_s) for tour in tours])


def one_robot_fewer(problem: Problem, tours: list[Tour]) -> list[Tour] | None:
    """The tours with one robot fewer where that asks least; None when it asks too much or the bound is reached.

    A tour's last robot may go when a tour of the same part can serve its points.
    """
    robots = sum(tour.robots for tour in tours)
    if robots <= problem.enough_robots or problem.ideal_robots * SQUEEZE[problem.mission.planning.effort] > robots - 1:
        return None
    ideal = ideal_shares(problem, tours)

    def asked(k: int) -> float:
        alone = all(i == k or t.part != tours[k].part or t.serves > tours[k].serves for i, t in enumerate(tours))
        return math.inf if tours[k].robots == 1 and alone else ideal[k] - (tours[k].robots - 1)

    k = min(range(len(tours)), key=asked)
    if not math.isfinite(asked(k)):
        return None
    if tours[k].robots > 1:
        return [*tours[:k], replace(tours[k], robots=tours[k].robots - 1), *tours[k + 1 :]]
    return [*tours[:k], *tours[k + 1 :]]


def one_robot_more(tours: list[Tour]) -> list[Tour]:
    """The tours with one robot more where the budget is fullest."""
    k = max(range(len(tours)), key=lambda i: tour_length_m(tours[i]) / tours[i].budget_m)
    return [*tours[:k], replace(tours[k], robots=tours[k].robots + 1), *tours[k + 1 :]]

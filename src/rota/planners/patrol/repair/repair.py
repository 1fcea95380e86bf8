"""From tours that see all samples to a plan that the check passes: what it finds unmet becomes samples too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.plan import Plan
from rota.planners.patrol.annealing.search import Annealing, over_prices
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepared_with
from rota.planners.patrol.ground.finer_space import with_room_to_see
from rota.planners.patrol.ground.limits_of_sight import drawn_to_border, with_reach_for
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import Problem, stretched
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, joined, points_of
from rota.planners.patrol.repair.bending.search import Polish, can_polish
from rota.planners.patrol.repair.detours import ON_ROUTE_M, led_past, nearby_place, visit_places
from rota.planners.patrol.tours.timetable import as_trajectories
from rota.planners.patrol.tours.tour import Tour, driven, over_budget_share, tour_length_m
from rota.planners.patrol.traffic.bodies.reroutes import rerouted
from rota.planners.patrol.traffic.bodies.timing import timed_rounds
from rota.planners.patrol.verdict import Verdict

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

OVER_PRICE = 6.0  # of a metre over budget
DEAR = 20.0  # times what a sample is worth, while tours are tightened
TIGHTER = 0.01  # share of the budgets to which they are tightened below them
MOST_NEW_POINTS = 1_500
MOST_STUCK = 4  # rounds in which the judge's complaints stay as many
ROOMY_BEND = 0.02  # of the reach: how much farther than to what is missed tours are bent
CREEP, TIGHT_CREEP = 0.25, 0.03  # of the range margin: how much farther in every round
TIGHT = 0.02  # share of the budgets: tours that leave less of theirs are tight
POLISHING = 25  # steps of linear programs in one round
ROUNDING = 1e-6  # share of the budgets that sums of many legs may be off
MOST_REROUTES = 3  # for the sake of bodies
MOST_VISITS = 12  # places that are gone to in one round for the sake of stubborn points


@dataclass(frozen=True, kw_only=True)
class Settled:
    """Tours whose plan was judged; ``extra`` are the points that the judge's complaints added on the way."""

    tours: list[Tour]
    plan: Plan
    verdict: Verdict
    extra: SamplePoints

    @property
    def fits(self) -> bool:
        """Whether every tour keeps within its budget."""
        return over_budget_share(self.tours) == 0

    @property
    def met(self) -> bool:
        """Whether the plan passed."""
        return self.verdict.verdict == "met"


def plan_of(problem: Problem, tours: Sequence[Tour], *, seed: int, bound: ProvedBound | None = None) -> Plan:
    """The plan that drives these tours, with the bound; the fleet's names for robots, or robot-1, robot-2, ..."""
    rounds = timed_rounds(driven(tours), problem.robot.body_radius_m)
    fleet = problem.mission.fleet.robots
    names = [r.name for r in fleet] if fleet else [f"robot-{i + 1}" for i in range(len(rounds))]
    return Plan(
        mission=problem.mission,
        trajectories=as_trajectories(rounds, names[: len(rounds)]),
        seed=seed,
        lower_bound_robots=None if bound is None else bound.robots,
        lower_bound_reason=None if bound is None else bound.reason,
    )


def settle(
    context: Context,
    tours: list[Tour],
    extra: SamplePoints,
    *,
    may_add: bool,
    rounds: int,
    annealed: bool = False,
) -> Settled:
    """Mend the tours until the judge passes their plan, they outgrow their budgets, or ``rounds`` are over.

    With ``may_add`` a tour that outgrows its budget gets another robot. annealed: the tours see nearly everything and
    are about as short as they can be, so that linear programs find the rest. Returns the last state.
    """
    problem = context.problem
    polishes = annealed and can_polish(problem)
    turn, stuck, reroutes = 0, 0, 0
    complaints = -1
    while True:
        points, samples = prepared_with(problem, extra)
        if polishes:
            tours = bent(context, tours, points, samples, seed=context.seed + turn)
        else:
            tours = see_the_rest(context, tours, points, samples, seed=context.seed + turn)
        tours = drawn_to_border(
            tours, problem.border_places_m, problem.space, problem.paths,
            near_m=problem.range_margin_m, wide_m=2 * problem.spacing_m,
        )  # fmt: skip
        if may_add:
            tours = [with_robots(tour) for tour in tours]
        elif not polishes and over_budget_share(tours) > 0:
            tours = tightened(context, tours, samples, seed=context.seed + turn)
        plan = plan_of(problem, tours, seed=context.seed, bound=context.bound)
        over = over_budget_share(tours)
        mends = polishes and over <= context.work.mends_over
        # who is late by a little sees everything late: what is missed shows when there is so much more time
        shown = plan_of(stretched(problem, 1 + 2 * over), tours, seed=context.seed) if mends and over > 0 else plan
        verdict = context.judge(shown)
        turn += 1
        shorter = shorter_m(context, tours, turn, bends=polishes)
        found = new_points(problem, tours, verdict, turn, shorter_m=shorter)
        if may_add and problem.is_ragged and len(found):
            problem = with_room_to_see(problem, found.xy_m)
            context = replace(context, problem=problem)
        settled = Settled(tours=tours, plan=plan, verdict=verdict, extra=joined([extra, found]))
        stuck = stuck + 1 if len(verdict.unmet_points_m) == complaints else 0
        complaints = len(verdict.unmet_points_m)
        if settled.met or turn == rounds or stuck == MOST_STUCK or context.should_stop():
            return settled
        if not may_add and over > 0 and not mends:
            return settled
        if not len(found):
            # all is seen, but bodies touch
            apart = led_apart(problem, tours, verdict, may_add) if reroutes < MOST_REROUTES else None
            if apart is None:
                return settled
            tours, reroutes, stuck = apart, reroutes + 1, 0
            continue
        extra = settled.extra
        if stuck:
            tours = visiting_stubborn(problem, tours, found, stuck)


def visiting_stubborn(problem: Problem, tours: list[Tour], found: SamplePoints, stuck: int) -> list[Tour]:
    """The tours led to where points can be seen from nearby, nearer by each round in which they are ``stuck``.

    Every such point is seen, but no one view takes in a whole piece round it.
    """
    for i in range(min(len(found), MOST_VISITS)):
        place = nearby_place(problem, found.xy_m[i], float(found.visit_m[i]), stuck)
        if place is not None:
            tours = led_past(problem, tours, place, int(found.period[i]))
    return tours


def bent(context: Context, tours: list[Tour], points: SamplePoints, samples: Samples, *, seed: int) -> list[Tour]:
    """The tours moved as little as it takes to see all samples within the budgets, as near to that as they come."""
    problem = as_near_as_tight(context, tours)
    search = Polish(problem, tours, samples, reserve=ROUNDING)
    search.run(POLISHING, should_stop=context.should_stop)
    if context.work.mends_over > 0 and over_budget_share(search.tours) > 0:
        search.hand_over(POLISHING, should_stop=context.should_stop)
    if not search.some_far:
        return search.tours
    longer = see_the_rest(context, search.tours, points, samples, seed=seed)
    search = Polish(problem, longer, samples, reserve=ROUNDING)
    search.run(POLISHING, should_stop=context.should_stop)
    return search.tours


def as_near_as_tight(context: Context, tours: Sequence[Tour]) -> Problem:
    """The problem, with a smaller range margin where budgets are tight: what is missed then takes rounds of mending."""
    problem = context.problem
    if over_budget_share(tours, TIGHT) == 0:
        return problem
    return replace(problem, range_margin_m=context.work.tight_margin * problem.range_margin_m)


def led_apart(problem: Problem, tours: list[Tour], verdict: Verdict, may_add: bool) -> list[Tour] | None:
    """The tours led another way, so that bodies can be kept apart; None when no bodies touch, or no way was found."""
    if not any(fault.kind == "bodies touch" for fault in verdict.violations):
        return None
    return rerouted(driven(tours), problem.robot.body_radius_m, problem.space, problem.paths, may_add=may_add)


def with_robots(tour: Tour) -> Tour:
    """The tour with as many robots as its length needs, and no fewer than it has."""
    needed = math.ceil(tour_length_m(tour) / replace(tour, robots=1).budget_m)
    return replace(tour, robots=max(tour.robots, needed))


def shorter_m(context: Context, tours: Sequence[Tour], turn: int, *, bends: bool) -> float:
    """By how much less than they reach sensors are taken to reach for what was missed, the more in every round.

    bends: by linear programs, which go no further than they are asked to; one bend should close all of a sliver, not
    just the part of it round the point that was found. Tight tours are asked for little, since every metre counts, and
    for hardly more in later rounds.
    """
    problem = context.problem
    if bends and over_budget_share(tours, TIGHT) > 0:
        return context.work.tight_bend * problem.reach_m + TIGHT_CREEP * turn * problem.range_margin_m
    return (ROOMY_BEND * problem.reach_m if bends else 0.0) + CREEP * turn * problem.range_margin_m


def new_points(
    problem: Problem, tours: Sequence[Tour], verdict: Verdict, turn: int, *, shorter_m: float
) -> SamplePoints:
    """The places that the judge found unmet, as samples; of a crowd of them a few, more and nearer in every round.

    shorter_m: by how much less than they reach sensors are taken to reach for them.
    """
    by_name = {region.name: i for i, region in enumerate(problem.regions)}
    unmet_m, unmet_demand = verdict.unmet_points_m, verdict.unmet_demand
    if problem.is_ragged and len(verdict.shown_unmet_m):  # most others lie in pieces of ground that walls cut in two
        unmet_m, unmet_demand = verdict.shown_unmet_m, verdict.shown_unmet_demand
    grid_m = 0.04 * problem.reach_m * 0.6 ** (turn - 1)
    found = [no_points()]
    for k, demand in enumerate(verdict.demands):
        xy = unmet_m[unmet_demand == k]
        if demand.name not in by_name or not len(xy):
            continue
        i = by_name[demand.name]
        if problem.regions[i].demand == "visit":
            again = problem.points[problem.points.region == i]
            found.append(replace(again, area_m2=np.full(len(again), problem.swath_m**2)))
            continue
        ranges_m = np.zeros(len(xy))
        if len(problem.border_places_m):
            order, ranges_m = hardest_first(problem, tours, xy)
            xy = xy[order]
        _, first = np.unique(np.floor(xy / grid_m).astype(np.int64), axis=0, return_index=True)
        first = np.sort(first)[:: max(1, len(first) // max(MOST_NEW_POINTS, len(problem.points) // 20))]
        new = points_of(xy[first], problem.spacing_m**2, problem.region_class[i], i, shrink_m=shorter_m)
        found.append(with_reach_for(new, ranges_m[first], problem.reach_m, problem.range_margin_m))
    return joined(found)


def hardest_first(problem: Problem, tours: Sequence[Tour], xy_m: Floats) -> tuple[Ints, Floats]:
    """An order of the points (n, 2): those at the rim that the tours miss, from the outermost inwards, then the rest.

    With the range (n,) of each, in that order. Ground beyond the rim is nobody's and comes last.
    """
    places_m, ranges_m = nearest_places(xy_m, problem.space, problem.walls, problem.robot)
    at_rim = np.flatnonzero((ranges_m > problem.reach_m - problem.range_margin_m) & (ranges_m <= problem.reach_m))
    routes = shapely.union_all([shapely.linestrings(np.vstack([t.vertices_m, t.vertices_m[:1]])) for t in tours])
    missed = np.zeros(len(xy_m), dtype=bool)
    missed[at_rim] = shapely.distance(routes, shapely.points(places_m[at_rim])) > ON_ROUTE_M
    order = np.lexsort((np.where(ranges_m <= problem.reach_m, -ranges_m, np.inf), ~missed))
    return order.astype(np.int64), ranges_m[order]


def mending(problem: Problem, tours: list[Tour], samples: Samples, seed: int) -> Annealing:
    """A search that bends legs to see more: metres cost next to nothing unless they exceed a budget."""
    return Annealing(
        tours,
        samples,
        problem.paths.grid,
        price=np.full(len(tours), 0.3),
        over_price=over_prices(tours, OVER_PRICE),
        seed=seed,
        range_margin_m=problem.range_margin_m,
    )


def tightened(context: Context, tours: list[Tour], samples: Samples, *, seed: int) -> list[Tour]:
    """The tours made shorter by moves too small to lose anything that is seen: to see is dear, and there is no heat."""
    problem = context.problem
    search = Annealing(
        tours,
        samples._replace(weight=DEAR * samples.weight),
        problem.paths.grid,
        price=np.ones(len(tours)),
        over_price=over_prices(tours, OVER_PRICE),
        seed=seed,
        range_margin_m=problem.range_margin_m,
        reserve=TIGHTER,
    )
    heat_m = problem.reach_m / 1000
    search.run(context.work.cooling_moves // 2, hot_m=heat_m, cold_m=heat_m, should_stop=context.should_stop)
    return search.tours


def see_the_rest(
    context: Context, tours: list[Tour], points: SamplePoints, samples: Samples, *, seed: int
) -> list[Tour]:
    """Bend the tours a little until they see all samples; lead them by a way of their own to what is left."""
    problem = context.problem
    search = mending(problem, tours, samples, seed)
    search.mend(500 + 40 * search.unseen)
    tours = search.tours
    before = np.zeros(0, dtype=np.int64)
    for _ in range(5):
        unseen = search.unseen_samples
        if np.array_equal(unseen, before):
            break  # none is left, or what is left is seen only by a hair
        before = unseen
        longer = visit_places(problem, tours, points, samples, unseen)
        if longer is None:
            break
        tours = longer
        search = mending(problem, tours, samples, seed)
    return tours

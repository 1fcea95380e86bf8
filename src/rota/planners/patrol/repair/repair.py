"""From tours that see all samples to a plan that the check passes: what it finds unmet becomes samples too."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from rota.model.plan import Plan
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context, with_best_bound
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.extra_points import metres_worth, no_points, prepare_with
from rota.planners.patrol.ground.finer_space import with_room_to_see
from rota.planners.patrol.ground.nooks import nooks_of
from rota.planners.patrol.ground.problem import Problem, stretch_periods
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, join, lay_out
from rota.planners.patrol.ground.viewpoints import what_places_see
from rota.planners.patrol.initial.cut_tours import cut_where_bodies_touch
from rota.planners.patrol.repair.bending.search import Bending, can_bend
from rota.planners.patrol.repair.clear_of_stays import clear_of_who_stays, past_where_they_wait
from rota.planners.patrol.repair.detours import places_hidden, visit_places
from rota.planners.patrol.repair.last_places import last_place
from rota.planners.patrol.repair.new_points import new_points
from rota.planners.patrol.repair.seeing import annealing_of, lead_to_the_rest, see_the_rest
from rota.planners.patrol.repair.stubborn import ask_again, visiting_stubborn
from rota.planners.patrol.tolerances import ROUNDING
from rota.planners.patrol.tours.curves import curve_tours
from rota.planners.patrol.tours.timetable import as_trajectories, begin_by_autopilots
from rota.planners.patrol.tours.tour import Tour, over_budget_share, tour_length_m, unfold_nests
from rota.planners.patrol.traffic.bodies.reroutes import reroute
from rota.planners.patrol.traffic.bodies.timing import timed_rounds
from rota.planners.patrol.verdict import Verdict


@dataclass(frozen=True, kw_only=True)
class Repaired:
    """Tours, their plan and its verdict; ``extra``: all points that the judge found unmet on the way.

    eased: the verdict is that on the same tours for longer periods.
    """

    tours: list[Tour]
    plan: Plan
    verdict: Verdict
    extra: SamplePoints
    eased: bool = False

    @property
    def robots(self) -> int:
        """The robots of all its tours."""
        return sum(tour.robots for tour in self.tours)

    @property
    def within_budgets(self) -> bool:
        """Whether every tour keeps within its budget."""
        return over_budget_share(self.tours) == 0

    @property
    def met(self) -> bool:
        """Whether the plan passed, be its tours over their budgets.

        Robots may follow each other in more than a period where all places are seen for as long as that is more.
        """
        return self.sees_all and not self.eased

    @property
    def sees_all(self) -> bool:
        """Whether what the judge was shown passed."""
        return self.verdict.verdict == "met"


def claiming(found: Repaired, bound: ProvedBound) -> Repaired:
    """The same plan with this bound; the very same where it claims that already."""
    if (found.plan.lower_bound_robots, found.plan.lower_bound_reason) == (bound.robots, bound.reason):
        return found
    plan = replace(found.plan, lower_bound_robots=bound.robots, lower_bound_reason=bound.reason)
    return replace(found, plan=plan)


def plan_of(
    problem: Problem,
    tours: Sequence[Tour],
    *,
    seed: int,
    bound: ProvedBound | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Plan:
    """The plan that drives these tours, with the bound; the fleet's names for robots, or robot-1, robot-2, ..."""
    ways = unfold_nests(tours)
    rounds = timed_rounds(curve_tours(ways, problem.paths.grid, should_stop), problem.robot.body_radius_m)
    fleet = problem.mission.fleet.robots
    names = [r.name for r in fleet] if fleet else [f"robot-{i + 1}" for i in range(len(rounds))]
    trajectories = begin_by_autopilots(ways, as_trajectories(rounds, names[: len(rounds)]))
    return Plan(
        mission=problem.mission,
        trajectories=trajectories,
        seed=seed,
        lower_bound_robots=None if bound is None else bound.robots,
        lower_bound_reason=None if bound is None else bound.reason,
    )


def repair_until_feasible(
    context: Context,
    tours: list[Tour],
    extra: SamplePoints,
    *,
    may_add: bool,
    rounds: int,
    annealed: bool = False,
    is_in_vain: Callable[[list[Tour]], bool] = lambda _: False,
) -> Repaired:
    """Repair the tours until the judge passes their plan, they exceed their budgets, or ``rounds`` are over.

    may_add: a tour that exceeds its budget gets another robot.
    annealed: the tours see nearly everything and are about as short as they can be; linear programs find the rest.
    is_in_vain: whether tours after a round are no use, whatever the judge says of them; it is then not asked again.
    Returns the last state that was judged.
    """
    settings, bends = context.settings.repair, annealed and can_bend(context.problem)
    stuck, reroutes, most_stuck, unmet = 0, 0, 4, list[int]()
    if may_add and context.problem.is_ragged:
        problem, tours = clear_of_who_stays(context.problem, tours)
        context = replace(context, problem=problem)
        extra = join([extra, missed_nooks(context, tours)])
        with ThreadPoolExecutor(max_workers=1) as pool:  # tours are led on one core
            proved = pool.submit(with_best_bound, context)
            tours = seeing_all(context, tours, extra, may_add=True, bends=False, seed=context.seed)
        context, tours = proved.result(), cut_where_bodies_touch(problem, tours)
    missed: SamplePoints | None = None  # all that tours are to be led past; None: all samples
    for turn in range(1, rounds + 1):
        if may_add and context.problem.is_ragged and missed is not None:
            tours = seeing_missed(context, tours, missed, seed=context.seed)
        else:
            tours = seeing_all(context, tours, extra, may_add=may_add, bends=bends, seed=context.seed + turn - 1)
        if turn > 1 and is_in_vain(tours):
            break
        excess = over_budget_share(tours)
        goes_on_over_budget = bends and excess <= settings.over_budget_limit
        eased_by = 2 * excess if goes_on_over_budget else 0.0
        repaired = judge_tours(context, tours, extra, turn, bends=bends, eased_by=eased_by)
        new = repaired.extra[np.arange(len(extra), len(repaired.extra))]
        if may_add and context.problem.is_ragged and len(new):
            context = replace(context, problem=with_room_to_see(context.problem, places_hidden(context.problem, new)))
        unmet.append(len(repaired.verdict.unmet_points_m))
        stuck = stuck + 1 if unmet[-1:] == unmet[-2:-1] else 0
        if repaired.sees_all or turn == rounds or stuck == most_stuck or context.should_stop():
            break
        if (not may_add and excess > 0 and not goes_on_over_budget) or (bends and hardly_falls(context.problem, unmet)):
            break
        if len(new):
            again = new if stuck else ask_again(context.problem, extra, new)
            missed, extra = new, repaired.extra
            tours = visiting_stubborn(context, tours, again, max(stuck, 1))
            continue
        # all is seen, but bodies touch
        apart = lead_apart(context.problem, tours, repaired.verdict, may_add) if reroutes < most_stuck else None
        if apart is None:
            break
        tours, reroutes, stuck, missed = apart, reroutes + 1, 0, None
    return repaired


def hardly_falls(problem: Problem, unmet: Sequence[int]) -> bool:
    """Whether three rounds have not halved the places that are unmet; robots with mass then hardly ever pass."""
    return problem.robot.motion.has_mass and len(unmet) == 3 and 2 * unmet[2] > unmet[0]


def seeing_all(
    context: Context, tours: list[Tour], extra: SamplePoints, *, may_add: bool, bends: bool, seed: int
) -> list[Tour]:
    """The tours after one round: led to where they see all samples, then fitted to their budgets.

    They stay as they are, to be judged as that, where the search is to stop.
    """
    problem = context.problem
    if context.should_stop():
        return [with_robots(tour) for tour in tours] if may_add else tours
    points, samples = prepare_with(problem, extra)
    lead = bend if bends else see_the_rest
    tours = lead(context, tours, points, samples, seed=seed)
    if may_add:
        return past_where_they_wait(problem, [with_robots(tour) for tour in tours])
    # programs leave every corner in; where each takes time, moves then take some out
    moves_follow = not bends or driving_of(problem.robot).slopes is not None
    if moves_follow and over_budget_share(tours) > 0:
        return tighten(context, tours, samples, seed=seed)
    return tours


def seeing_missed(context: Context, tours: list[Tour], missed: SamplePoints, *, seed: int) -> list[Tour]:
    """The tours led past places that see what the judge has found unmet, with the robots that they need.

    Nothing else of them moves, so that they go on to see what they see. On ragged ground bending them would take long,
    for a few slivers in each round.
    """
    problem = context.problem
    if not len(missed):
        return tours
    points, samples, _ = lay_out(missed, problem.walls, problem.robot, weight=metres_worth(problem, missed))
    tours = lead_to_the_rest(context, tours, points, samples, seed=seed)
    return past_where_they_wait(problem, [with_robots(tour) for tour in tours])


def judge_tours(
    context: Context, tours: list[Tour], extra: SamplePoints, turn: int, *, bends: bool, eased_by: float
) -> Repaired:
    """The tours with their plan and its verdict, and what the judge finds unmet among the extra points.

    eased_by: the judge is shown periods longer by this share. Who is late by a little sees everything late; what is
    missed shows when there is more time.
    """
    problem = context.problem
    plan = plan_of(problem, tours, seed=context.seed, bound=context.bound, should_stop=context.should_stop)
    shown = plan
    if eased_by > 0:
        easier = stretch_periods(problem, 1 + eased_by)
        shown = plan_of(easier, tours, seed=context.seed, should_stop=context.should_stop)
    verdict = context.judge(shown)
    shorter = shorter_m(context, tours, turn, bends=bends)
    new = new_points(context, tours, verdict, turn, shorter_m=shorter)
    return Repaired(tours=tours, plan=plan, verdict=verdict, extra=join([extra, new]), eased=eased_by > 0)


def missed_nooks(context: Context, tours: list[Tour]) -> SamplePoints:
    """The nooks of ragged ground that the tours do not see, but may."""
    problem = context.problem
    points = no_points() if context.should_stop() else nooks_of(problem)
    if len(points):
        points, samples, _ = lay_out(points, problem.walls, problem.robot)
        points = points[annealing_of(context, tours, samples, length_weight=1.0, seed=context.seed).unseen_samples]
    if not len(points):
        return points
    points, samples, _ = lay_out(points, problem.walls, problem.robot)
    _, seen = what_places_see(problem.viewpoints.xy_m, problem.robot, problem.range_margin_m, samples)
    further = [i for i in np.setdiff1d(np.arange(len(points)), seen) if last_place(problem, points, int(i)) is not None]
    return points[np.concatenate([np.unique(seen), further]).astype(np.int64)]


def bend(context: Context, tours: list[Tour], points: SamplePoints, samples: Samples, *, seed: int) -> list[Tour]:
    """The tours moved as little as it takes to see all samples within the budgets, as near to that as they come."""
    problem, settings = with_tight_margin(context, tours), context.settings.repair
    # among many small obstacles, where metres count, programs would take long to get past what no leg comes near
    detours_first = context.settings.bending.length_weight > 0 and problem.lanes_overlap_m > 0
    bending = Bending(problem, tours, samples, context.settings.bending, reserve=ROUNDING)
    if detours_first and bending.some_far:
        tours = visit_places(problem, tours, points, samples, bending.far_samples, further=True) or tours
        bending = Bending(problem, tours, samples, context.settings.bending, reserve=ROUNDING)
    # detours are dear: moves make them shorter first
    if bending.some_far and driving_of(problem.robot).slopes is not None:
        tours = see_the_rest(context, tours, points, samples, seed=seed)
        tours = tighten(context, tours, samples, seed=seed)
        bending = Bending(problem, tours, samples, context.settings.bending, reserve=ROUNDING)
    bending.run(settings.bending_steps, should_stop=context.should_stop)
    if settings.over_budget_limit > 0 and over_budget_share(bending.tours) > 0:
        bending.hand_over(settings.bending_steps, should_stop=context.should_stop)
    if not bending.some_far or detours_first:
        return bending.tours
    longer = see_the_rest(context, bending.tours, points, samples, seed=seed)
    bending = Bending(problem, longer, samples, context.settings.bending, reserve=ROUNDING)
    bending.run(settings.bending_steps, should_stop=context.should_stop)
    return bending.tours


def are_tight(tours: Sequence[Tour]) -> bool:
    """Whether some tour leaves less than 2 % of its budget."""
    return over_budget_share(tours, 0.02) > 0


def with_tight_margin(context: Context, tours: Sequence[Tour]) -> Problem:
    """The problem, with a smaller range margin where tours are tight: what is missed then takes rounds of repair."""
    problem = context.problem
    if not are_tight(tours):
        return problem
    return replace(problem, range_margin_m=context.settings.repair.tight_range_margin * problem.range_margin_m)


def lead_apart(problem: Problem, tours: list[Tour], verdict: Verdict, may_add: bool) -> list[Tour] | None:
    """The tours led another way, so that bodies can be kept apart; None when no bodies touch, or no way was found."""
    if not any(fault.kind == "bodies touch" for fault in verdict.violations):
        return None
    if problem.is_ragged and may_add:
        cut = cut_where_bodies_touch(problem, tours)
        if len(cut) > len(tours):
            return cut
    return reroute(unfold_nests(tours), problem.robot.body_radius_m, problem.space, problem.paths, may_add=may_add)


def with_robots(tour: Tour) -> Tour:
    """The tour with as many robots as its length needs, and no fewer than it has."""
    needed = math.ceil(tour_length_m(tour) / replace(tour, robots=1).budget_m)
    return replace(tour, robots=max(tour.robots, needed))


def shorter_m(context: Context, tours: Sequence[Tour], turn: int, *, bends: bool) -> float:
    """By how much less than they reach sensors are taken to reach for what was missed, more in every round.

    bends: by linear programs, which go no further than they are asked to; a single bend is to close all of a sliver,
    not just the part of it round the point that was missed. Tight tours are asked for little, since every metre counts.
    """
    problem, settings = context.problem, context.settings.repair
    if bends and are_tight(tours):
        return settings.bend * problem.reach_m + settings.tight_bend_growth * turn * problem.range_margin_m
    further_m = settings.bend * problem.reach_m if bends else 0.0
    return further_m + settings.roomy_bend_growth * turn * problem.range_margin_m


def tighten(context: Context, tours: list[Tour], samples: Samples, *, seed: int) -> list[Tour]:
    """The tours made shorter by moves too small to lose anything that is seen, at hardly any heat.

    Seeing weighs twenty times as much as usual; a hundredth of the budgets is to be left, which detours take again.
    """
    weighty = samples._replace(weight=20 * samples.weight)
    search = annealing_of(context, tours, weighty, length_weight=1.0, seed=seed, reserve=0.01)
    heat_m = context.problem.reach_m / 1000
    moves = context.settings.alternation.moves // 2
    search.run(moves, hot_m=heat_m, cold_m=heat_m, should_stop=context.should_stop)
    return search.tours

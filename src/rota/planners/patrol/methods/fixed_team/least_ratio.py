"""A fleet with a fixed number of robots: plans whose worst ratio of gap to period is as small as the search finds.

With all periods multiplied by a stretch s, a plan that passes has no ratio above s of the periods that are asked. The
search looks for a small s with which so many robots have a plan; the ratio that is really reached is at most s.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace

from rota.errors import NoPlanFound
from rota.mission import AREA, Mission
from rota.plan import Plan
from rota.planners.patrol.annealing.schedule import shaped
from rota.planners.patrol.bounds.area_bound import area_rate
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.strongest_robot import strongest_robot, sweep_m2_s
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem, stretched
from rota.planners.patrol.initial.allocation import Start, robots_each, squeeze, starts
from rota.planners.patrol.methods.anneal_and_repair import cool_and_settle
from rota.planners.patrol.methods.fewest import COMFORT, with_so_many, worth_of_seeing
from rota.planners.patrol.methods.fixed_team.given_tours import (
    parts_started_in,
    plan_for_fixed_fleet,
    proved_words,
    with_so_many as joined_or_helped,
)
from rota.planners.patrol.methods.fixed_team.spare_robots import with_all_of, with_spare_robots
from rota.planners.patrol.methods.registry import fewest_by_method
from rota.planners.patrol.repair.repair import Settled, plan_of, settle
from rota.planners.patrol.tours.tour import tour_length_m
from rota.planners.patrol.verdict import Verdict, counted, touching

GROWTH = 1.25  # of the stretch after failing
TOWARDS_MET = 0.65  # of the way (of logarithms) from what failed to what passed: failing takes more work
PROOF_STEPS = 14
SMALLEST = 1e-3  # stretch that is tried


@dataclass(frozen=True, kw_only=True)
class Reached:
    """A plan for the periods times ``stretch``, and its worst ratio of gap to the periods that are asked."""

    settled: Settled
    stretch: float
    ratio: float


def plan_with_least_ratio(context: Context, asked: Mission) -> Plan:
    """The plan for exactly the fleet's robots whose worst ratio is the smallest found; NoPlanFound when it exceeds 1.

    asked: the mission with its starts, where spare robots go, and without a reserve, with which no ratio is proved.
    By the method of the mission's settings. When robots get in each other's way, fewer of them keep watch and the
    others help them or stand aside.
    """
    problem = context.problem
    fleet = problem.mission.fleet.robots
    assert fleet is not None
    robots = len(fleet)
    anyone = for_anyone(context)
    ways = starts(problem, context.work.groupings)
    anyone = replace(anyone, dear=worth_of_seeing(ways))
    starting = parts_started_in(problem, asked)
    # who starts in a part of the ground stays in it: only helping others there is left to choose
    if len({tour.component for tour in ways[0].tours}) > robots or len(starting) > 1:
        return plan_for_fixed_fleet(context, fewest_by_method(anyone), asked)
    reserve = asked.patrol.period_margin > 0 or asked.patrol.range_margin_m > 0
    proved = 0.0 if reserve else max(proved_ratio(problem, robots), 1.0 if context.bound.robots > robots else 0.0)
    best = least_ratio(anyone, robots, proved, starting)
    plan = None if best is None else as_asked(context, best)
    if plan is not None and context.judge(plan).verdict == "met":
        return plan
    if problem.mission.patrol.method != "tours":
        if best is None:
            return plan_for_fixed_fleet(context, fewest_by_method(anyone), asked)
    elif best is None or problem.robot.body_radius_m > 0:
        crowded = with_spare_robots(context, anyone, robots, starting)
        if crowded is not None:
            return crowded
    if best is None or plan is None:
        some = plan_of(
            problem, joined_or_helped(problem, ways[0].tours, robots), seed=context.seed, bound=context.bound
        )
        crowding = touching(context.judge(some)) if problem.robot.body_radius_m > 0 else None
        why = crowding or f"no plan for {counted(robots)} was found that surely sees everything"
        reason = f"{why}; {proved_words(context)}"
        raise NoPlanFound(reason, best=some)
    raise NoPlanFound(too_few_reason(context, robots, best, proved, reserve), best=plan)


def for_anyone(context: Context) -> Context:
    """The same search for as many robots as it takes, each like the one that all of the fleet can stand in for."""
    problem, robot = context.problem, context.problem.robot
    fleet = replace(
        problem.mission.fleet,
        robots=None,
        speed_m_s=robot.speed_m_s,
        sensor=robot.sensor,
        body_radius_m=robot.body_radius_m,
        turn_rate_rad_s=robot.turn_rate_rad_s,
    )
    return replace(context, problem=replace(problem, mission=replace(problem.mission, fleet=fleet)))


def too_few_reason(context: Context, robots: int, best: Reached, proved: float, reserve: bool) -> str:
    """Why so many robots have no plan: the demand they miss most, by how much, and what is proved."""
    few = (
        f"{counted(robots)} cannot meet the demand"
        if context.bound.robots > robots
        else f"no plan was found with which {counted(robots)} meet the demand"
    )
    crowded = touching(best.settled.verdict)
    if best.ratio <= 1 and crowded is not None:
        return f"{few}: {crowded}; {proved_words(context)}"
    worst = max(best.settled.verdict.demands, key=lambda demand: demand.worst_gap_s / demand.period_s)
    what = "the area" if worst.name == AREA else repr(worst.name)
    least = f", and with {counted(robots)} no worst gap below {proved:.3f} times its period" if proved > 0 else ""
    return (
        f"{few}: at best, in {what}, the worst gap is {worst.worst_gap_s:.6g} s, {best.ratio:.3f} times its"
        f" period{' less the reserve' if reserve else ''}; {proved_words(context)}{least}"
    )


def as_asked(context: Context, best: Reached) -> Plan:
    """The plan that was found for stretched periods, as an answer to the mission, with the fleet's own robots."""
    problem = context.problem
    plan = plan_of(stretched(problem, best.stretch), best.settled.tours, seed=context.seed, bound=context.bound)
    return replace(plan, mission=problem.mission)


def worst_ratio(verdict: Verdict) -> float:
    """The greatest ratio of a demand's worst gap to its period, shown by the check; inf when something is never seen.

    0 when all is always seen.
    """
    return max((demand.worst_gap_s / demand.period_s for demand in verdict.demands), default=0.0)


def proved_ratio(problem: Problem, robots: int) -> float:
    """A ratio below which no plan of so many robots has its worst gap: sweeping takes more robots for such periods.

    0 when nothing is to be swept. Source: the bounds of ``area_bound`` and ``rate_bound``, for stretched periods.
    """
    robot = strongest_robot(problem.mission.fleet)
    swept = [k for k, region in enumerate(problem.regions) if region.demand == "every_point"]
    shapes = [problem.regions[k].shape for k in swept]
    areas_m2 = surely_seeable_m2(problem.regions, problem.space, problem.walls, problem.robot)
    seeable_m2 = [areas_m2[k] for k in swept]
    lost_m2 = [shape.area - m2 for shape, m2 in zip(shapes, seeable_m2, strict=True)]

    def needed(stretch: float) -> float:
        periods_s = [stretch * problem.regions[k].period_s for k in swept]
        return max(area_rate(seeable_m2, periods_s, robot)[0], swept_robots(shapes, lost_m2, periods_s, robot)[0])

    # footprints and borders only lower what sweeping takes
    high = sum(m2 / (sweep_m2_s(robot) * problem.regions[k].period_s) for k, m2 in zip(swept, seeable_m2, strict=True))
    low, high = 0.0, high / robots
    if high == 0:
        return 0.0
    for _ in range(PROOF_STEPS):
        middle = (low + high) / 2
        if needed(middle) > robots * (1 + 1e-6):
            low = middle
        else:
            high = middle
    return low


def least_ratio(context: Context, robots: int, proved: float, starting: Counter[int]) -> Reached | None:
    """The plan with the smallest worst ratio found within the work; None when every try failed.

    ``robots`` is at least the number of parts of the ground. The demand itself, a stretch of 1, is tried whenever it
    lies between what is proved or failed and what passed. Once it is met only half of the work is done.
    """
    work = context.work
    guess = first_guess(context, robots)
    if guess is None:
        return None
    failed = max(proved, SMALLEST)
    stretch = max(failed * work.nearness, guess.comfortable)
    best: Reached | None = None
    for turn in range(work.stretches):
        if context.should_stop():
            break
        context.progress(0.1 + 0.8 * turn / work.stretches, f"trying {stretch:.3f} times the periods")
        found = tried(context, stretch, robots, best, starting)
        if found is None:
            failed = max(failed, stretch)
        elif best is None or found.ratio < best.ratio:
            best = found
        passed = guess.sure if best is None else best.ratio
        least = max(failed, guess.least)
        if failed < 1 < passed:
            stretch = 1.0
        elif best is None:
            # robots in each other's way: the demand itself is tried, however easy it should be
            stretch = max(GROWTH * stretch, 1.0 if turn == work.stretches - 2 else 0.0)
        elif passed <= least * work.nearness or (passed <= 1 and 2 * (turn + 1) >= work.stretches):
            break
        else:
            stretch = passed**TOWARDS_MET * least ** (1 - TOWARDS_MET)
    if best is None and context.problem.mission.patrol.method == "tours":
        return surely(context, robots, guess.sure)
    return best


@dataclass(frozen=True, kw_only=True)
class Guess:
    """Stretches: no hope below ``least``; ``comfortable`` should do; ``sure`` suits the tours as they begin."""

    least: float
    comfortable: float
    sure: float


def first_guess(context: Context, robots: int) -> Guess | None:
    """Where to begin: from the lengths of the first tours, and from those of ideal lanes over their ground.

    None when there are robots to spare however long the periods are: fewer see everything without moving.
    """
    stretch = 1.0
    while True:
        ways = starts(stretched(context.problem, stretch), context.work.groupings)
        handed = [(way, counts) for way in ways if (counts := robots_each(way, robots)) is not None]
        if handed:
            break
        if all(len(way.tours) <= robots for way in ways):
            return None
        stretch *= 2  # for longer periods ground farther apart is one tour's
    room = max(squeeze(way, counts) for way, counts in handed)
    sure = stretch * min(fullest(way, counts) for way, counts in handed)
    comfortable = max(stretch * COMFORT / room, sure / 2)
    least = stretch * context.work.least_squeeze / room
    # a robot that stays, or tours that need not move, have any period
    return Guess(least=least, comfortable=min(comfortable, sure) or SMALLEST, sure=sure or SMALLEST)


def fullest(way: Start, counts: list[int]) -> float:
    """The greatest ratio of a tour's length to its budget, with so many robots on each."""
    return max(
        tour_length_m(tour) / replace(tour, robots=n).budget_m for tour, n in zip(way.tours, counts, strict=True)
    )


def tried(
    context: Context, stretch: float, robots: int, best: Reached | None, starting: Counter[int]
) -> Reached | None:
    """A plan for so much longer periods that passes, or None: from the best tours so far, or from new ones.

    New ones are not begun for the sake of a little less where the effort is quick.
    """
    problem = stretched(context.problem, stretch)
    here = replace(context, problem=problem)
    if problem.mission.patrol.method != "tours":
        found = with_all_of(here, fewest_by_method(here), robots, starting)
        return reached(found, stretch) if found is not None else None
    if best is not None:
        tours = [replace(tour, period_s=problem.periods_s[tour.period_class]) for tour in best.settled.tours]
        seed = context.seed + 1000 * robots
        mended = cool_and_settle(here, shaped(here, tours, seed=seed), seed=seed)
        found = next((settled for settled in mended if settled is not None), None)
        if found is not None and len(found.plan.trajectories) == robots:
            return reached(found, stretch)
        if not (context.work.begins_anew or stretch == 1.0):
            return None
    ways = starts(problem, context.work.groupings)
    found = with_so_many(here, ways, robots, least_squeeze=context.work.least_squeeze)
    return reached(found, stretch) if found is not None and len(found.plan.trajectories) == robots else None


def reached(settled: Settled, stretch: float) -> Reached:
    """The settled plan for stretched periods with its ratio to those that are asked."""
    return Reached(settled=settled, stretch=stretch, ratio=stretch * worst_ratio(settled.verdict))


def surely(context: Context, robots: int, stretch: float) -> Reached | None:
    """The first tours as they are, mended, with twice the time that they take; None if not even these see it all."""
    problem = stretched(context.problem, 2 * stretch)
    here = replace(context, problem=problem)
    for way in starts(problem, context.work.groupings):
        counts = robots_each(way, robots)
        if counts is None:
            continue
        tours = [replace(tour, robots=n) for tour, n in zip(way.tours, counts, strict=True)]
        found = settle(here, tours, no_points(), may_add=False, rounds=3 * context.work.repairs)
        one = reached(found, 2 * stretch)
        if len(found.plan.trajectories) == robots and math.isfinite(one.ratio):
            return one
    return None

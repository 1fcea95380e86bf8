"""The search for the smallest worst ratio of gap to period.

With all periods multiplied by a stretch s, a plan that passes has no ratio above s of the periods that are asked. The
search looks for a small s with which the team has a plan; the ratio that is really reached is at most s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from rota.planners.patrol.annealing.schedule import anneal_shape
from rota.planners.patrol.context import Context, silent
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import stretch_periods
from rota.planners.patrol.initial.allocation import PeriodGrouping, period_groupings, robots_per_tour, slack_factor
from rota.planners.patrol.method_settings import FixedTeamSettings
from rota.planners.patrol.methods.anneal_and_repair import anneal_and_repair
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.fixed_team.whole_team import with_whole_team
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.shortening.search import has_nests, with_better_loops
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.planners.patrol.verdict import Verdict


@dataclass(frozen=True, kw_only=True)
class Reached:
    """A plan for the periods times ``stretch``, and its worst ratio of gap to the periods that are asked."""

    repaired: Repaired
    stretch: float
    ratio: float


@dataclass(frozen=True, kw_only=True)
class Guess:
    """Stretches: no hope below ``least``; ``likely`` should do; ``sure`` suits the tours as they begin."""

    least: float
    likely: float
    sure: float


def least_ratio(context: Context, team: Team, proved: float) -> Reached | None:
    """The plan with the smallest worst ratio found; None when every try failed.

    The team has at least as many robots as the ground has components. The demand itself, a stretch of 1, is tried
    whenever it lies between what is proved or failed and what passed. Once it is met only half of the tries are made.
    """
    settings = context.settings.fixed_team
    guess = first_guess(context, team.robots)
    if guess is None:
        return None
    failed = max(proved, settings.least)
    stretch: float | None = max(failed * settings.nearness, guess.likely)
    best: Reached | None = None
    for turn in range(settings.tries):
        if context.should_stop() or stretch is None:
            break
        context.progress(0.1 + 0.8 * turn / settings.tries, f"trying {stretch:.3f} times the periods")
        reached = with_stretch(context, stretch, team, best)
        if reached is None:
            failed = max(failed, stretch)
        elif best is None or reached.ratio < best.ratio:
            best = with_shorter_loops(context, reached)
        stretch = next_stretch(settings, guess, turn, stretch, failed, best)
    if best is None and context.anneals:
        return first_tours_in_time(context, team.robots, guess.sure)
    return best


def with_shorter_loops(context: Context, found: Reached) -> Reached:
    """The same plan with shorter loops, if everything is seen sooner then; loops within loops stay as they are.

    The search ends as soon as the tours keep within their budgets, although there may be much shorter ones.
    """
    tours, shortening = found.repaired.tours, context.settings.shortening
    if not context.anneals or context.keeps_first_tours or has_nests(tours):
        return found
    once = replace(context.settings, shortening=replace(shortening, attempts=shortening.attempts[:1]))
    own = replace(context, problem=stretch_periods(context.problem, found.stretch), settings=once, progress=silent)
    shorter = reach_of(with_better_loops(own, found.repaired), found.stretch)
    return shorter if shorter.ratio < found.ratio else found


def next_stretch(
    settings: FixedTeamSettings, guess: Guess, turn: int, stretch: float, failed: float, best: Reached | None
) -> float | None:
    """What is tried after this stretch, given the greatest that failed and the best plan; None: the search ends."""
    passed = guess.sure if best is None else best.ratio
    least = max(failed, guess.least)
    if failed < 1 < passed:
        return 1.0
    if best is None:
        # a quarter longer; robots in each other's way: the demand itself is tried, however easy it should be
        return max(1.25 * stretch, 1.0 if turn == settings.tries - 2 else 0.0)
    if passed <= least * settings.nearness or (passed <= 1 and 2 * (turn + 1) >= settings.tries):
        return None
    return float(passed**0.65 * least**0.35)  # nearer to what passed: a try that fails takes longer


def first_guess(context: Context, robots: int) -> Guess | None:
    """Where to begin: from the lengths of the first tours, and from those of ideal lanes over their ground.

    None when there are robots to spare however long the periods are: fewer see everything without moving.
    """
    settings = context.settings
    stretch = 1.0
    while True:
        groupings = period_groupings(stretch_periods(context.problem, stretch), settings.allocation.groupings)
        handed = [g.with_robots(counts) for g in groupings if (counts := robots_per_tour(g, robots)) is not None]
        if handed:
            break
        if all(len(grouping.tours) <= robots for grouping in groupings):
            return None
        stretch *= 2  # for longer periods ground farther apart is one tour's
    slack = max(slack_factor(grouping, worth_m=budget_m) for grouping in handed)  # grows as the periods do
    sure = stretch * min(fullest(grouping) for grouping in handed)
    likely = max(stretch * settings.team_size.likely_slack / slack, sure / 2)
    least = stretch * settings.allocation.least_slack / slack
    # a robot that stays, or tours that need not move, have any period
    smallest = settings.fixed_team.least
    return Guess(least=least, likely=min(likely, sure) or smallest, sure=sure or smallest)


def budget_m(tour: Tour) -> float:
    """The budget of a tour."""
    return tour.budget_m


def fullest(grouping: PeriodGrouping) -> float:
    """The greatest ratio of a tour's length to its budget."""
    return max(tour_length_m(tour) / tour.budget_m for tour in grouping.tours)


def with_stretch(context: Context, stretch: float, team: Team, best: Reached | None) -> Reached | None:
    """A plan for so much longer periods that passes, or None: from the best tours so far, or from new ones.

    New ones are begun for the sake of a little less only where the settings are thorough.
    """
    problem = stretch_periods(context.problem, stretch)
    robots, settings = team.robots, context.settings
    context = replace(context, problem=problem)
    if not context.anneals:
        fewest = team.method(context)
        whole = with_whole_team(context, fewest, team) if fewest.met else None
        return None if whole is None else reach_of(whole, stretch)
    if best is not None:
        tours = [replace(tour, period_s=problem.periods_s[tour.period_class]) for tour in best.repaired.tours]
        seed = context.seed + 1000 * robots
        attempts = anneal_and_repair(context, anneal_shape(context, tours, seed=seed), seed=seed)
        repaired = next((result for result in attempts if result is not None), None)
        if repaired is not None and repaired.robots == robots:
            return reach_of(repaired, stretch)
        if not (settings.multistart.is_thorough or stretch == 1.0):
            return None
    groupings = period_groupings(problem, settings.allocation.groupings)
    repaired = plan_with_team_size(context, groupings, robots, least_slack=settings.allocation.least_slack)
    return reach_of(repaired, stretch) if repaired is not None and repaired.robots == robots else None


def reach_of(repaired: Repaired, stretch: float) -> Reached:
    """The plan for stretched periods with its ratio to those that are asked."""
    return Reached(repaired=repaired, stretch=stretch, ratio=stretch * worst_ratio(repaired.verdict))


def worst_ratio(verdict: Verdict) -> float:
    """The greatest ratio of a demand's worst gap to its period, shown by the check; inf when something is never seen.

    0 when all is always seen.
    """
    return max((demand.worst_gap_s / demand.period_s for demand in verdict.demands), default=0.0)


def first_tours_in_time(context: Context, robots: int, stretch: float) -> Reached | None:
    """The first tours, repaired, with twice the time that they take; None if not even these see everything."""
    problem = stretch_periods(context.problem, 2 * stretch)
    context = replace(context, problem=problem)
    for grouping in period_groupings(problem, context.settings.allocation.groupings):
        counts = robots_per_tour(grouping, robots)
        if counts is None:
            continue
        repaired = repair_until_feasible(
            context, grouping.with_robots(counts).tours, no_points(),
            may_add=False, rounds=context.settings.repair.patient_rounds,
        )  # fmt: skip
        result = reach_of(repaired, 2 * stretch)
        if repaired.robots == robots and math.isfinite(result.ratio):
            return result
    return None

"""The search over team sizes: up from a likely one until a plan passes, then down one by one until none does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rota.planners.patrol.context import Context, with_best_bound
from rota.planners.patrol.efforts import EFFORTS, lesser_efforts
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.ground.standing import has_many_corners
from rota.planners.patrol.initial.allocation import PeriodGrouping, period_groupings
from rota.planners.patrol.methods.fewest.one_fewer import give_up_robots
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size
from rota.planners.patrol.methods.fewest.team_sizes import (
    coverage_weight_for,
    most_slack,
    smallest_with_slack,
    sure_team_size,
)
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tolerances import ROUNDING
from rota.planners.patrol.verdict import never_seen


def fewest_robots(context: Context, best: Repaired | None = None) -> Repaired:
    """The plan with the fewest robots found (met unless all repair failed).

    best: a plan that there is already; one with fewer robots is looked for. Every effort begins with what the lesser
    ones found: more effort never takes more robots.
    """
    asked = context.problem.mission
    efforts = [*lesser_efforts(PatrolSettings.of(asked).effort), PatrolSettings.of(asked).effort]
    # of the time that all take, measured on the harbour, each takes as much as its annealings have seeds
    work = {effort: EFFORTS[effort].multistart.seeds for effort in efforts}
    whole, done = sum(work.values()), 0.0
    for effort in efforts:
        own = context if effort == PatrolSettings.of(asked).effort else with_less_effort(context, effort)
        begun, done = done, done + work[effort] / whole
        best = reduce_team(replace(own, progress=share_of_progress(context.progress, begun, done)), best)
        if context.should_stop() or (best.met and best.robots <= context.enough_robots):
            break
    assert best is not None
    return best if best.plan.mission is asked else replace(best, plan=replace(best.plan, mission=asked))


def with_less_effort(context: Context, effort: Effort) -> Context:
    """The same search with less effort: a coarser lattice, less work, the same bound."""
    problem = set_up_problem(context.problem.mission.with_effort(effort))
    return replace(context, problem=problem, settings=EFFORTS[effort])


def share_of_progress(progress: Callable[[float, str], None], begin: float, end: float) -> Callable[[float, str], None]:
    """Progress told within a part of the whole."""
    return lambda share, what: progress(begin + (end - begin) * share, what)


def reduce_team(context: Context, best: Repaired | None) -> Repaired:
    """The plan with the fewest robots found with this effort; the best one given if none has fewer.

    Begins with a likely team size and goes up until a plan passes; or, when the first one did, down one by one until
    none does, no further than the proved bound.
    """
    settings = context.settings.team_size
    if context.keeps_first_tours and best is not None and best.met:
        return best  # finer samples give first tours that are as long, and repair of them takes minutes
    if best is not None and leaves_no_slack(context, best):
        return best
    groupings = period_groupings(context.problem, context.settings.allocation.groupings)
    if context.keeps_first_tours:
        repaired = repair_first_tours(context, groupings)
        # other tours over so many corners take hours, and see no more than repair has led these to
        in_vain = has_many_corners(context.problem.mission) and never_seen(repaired.verdict) is not None
        if repaired.met or context.should_stop() or in_vain:
            return repaired
        context = with_best_bound(context)
    context = replace(context, coverage_weight=coverage_weight_for(groupings))
    likely = min(smallest_with_slack(groupings, settings.likely_slack), sure_team_size(groupings))
    likely = max(context.enough_robots, likely)
    turns_on_spot = context.problem.robot.turn_radius_m == 0  # annealing and repairing curves again takes long
    # lanes that take more robots do not suit the mission, and would give up too many
    if best is not None and best.robots <= 2.0 * likely and turns_on_spot:
        best = without_spare_robots(context, groupings, best, likely)
    # from two robots more, a team of one robot less is as good a first try as the likely one
    if best is None or not best.met or best.robots > likely + 2:
        best = search_upwards(context, groupings, likely, best)
        if best.robots > likely:
            return best  # all smaller teams were tried
    return search_downwards(context, groupings, best, least=context.enough_robots)


def leaves_no_slack(context: Context, best: Repaired) -> bool:
    """Whether one robot fewer than a plan has is surely too few to be tried, by what is known before any tour is.

    Plans with three robots more than are proved are compared with a likely team size, which hangs on the tours.
    """
    if not best.met or best.robots > context.enough_robots + 2:
        return False
    return most_slack(context.problem, best.robots - 1) < context.settings.allocation.least_slack * (1 - ROUNDING)


def without_spare_robots(context: Context, groupings: list[PeriodGrouping], best: Repaired, likely: int) -> Repaired:
    """The last plan that passes when the tours of the best one so far give up robots.

    They give up half of those beyond the likely team size at once, or one; none where that leaves less slack than a
    team size is tried with.
    """
    least = max(context.enough_robots, smallest_with_slack(groupings, context.settings.allocation.least_slack))
    likely = max(likely, least)
    fewer = max(1, (best.robots - likely) // 2)
    while best.met and best.robots - fewer >= least and not context.should_stop():
        context.progress(0.1, f"trying {best.robots - fewer} robots")
        smaller = give_up_robots(context, best, fewer)
        if smaller is None and fewer == 1:
            break
        best = smaller or best
        fewer = 1 if smaller is None else max(1, (best.robots - likely) // 2)
    return best


def search_downwards(context: Context, groupings: list[PeriodGrouping], best: Repaired, *, least: int) -> Repaired:
    """The last plan that passes with one robot less and one less again, no further than to the ``least``."""
    robots = first = best.robots
    while best.met and robots > least and not context.should_stop():
        robots -= 1
        begin, end = (0.4 + 0.6 * (first - tried) / (first - least) for tried in (robots + 1, robots))
        own = replace(context, progress=share_of_progress(context.progress, begin, end))
        least_slack = context.settings.allocation.least_slack
        smaller = plan_with_team_size(own, groupings, robots, least_slack=least_slack)
        if smaller is None or smaller.robots >= best.robots:
            break  # a repair may post robots of their own
        best = smaller
    return best


def search_upwards(context: Context, groupings: list[PeriodGrouping], robots: int, best: Repaired | None) -> Repaired:
    """A plan with so many robots or more, fewer than the best has; else the best; else the first tours, repaired.

    Team sizes that were left out on the way up are tried on the way down from the plan.
    """
    settings = context.settings.team_size
    first = untried = robots
    sure = sure_team_size(groupings)
    steps = 0
    while steps < settings.single_steps or robots < sure:
        if best is not None and best.met and robots >= best.robots:
            break
        begin, end = (0.1 + 0.3 * (tried - first) / max(sure, tried + 1 - first) for tried in (robots, robots + 1))
        own = replace(context, progress=share_of_progress(context.progress, begin, end))
        larger = plan_with_team_size(own, groupings, robots, least_slack=1.0)
        if larger is not None:
            return larger if untried == robots else search_downwards(context, groupings, larger, least=untried)
        if context.should_stop():
            break
        untried = robots + 1
        steps += 1
        robots += 1 if steps < settings.single_steps else max(1, robots // 8)  # later ones by an eighth of themselves
    if best is not None and best.met:
        return search_downwards(context, groupings, best, least=untried)
    return repair_first_tours(context, groupings)


def repair_first_tours(context: Context, groupings: list[PeriodGrouping]) -> Repaired:
    """The first tours repaired until they pass, with as many robots as they then need."""
    context.progress(0.4, "finishing with the robots that surely suffice")
    rounds = context.settings.repair.patient_rounds
    return repair_until_feasible(context, groupings[0].tours, no_points(), may_add=True, rounds=rounds)

"""The planner for fixed teams: the smallest worst ratio of gap to period that the fleet's robots reach."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.context import Context, with_best_bound
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.ground.problem import stretch_periods
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.cycles.search import Team as Visiting, first_met, teams_for_all, teams_in_step
from rota.planners.patrol.methods.fewest.search import share_of_progress, with_less_effort
from rota.planners.patrol.methods.fewest.team_sizes import coverage_weight_for
from rota.planners.patrol.methods.fixed_team.least_ratio import Reached, least_ratio
from rota.planners.patrol.methods.fixed_team.one_loop import is_one_loop, shortest_loop
from rota.planners.patrol.methods.fixed_team.proved_ratio import proved_ratio
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.fixed_team.team_tours import join_for_team, starts_per_component, with_helpers
from rota.planners.patrol.methods.fixed_team.whole_team import with_smaller_team, with_whole_team
from rota.planners.patrol.methods.large.search import in_lanes, is_large
from rota.planners.patrol.methods.method import Method
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, plan_of
from rota.planners.patrol.tours.tour import Tour, unfold_nests
from rota.planners.patrol.verdict import (
    Verdict,
    demand_in_words,
    robots_in_words,
    touching,
    worst_demand,
    worst_reached,
)


def searching_longer_periods(context: Context) -> Context:
    """The search with the moves and allocations for one try with each ratio that is tried."""
    context, settings = context.with_all_moves(), context.settings
    screening = replace(settings.screening, allocations=settings.fixed_team.screened)
    return replace(context, settings=replace(context.settings, screening=screening))


def plan_fixed_team(context: Context, asked: Mission, method: Method) -> Plan:
    """The plan for exactly the fleet's robots whose worst ratio is the smallest found; NoPlanFound when it exceeds 1.

    asked: the mission with its starts, which say where spare robots go, and without a reserve, with which no ratio is
    proved. method: finds a plan with as few robots as it can. Every effort begins with lanes, and then with quick: more
    effort never gives a greater ratio, and a search that is stopped, or that finds nothing, has these plans.
    """
    if (plan := plan_by_places(context, asked, method, plain=False)) is not None:
        return claiming_bound_of(with_best_bound(context), plan)
    try:
        return plan_by_search(context, asked, method)
    except NoPlanFound:
        if (plan := plan_by_places(context, asked, method, plain=True)) is None:
            raise
        return claiming_bound_of(with_best_bound(context), plan)


def claiming_bound_of(context: Context, plan: Plan) -> Plan:
    """The plan with the bound of the search."""
    return replace(plan, lower_bound_robots=context.bound.robots, lower_bound_reason=context.bound.reason)


def plan_by_places(context: Context, asked: Mission, method: Method, *, plain: bool) -> Plan | None:
    """The plan of rounds from place to place, where all demands are met so; see ``plan_for_targets``."""
    if not context.anneals:
        return None
    robots = len(context.problem.mission.fleet.robots or ())
    team = Team(robots=robots, starting=starts_per_component(context.problem, asked), method=method)
    return plan_for_targets(context, for_anyone(context), team, plain=plain)


def plan_by_search(context: Context, asked: Mission, method: Method) -> Plan:
    """The same by the usual search alone."""
    lanes = lanes_of_team(context, asked, method)
    context = with_best_bound(context)
    if lanes is not None:
        lanes = claiming_bound_of(context, lanes)
        if context.should_stop():
            return lanes
    mission = context.problem.mission
    if PatrolSettings.of(mission).effort == "quick" or not context.anneals:
        return better_plan(context, lanes, lambda: plan_with_effort(context, asked, method))

    def quick() -> Plan:
        less = replace(with_less_effort(context, "quick"), progress=share_of_progress(context.progress, 0, 0.25))
        return replace(plan_with_effort(less, asked, method), mission=mission)

    with suppress(NoPlanFound):
        lanes = better_plan(context, lanes, quick)
    return better_plan(context, lanes, lambda: plan_with_effort(context, asked, method))


def better_plan(context: Context, first: Plan | None, search: Callable[[], Plan]) -> Plan:
    """What the search finds, or the first plan, whose worst ratio is smaller; NoPlanFound where there is neither."""
    if first is None:
        return search()
    try:
        plan = search()
    except NoPlanFound:
        return first
    return min(first, plan, key=lambda one: worst_ratio(context.judge(one)))


def lanes_of_team(context: Context, asked: Mission, method: Method) -> Plan | None:
    """A plan of lanes for exactly the fleet's robots; None where it takes more, or where lanes are dear to lay."""
    problem = context.problem
    if not context.anneals or problem.is_ragged:
        return None
    anyone, robots = for_anyone(context), len(problem.mission.fleet.robots or ())
    lanes = in_lanes(anyone) if is_large(context) else sweep(anyone, EARLY)
    team = Team(robots=robots, starting=starts_per_component(problem, asked), method=method)
    whole = None if lanes is None or not lanes.met else with_whole_team(context, lanes, team)
    return None if whole is None else whole.plan


def worst_ratio(verdict: Verdict) -> float:
    """The greatest of all gaps over their periods; 0 without demands."""
    worst = worst_demand(verdict)
    return 0.0 if worst is None else worst.worst_gap_s / worst.period_s


def plan_with_effort(context: Context, asked: Mission, method: Method) -> Plan:
    """The same with one effort alone. When robots get in each other's way, fewer of them keep watch, and the others
    help them or stand aside.
    """
    context = searching_longer_periods(context)
    problem = context.problem
    robots = len(problem.mission.fleet.robots or ())
    team = Team(robots=robots, starting=starts_per_component(problem, asked), method=method)
    groupings = period_groupings(problem, context.settings.allocation.groupings)
    weight = coverage_weight_for(groupings)
    anyone = replace(for_anyone(context), coverage_weight=weight)
    components = {tour.component for tour in groupings[0].tours}
    # who starts in a component stays in it: only helping others there is left to choose
    if len(components) > team.robots or len(team.starting) > 1:
        return plan_from_fewest(context, method(anyone), team)
    reserve = PatrolSettings.of(asked).period_margin > 0 or PatrolSettings.of(asked).range_margin_m > 0
    bound = 1.0 if context.bound.robots > team.robots else 0.0
    proved = 0.0 if reserve else max(proved_ratio(problem, team.robots), bound)
    best = shortest_loop(anyone, team) if is_one_loop(anyone, team) else None
    best = best or least_ratio(anyone, team, proved)
    plan = None if best is None else answer_for_mission(context, best)
    if plan is not None and context.judge(plan).verdict == "met":
        return plan
    if best is None and not context.anneals:
        return plan_from_fewest(context, method(anyone), team)
    if context.anneals and (best is None or problem.robot.body_radius_m > 0):
        smaller = with_smaller_team(context, anyone, team)
        if smaller is not None:
            return smaller.plan
    if best is None:
        plan = plan_of_tours(context, join_for_team(problem, groupings[0].tours, team.robots))
        crowded = touching(context.judge(plan)) if problem.robot.body_radius_m > 0 else None
        detail = crowded or "none was found that surely sees everything"
        raise NoPlanFound(too_few(context, team.robots, detail), best=plan)
    ratio = best_ratio(best.repaired.verdict, best.ratio, reserve=reserve)
    raise NoPlanFound(too_few(context, team.robots, ratio, least_ratio=proved), best=plan)


def for_anyone(context: Context) -> Context:
    """The same search for as many robots as it takes, each like the one that all of the fleet can stand in for."""
    problem, robot, fleet = context.problem, context.problem.robot, context.problem.mission.fleet
    fleet = replace(
        fleet,
        robots=None,
        speed_m_s=min(one.speed_m_s for one in fleet.robots or (fleet,)),
        sensor=robot.sensor,
        body_radius_m=robot.body_radius_m,
        turn_rate_rad_s=robot.turn_rate_rad_s,
        turn_radius_m=robot.turn_radius_m,
    )
    return replace(context, problem=replace(problem, mission=replace(problem.mission, fleet=fleet)))


def answer_for_mission(context: Context, best: Reached) -> Plan:
    """The plan for stretched periods as an answer to the mission, with the fleet's own robots."""
    problem = context.problem
    plan = plan_of(stretch_periods(problem, best.stretch), best.repaired.tours, seed=context.seed, bound=context.bound)
    return replace(plan, mission=problem.mission)


def plan_of_tours(context: Context, tours: list[Tour]) -> Plan:
    """The plan that drives these tours."""
    return plan_of(context.problem, tours, seed=context.seed, bound=context.bound)


def plan_from_fewest(context: Context, fewest: Repaired, team: Team) -> Plan:
    """The plan for exactly the team's robots, from one with as few as possible; NoPlanFound when they are too few."""
    robots, tours = team.robots, unfold_nests(fewest.tours)
    components = len({tour.component for tour in tours})
    if fewest.robots <= robots:
        whole = with_whole_team(context, fewest, team)
        if whole is not None:
            return whole.plan
        tours, detail = with_helpers(tours, robots, team.starting), f"{fewest.robots} may do"
    elif components > robots:
        tours, detail = [replace(tour, robots=1) for tour in tours[:robots]], apart(components)
    else:
        tours, detail = join_for_team(context.problem, tours, robots), f"{fewest.robots} can"
    plan = plan_of_tours(context, tours)
    verdict = context.judge(plan)
    if verdict.verdict == "met":
        return plan
    detail += f"; with {robots_in_words(robots)} {worst_reached(verdict)}"
    raise NoPlanFound(too_few(context, robots, detail), best=plan)


def plan_for_targets(context: Context, anyone: Context, team: Team, *, plain: bool) -> Plan | None:
    """The plan for all robots of the team with which the periods are kept with most to spare; None where none passes.

    anyone: the search without the fleet's own robots. plain: whether it is also tried where rounds that come to each
    place once need no more robots: the usual search brings those to lower ratios.
    """
    teams = teams_for_all(anyone)
    teams = [*teams_in_step(anyone, teams, team.robots), *teams]
    teams = [visiting for visiting in teams if visiting.robots <= team.robots]
    if not teams or (teams[0].is_plain and not plain):
        return None
    for candidates in (with_least_stretch(anyone, teams, team.robots), teams):
        found = first_met(anyone, candidates)
        whole = None if found is None else with_whole_team(context, found, team)
        if whole is not None:
            return whole.plan
    return None


def with_least_stretch(anyone: Context, teams: list[Visiting], robots: int) -> list[Visiting]:
    """Teams of at most so many robots for periods shortened as far as some are found; those given at worst."""
    least, most = 0.25, 1.0  # of the periods: rounds for shorter ones are not looked for
    for _ in range(6):
        middle = (least + most) / 2
        shorter = replace(anyone, problem=stretch_periods(anyone.problem, middle))
        found = [visiting for visiting in teams_for_all(shorter) if visiting.robots <= robots]
        if found:
            teams, most = found, middle
        else:
            least = middle
    return teams


def too_few(context: Context, robots: int, detail: str, *, least_ratio: float = 0.0) -> str:
    """That so many robots do not meet the demand, whether that is proved, the detail, and what is proved.

    least_ratio: what is proved of the worst ratio of gap to period with so many robots; 0: nothing.
    """
    if context.bound.robots > robots:
        opening = f"{robots_in_words(robots)} cannot meet the demand"
    else:
        opening = f"no plan was found with which {robots_in_words(robots)} meet the demand"
    proved = f"proved: at least {robots_in_words(max(context.bound.robots, 1))} ({context.bound.reason})"
    if least_ratio > 0:
        proved += f", and with {robots_in_words(robots)} no worst gap below {least_ratio:.3f} times its period"
    return f"{opening}: {detail}; {proved}"


def best_ratio(verdict: Verdict, ratio: float, *, reserve: bool) -> str:
    """What the plan with the smallest worst ratio misses most, or which bodies touch in it.

    ratio: of its worst gap to the period that is asked. reserve: whether that period is shorter than the mission's.
    """
    crowded = touching(verdict)
    if ratio <= 1 and crowded is not None:
        return crowded
    worst = worst_demand(verdict)
    assert worst is not None
    return (
        f"at best, in {demand_in_words(worst)}, the worst gap is {worst.worst_gap_s:.6g} s, {ratio:.3f} times its"
        f" period{' less the reserve' if reserve else ''}"
    )


def apart(components: int) -> str:
    """That each component of the standing space needs a robot of its own."""
    return (
        f"the ground falls into {components} parts between which no robot can travel, and each must be watched by a"
        " robot of its own"
    )

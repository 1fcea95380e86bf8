"""Places to come to beside ground to sweep: rounds from place to place, and the usual tours for the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.planners.patrol.bounds.best_bound import prove_by_area
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.ground.targets import Targets
from rota.planners.patrol.methods.cycles.search import Team, judge_tours, teams_for, tours_of
from rota.planners.patrol.methods.large.search import is_large
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import with_better_loops
from rota.planners.patrol.tours.tour import Tour


def with_places_apart(
    context: Context, best: Repaired, targets: Targets, search: Callable[[Context], Repaired]
) -> Repaired:
    """The plan in which some robots come to the targets and others sweep the rest, if it takes fewer; else the best.

    It is tried where rounds that come to a place several times spare robots, and only where areas and periods leave
    room for fewer robots than the best plan has. Large ground is left as it is, since a second search takes minutes.
    """
    bound = ProvedBound(robots=best.plan.lower_bound_robots or 0, reason=best.plan.lower_bound_reason or "")
    if (best.met and best.robots <= bound.robots) or context.keeps_first_tours or is_large(context):
        return best
    teams = [team for team in teams_for(context, targets) if not team.is_plain]
    if not teams or context.should_stop():
        return best
    try:
        rest = set_up_problem(without_demands(context.problem, targets))
    except NoPlanFound:
        return best
    proved = prove_by_area(rest)
    if best.met and teams[0].robots + proved.robots >= best.robots:
        return best
    own = replace(
        context, problem=rest, asked=rest.mission, bound=proved, enough_robots=proved.robots, proves_later=True
    )
    swept = search(own)
    if not swept.met:
        return best
    swept = with_better_loops(own, swept)
    for team in teams:
        if not best.met or team.robots + swept.robots < best.robots:
            found = together(replace(context, bound=bound), team, swept, rest)
            if found.met:
                return found
    return best


def without_demands(problem: Problem, targets: Targets) -> Mission:
    """The mission with nothing asked in the zones of the targets."""
    names = {problem.regions[k].name for k in targets.regions}
    zones = tuple(replace(zone, period_s=None) if zone.name in names else zone for zone in problem.mission.zones)
    return replace(problem.mission, zones=zones)


def together(context: Context, team: Team, swept: Repaired, rest: Problem) -> Repaired:
    """The tours of both, with their plan for all that is asked, and its verdict."""
    return judge_tours(context, [*tours_of(context.problem, team), *map(as_of(context.problem, rest), swept.tours)])


def as_of(problem: Problem, rest: Problem) -> Callable[[Tour], Tour]:
    """How a tour of the rest is told as one of the whole problem, whose period classes are more."""
    classes = [problem.periods_s.index(period_s) for period_s in rest.periods_s]
    return lambda tour: replace(tour, period_class=classes[tour.period_class], robot=problem.robot)

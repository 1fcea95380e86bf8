"""The method ``tours``: lanes at once, then annealed tours of fewer robots; in districts where ground is large."""

from __future__ import annotations

from collections.abc import Callable

from rota.planners.patrol.context import Context, with_best_bound, with_bound_by_area
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.ground.targets import targets_of
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.methods.cycles.beside_ground import with_places_apart
from rota.planners.patrol.methods.cycles.search import first_met, meet_all, teams_for, teams_in_step
from rota.planners.patrol.methods.fewest.search import fewest_robots
from rota.planners.patrol.methods.large.search import fewest_on_large, is_large
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.methods.sweeping.wide_turns import turns_widely
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, claiming

Search = Callable[[Context], Repaired]


def fewest_robots_anywhere(context: Context) -> Repaired:
    """The plan with the fewest robots found, whatever is asked (met unless all repair failed)."""
    return fewest_for_targets(context, fewest_on_ground)


def fewest_on_ground(context: Context) -> Repaired:
    """The plan with the fewest robots found, whatever the size of the ground.

    Ragged ground falls into thousands of cells, over which lanes take minutes to lay and are worth little. Robots that
    hardly move anywhere drive no lanes. Bounds are proved once there are lanes: that takes as long as these do.
    """
    problem = context.problem
    if is_large(context) and not turns_widely(problem):
        return fewest_on_large(context, fewest_robots)
    without = problem.is_ragged or all(robots_stand(problem, period_s) for period_s in problem.periods_s)
    lanes = None if without else sweep(context, EARLY)
    if lanes is not None:
        context = with_bound_by_area(context)
        lanes = claiming(lanes, context.bound)
        if lanes.robots <= context.enough_robots or (lanes.met and context.should_stop()):
            return lanes
    if not context.keeps_first_tours:  # else it is proved beside the repair of these
        context = with_best_bound(context)
    if lanes is not None:
        lanes = claiming(lanes, context.bound)
        if lanes.robots <= context.enough_robots:
            return lanes
    if is_large(context):  # also by other proofs than areas and periods
        if lanes is not None and turns_widely(problem):
            return lanes  # districts leave no room to turn
        return fewest_on_large(context, fewest_robots)
    return fewest_robots(context, lanes)


def fewest_for_targets(context: Context, search: Search) -> Repaired:
    """The plan with the fewest robots, by rounds that come to places several times or by the usual search.

    Where rounds that come to each place once are as good, the usual search finds shorter ones: it leads robots no
    farther into zones than they must go. Where they are not, it hardly ever finds fewer robots, and quick is without.
    """
    targets = targets_of(context.problem)
    if not meet_all(context.problem, targets):
        return with_places_apart(context, search(context), targets, search)
    teams = teams_for(context, targets)
    if not teams:
        return search(context)
    context = with_best_bound(context)
    teams = [*teams_in_step(context, teams, context.enough_robots), *teams]
    if teams[0].is_plain:
        best = search(context)
        return first_met(context, [team for team in teams if team.robots < best.robots or not best.met]) or best
    found = first_met(context, teams)
    is_quick = PatrolSettings.of(context.problem.mission).effort == "quick"
    if found is not None and (is_quick or found.robots <= context.enough_robots):
        return found
    best = search(context)
    return best if found is None or (best.met and best.robots <= found.robots) else found

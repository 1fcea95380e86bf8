"""Fewest robots where demands are met from single places: beside the usual search, or instead of it."""

from __future__ import annotations

from collections.abc import Callable

from rota.planners.patrol.context import Context, with_best_bound
from rota.planners.patrol.ground.targets import targets_of
from rota.planners.patrol.methods.cycles.beside_ground import with_places_apart
from rota.planners.patrol.methods.cycles.search import first_met, meet_all, teams_for, teams_in_step
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired

Search = Callable[[Context], Repaired]


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

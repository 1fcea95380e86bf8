"""A fixed team where every demand is met from one place: rounds that come to places several times."""

from __future__ import annotations

from dataclasses import replace

from rota.model.plan import Plan
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import stretch_periods
from rota.planners.patrol.methods.cycles.search import Team as Visiting, first_met, teams_for_all, teams_in_step
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.fixed_team.whole_team import with_whole_team


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

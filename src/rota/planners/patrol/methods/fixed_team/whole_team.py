"""Plans for more robots than it takes: spare ones help on the fullest tours, or stand aside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.fixed_team.team_tours import with_bystanders, with_helpers
from rota.planners.patrol.repair.repair import Repaired, plan_of, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.verdict import touching


def with_smaller_team(context: Context, anyone: Context, team: Team) -> Repaired | None:
    """A plan that passes in which fewer robots would do; None when none is found.

    anyone: the search without the fleet's own robots.
    """
    settings = context.settings
    groupings = period_groupings(context.problem, settings.allocation.groupings)
    least = max(context.bound.robots, 1)
    if least >= team.robots:
        return None
    sizes = np.linspace(team.robots - 1, least, min(team.robots - least, settings.fixed_team.tries))
    for size in (round(number) for number in sizes):
        if context.should_stop():
            return None
        smaller = plan_with_team_size(anyone, groupings, size, least_slack=settings.allocation.least_slack)
        whole = None if smaller is None else with_whole_team(context, smaller, team)
        if whole is not None:
            return whole
    return None


def with_whole_team(context: Context, repaired: Repaired, team: Team) -> Repaired | None:
    """The plan with all robots of the team; None when it takes more, or does not pass with spare ones."""
    if repaired.robots > team.robots:
        return None
    ways: tuple[Callable[[], list[Tour] | None], ...] = (
        lambda: with_helpers(repaired.tours, team.robots, team.starting),
        lambda: with_bystanders(context.problem, repaired.tours, team.robots),
    )
    for way in ways:
        if (tours := way()) is None:
            continue
        plan = plan_of(context.problem, tours, seed=context.seed, bound=context.bound)
        verdict = context.judge(plan)
        if verdict.verdict == "met":
            return replace(repaired, tours=tours, plan=plan, verdict=verdict)
        if touching(verdict) is not None:
            rounds = context.settings.repair.rounds
            apart = repair_until_feasible(context, tours, repaired.extra, may_add=False, rounds=rounds)
            if apart.met and apart.robots == team.robots:
                return apart
    return None

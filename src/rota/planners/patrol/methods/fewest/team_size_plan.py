"""A plan for one team size: allocations screened, the best annealed in full, then repaired in a race."""

from __future__ import annotations

from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import PeriodGrouping, allocations
from rota.planners.patrol.methods.fewest.multistart import annealed_in_full
from rota.planners.patrol.methods.fewest.racing import first_to_pass
from rota.planners.patrol.methods.fewest.screening import screened
from rota.planners.patrol.repair.repair import Repaired


def plan_with_team_size(
    context: Context, groupings: list[PeriodGrouping], robots: int, *, least_slack: float
) -> Repaired | None:
    """A plan with so many robots that the judge passes, or None."""
    seed = context.seed + 1000 * robots
    settings = context.settings.allocation
    candidates = allocations(context.problem, groupings, robots, settings, least_slack=least_slack)
    searches = annealed_in_full(context, screened(context, candidates, seed=seed), seed=seed)
    return first_to_pass(context, searches, seed=seed)

"""A plan for one team size: allocations screened, the best annealed in full, then repaired in a race."""

from __future__ import annotations

import math

from rota.planners.patrol.annealing.schedule import share_of_moves
from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import Allocation, PeriodGrouping, allocations
from rota.planners.patrol.methods.fewest.multistart import anneal_in_full
from rota.planners.patrol.methods.fewest.racing import first_to_pass
from rota.planners.patrol.methods.fewest.screening import screen
from rota.planners.patrol.repair.repair import Repaired


def plan_with_team_size(
    context: Context, groupings: list[PeriodGrouping], robots: int, *, least_slack: float
) -> Repaired | None:
    """A plan with so many robots that the judge passes, or None.

    Few robots on short tours are tried several times: each try is short, and its outcome much a matter of chance.
    """
    settings = context.settings.allocation
    candidates = allocations(context.problem, groupings, robots, settings, least_slack=least_slack)
    turns = tries(context, candidates)
    for turn in range(turns):
        seed = context.seed + 1000 * robots + 7_000_000 * turn  # far from those of other tries and team sizes
        context.progress(turn / turns, f"trying {robots} robots")
        chosen = screen(context, candidates, seed=seed)
        context.progress((turn + 0.1) / turns, f"trying {robots} robots: annealing their tours")
        searches = anneal_in_full(context, chosen, seed=seed)
        context.progress((turn + 0.4) / turns, f"trying {robots} robots: repairing their tours")
        found = first_to_pass(context, searches, seed=seed)
        if found is not None or context.should_stop():
            return found
    return None


def tries(context: Context, candidates: list[Allocation]) -> int:
    """How often these allocations are tried: so often that all tries together make no more moves than a long one."""
    share = max((share_of_moves(context, allocation.tours) for allocation in candidates), default=math.inf)
    return min(context.settings.multistart.tries, max(1, int(1 / share))) if candidates else 0

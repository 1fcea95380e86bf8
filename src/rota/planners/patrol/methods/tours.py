"""The method ``tours``: annealed tours, in districts where the ground is large."""

from __future__ import annotations

from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.fewest.search import fewest_robots
from rota.planners.patrol.methods.large.search import fewest_on_large, is_large
from rota.planners.patrol.repair.repair import Repaired


def fewest_robots_anywhere(context: Context) -> Repaired:
    """The plan with the fewest robots found, whatever the size of the ground (met unless all repair failed)."""
    if is_large(context.problem, context.settings.districts):
        return fewest_on_large(context, fewest_robots)
    return fewest_robots(context)

"""The method ``tours``: lanes at once, then annealed tours of fewer robots; in districts where ground is large."""

from __future__ import annotations

from rota.planners.patrol.context import Context
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.methods.fewest.search import fewest_robots
from rota.planners.patrol.methods.large.search import fewest_on_large, is_large
from rota.planners.patrol.methods.sweeping.search import swept
from rota.planners.patrol.repair.repair import Repaired


def fewest_robots_anywhere(context: Context) -> Repaired:
    """The plan with the fewest robots found, whatever the size of the ground (met unless all repair failed).

    Ragged ground falls into thousands of cells, over which lanes take minutes to lay and are worth little. Robots that
    hardly move drive no lanes.
    """
    problem = context.problem
    if is_large(context):
        return fewest_on_large(context, fewest_robots)
    without = problem.is_ragged or any(robots_stand(problem, period_s) for period_s in problem.periods_s)
    lanes = None if without else swept(context, EARLY)
    if lanes is not None and lanes.robots <= context.enough_robots:
        return lanes
    return fewest_robots(context, lanes)

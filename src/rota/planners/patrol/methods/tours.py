"""The method ``tours``: lanes at once, then annealed tours of fewer robots; in districts where ground is large."""

from __future__ import annotations

from rota.planners.patrol.context import Context, with_best_bound, with_bound_by_area
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.methods.cycles.fewest import fewest_for_targets
from rota.planners.patrol.methods.fewest.search import fewest_robots
from rota.planners.patrol.methods.large.search import fewest_on_large, is_large
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.methods.sweeping.wide_turns import turns_widely
from rota.planners.patrol.repair.repair import Repaired, claiming


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

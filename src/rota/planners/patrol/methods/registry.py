"""The methods by their names, and what is done when none has a plan."""

from __future__ import annotations

import time
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.fewest import fewest_robots
from rota.planners.patrol.methods.large.search import fewest_on_large, is_large
from rota.planners.patrol.methods.sweeping.methods import METHODS
from rota.planners.patrol.methods.sweeping.search import fewest_robots_of
from rota.planners.patrol.repair.repair import Settled
from rota.planners.patrol.verdict import counted, worst_reached

PATIENCE_S = 10.0  # for a plan of lanes where the search was stopped before it had any


def fewest_by_method(context: Context) -> Settled:
    """The best settled plan that the method of the mission's settings finds."""
    method = context.problem.mission.patrol.method
    if method == "sun2019":  # nobody else needs what it loads and compiles
        from rota.planners.patrol.methods.sun2019.search import fewest_robots_by_stages

        return fewest_robots_by_stages(context)
    if method != "tours":
        return fewest_robots_of(METHODS[method], context)
    return fewest_on_large(context, fewest_robots) if is_large(context.problem) else fewest_robots(context)


def swept_instead(context: Context, best: Settled) -> Settled:
    """A plan of lanes where the search was stopped before it had any: few missions take more than seconds for it.

    It has seldom fewer robots than the search would have found, but it passes; the best there was if it does not, or
    takes longer than ``PATIENCE_S``. A search that is not stopped never comes here.
    """
    context.progress(0.9, "sweeping in lanes instead")
    end_s = time.monotonic() + PATIENCE_S
    quick = replace(context.problem, mission=context.problem.mission.with_effort("quick"))
    hasty = replace(context, problem=quick, should_stop=lambda: time.monotonic() > end_s)
    try:
        swept = fewest_robots_of(METHODS["sequential"], hasty)
    except NoPlanFound:
        return best
    return replace(swept, plan=replace(swept.plan, mission=context.problem.mission)) if swept.met else best


def unmet_reason(bound: ProvedBound, best: Settled) -> str:
    """Why the best plan is none: the demand it misses most, by how much, and the proved bound."""
    reached = worst_reached(best.verdict)
    return (
        f"the best plan found, with {counted(len(best.plan.trajectories))}, does not meet the demand: {reached};"
        f" proved: at least {counted(bound.robots)}: {bound.reason}"
    )

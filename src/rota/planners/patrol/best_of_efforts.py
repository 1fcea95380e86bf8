"""More effort never takes more: robots that charge, or of several kinds, keep the best plan of all efforts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.plan import Plan
from rota.planners.patrol.efforts import lesser_efforts
from rota.planners.patrol.kinds.groups import differs
from rota.planners.patrol.methods.fewest.search import share_of_progress
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.planner import Request


def best_of_efforts(request: Request, plan: Callable[[Request], Plan]) -> Plan:
    """The plan of the mission's effort, or of a lesser one if that takes fewer robots, or cheaper ones.

    Robots that are alike and do not charge have one search, which begins with what lesser efforts found. Batteries and
    kinds are heeded after loops are found: longer loops may then take more. plan: plans for a mission. Raises what it
    says of the mission's own effort where no effort has a plan.
    """
    mission, asked = request.mission, PatrolSettings.of(request.mission).effort
    best: Plan | None = None
    if mission.chargers or differs(mission):
        lesser = lesser_efforts(asked)
        for number, effort in enumerate(lesser):
            begin, end = (0.25 * turn / len(lesser) for turn in (number, number + 1))
            told = share_of_progress(request.progress, begin, end)
            try:
                found = plan(replace(request, mission=mission.with_effort(effort), progress=told))
            except NoPlanFound:
                continue
            best = better(best, replace(found, mission=mission))
        if lesser:
            request = replace(request, progress=share_of_progress(request.progress, 0.25, 1.0))
    if best is None:
        return plan(request)
    if request.should_stop():
        return best
    try:
        return better(best, plan(request))
    except NoPlanFound:
        return best


def better(first: Plan | None, second: Plan) -> Plan:
    """The second plan, or the first if that is cheaper, with the greater of their bounds."""
    if first is None:
        return second
    proved = max(second, first, key=lambda one: one.lower_bound_robots or 0)
    return replace(
        min(second, first, key=price),
        lower_bound_robots=proved.lower_bound_robots,
        lower_bound_cost=proved.lower_bound_cost,
        lower_bound_reason=proved.lower_bound_reason,
    )


def price(plan: Plan) -> float:
    """What the robots of a plan cost, where their kinds say so; else how many they are."""
    fleet = plan.mission.fleet
    return sum(fleet.kind_of(way.robot).cost for way in plan) if fleet.kinds else float(len(plan))

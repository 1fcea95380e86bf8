"""The least worst ratio of gap to period of a fixed team whose robots charge, where it is too small for what is asked.

Loops, turns at them and circuits are planned anew for each stretch of all periods: batteries allow no other short cut.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.plan import Plan
from rota.planners.patrol.context import silent
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.problem import stretch_mission
from rota.planners.patrol.methods.fixed_team.least_ratio import worst_ratio
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.planner import Request

FIRST = 1.5  # stretch that is tried; each that fails is followed by twice as much


def plan_at_best(request: Request, plan: Callable[[Request], Plan], failure: NoPlanFound) -> Plan:
    """The plan of a fixed team that charges for the shortest periods found that it can keep, if these are as asked.

    plan: plans for a mission. failure: what it says of this one. Raises NoPlanFound with the plan where the periods are
    longer ones; the failure itself where no longer periods help.
    """
    mission, failed, stretch = request.mission, 1.0, FIRST
    settings = EFFORTS[PatrolSettings.of(mission).effort].fixed_team
    best, ratio = None, math.inf
    for turn in range(settings.tries):
        if request.should_stop() or ratio <= settings.nearness * failed:
            break
        request.progress(turn / settings.tries, f"trying {stretch:.3g} times the periods")
        longer = stretch_mission(mission, stretch).with_effort("quick")
        try:
            found = plan(replace(request, mission=longer, progress=silent, watch=None))
        except NoPlanFound:
            failed = max(failed, stretch)
        else:
            # told by what it was planned for: of a plan that fails the check leaves open in part what it comes to
            best, ratio = found, min(stretch, stretch * worst_ratio(request.judge(found)))
        stretch = 2 * stretch if best is None else math.sqrt(failed * ratio)
    if best is None:
        raise failure
    best = replace(best, mission=mission).without_bound()
    if ratio <= 1:
        return best
    raise NoPlanFound(f"{failure}; at best, every gap is within {ratio:.3f} times its period", best=best) from failure

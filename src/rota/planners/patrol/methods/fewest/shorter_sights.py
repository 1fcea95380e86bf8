"""Fewer robots where walls end most sights: the search anew, as if sensors reached half as far, a quarter, ...

Samples, steps and tours are laid out by the reach. Where rooms are much smaller, that is too coarse to find what a
shorter sensor finds at once; whatever that sees, the longer one sees as well. The judge is asked for what the mission
asks.
"""

from __future__ import annotations

from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Mission
from rota.planners.patrol.context import Context
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.methods.fewest.search import reduce_team
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import ideal_reaches


def with_shorter_sights(context: Context, best: Repaired) -> Repaired:
    """The plan with the fewest robots of those found with shorter reaches, if it is better; else the plan given.

    Places to visit are no farther off for a shorter reach: without other ground nothing is tried.
    """
    asked_reaches, share = ideal_reaches(context.problem), 0.5
    if asked_reaches == 0:
        return best
    while (not best.met or best.robots > context.enough_robots) and not context.should_stop():
        if asked_reaches / share**2 > 4.0:  # longer loops are laid out finely enough, and searches take longer
            break
        try:
            problem = set_up_problem(mission_with_reach(context.problem.mission, share))
        except NoPlanFound:
            break  # a sensor that reaches less far leaves too much out of sight
        context.progress(0.9, f"searching anew with {share:.2g} times the reach")
        own = replace(context, problem=replace(problem, mission=context.problem.mission))
        found = reduce_team(own, sweep(own, EARLY))
        if found.met and not (best.met and best.robots <= found.robots):
            best = replace(found, tours=[replace(tour, robot=context.problem.robot) for tour in found.tours])
        share /= 2
    return best


def mission_with_reach(mission: Mission, share: float) -> Mission:
    """The mission with sensors that reach so much of what they do."""
    sensor = mission.fleet.sensor
    if isinstance(sensor, DiscSensor):
        shorter = replace(sensor, radius_m=share * sensor.radius_m)
        return replace(mission, fleet=replace(mission.fleet, sensor=shorter))
    return replace(mission, fleet=replace(mission.fleet, sensor=replace(sensor, side_m=share * sensor.side_m)))

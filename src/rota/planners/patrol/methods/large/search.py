"""The search on large ground: lanes over districts; where these are far from the bound, districts one by one."""

from __future__ import annotations

import math
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.geometry.free_space import demanded_regions
from rota.model.mission import Mission
from rota.planners.patrol.bounds.area_bound import area_rate_bound
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.context import Context, with_best_bound
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.method_settings import DistrictSettings
from rota.planners.patrol.methods.large.cells import boxes_for, missions_of, where_robots_come
from rota.planners.patrol.methods.large.districts import by_districts, join
from rota.planners.patrol.methods.large.lanes import AROUND, in_districts
from rota.planners.patrol.methods.large.pieces import in_pieces, is_built_up
from rota.planners.patrol.methods.method import Method
from rota.planners.patrol.methods.sweeping.search import judge_by_lanes, sweep_with_fewest_robots
from rota.planners.patrol.repair.repair import Repaired, claiming, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour


def is_large(context: Context) -> bool:
    """Whether so much ground must be seen, for what a robot sees at once, or by so many, that districts are planned."""
    return has_many(context) or is_wide(context.problem, context.settings.districts)


def is_wide(problem: Problem, settings: DistrictSettings) -> bool:
    """Whether the ground is too large to be searched as one."""
    return problem.asked_m2 > settings.large_from * problem.reach_m**2


def has_many(context: Context) -> bool:
    """Whether the mission takes many robots for sure."""
    return context.bound.robots >= context.settings.districts.many_robots


def perfect_lanes(problem: Problem) -> float:
    """The robots that lanes would take which lose nothing at their ends or to whole robots."""
    swept_m2_s = problem.swath_m * problem.pace_m_s
    points = [region for region in problem.regions if region.demand == "every_point"]
    return float(sum(region.shape.area / (swept_m2_s * region.period_s) for region in points))


def fewest_on_large(context: Context, search: Method) -> Repaired:
    """The best plan for large ground (met unless all repair failed).

    Lanes first, which open ground needs no more robots than; among buildings tours over pieces. Then the best bound is
    proved. Where they take many more than that, every district is searched by itself as small ground is (``search``),
    at once, and the tours of all are repaired together.
    """
    problem, settings = context.problem, context.settings.districts
    lanes: Repaired | None
    if is_built_up(context):
        lanes = in_pieces(context)
        if lanes.met and not context.settings.team_size.searches_ragged:
            return lanes
    else:
        lanes = in_lanes(context)
    context = with_best_bound(context)
    lanes = None if lanes is None else claiming(lanes, context.bound)
    few = settings.enough * context.enough_robots
    if has_many(context):
        # no search spares a robot of lanes that take less than 15 % more than perfect ones
        few = max(few, 1.15 * max(context.enough_robots, perfect_lanes(problem)))
    if lanes is not None and (context.should_stop() or (lanes.met and lanes.robots <= few)):
        return lanes
    count = boxes_for(problem.asked_m2, settings.most_area * problem.reach_m**2)
    count = max(count, math.ceil(context.bound.robots / 10))  # so many share one district
    if count == 1:
        return better(lanes, search(context))
    missions = missions_of(problem.mission, count, AROUND * problem.robot.sensor.reach_m, where_robots_come(problem))
    if lanes is not None and lanes.met and sum(map(least_robots, missions)) >= lanes.robots:
        return lanes  # each district takes whole robots
    districts = by_districts(context, search, missions)
    if lanes is not None and context.should_stop():
        return lanes
    return better(lanes, repair_together(context, districts))


def least_robots(mission: Mission) -> int:
    """Robots below which no tours of one district's own can sweep it in time, were they to see over no border."""
    regions = [region for region in demanded_regions(mission) if region.demand == "every_point"]
    areas_m2, periods_s = [region.shape.area for region in regions], [region.period_s for region in regions]
    return area_rate_bound(areas_m2, periods_s, strongest_robot(mission.fleet))


def in_lanes(context: Context) -> Repaired | None:
    """The best plan of lanes over districts; None when no lane lies where a robot can be."""
    try:
        return sweep_with_fewest_robots(in_districts, context)
    except NoPlanFound:
        return None


def better(one: Repaired | None, other: Repaired) -> Repaired:
    """The one that is met; of two that are the one with fewer robots, the first of equals."""
    if one is None or (other.met and not one.met):
        return other
    if one.met and not other.met:
        return one
    return other if other.robots < one.robots else one


def repair_together(context: Context, districts: list[list[Tour]]) -> Repaired:
    """The tours of all districts repaired together, with more robots if it takes them."""
    exact = replace(context, problem=judge_by_lanes(context.problem))
    rounds, patient = context.settings.repair.rounds, context.settings.repair.patient_rounds
    whole = repair_until_feasible(exact, join(districts), no_points(), may_add=False, rounds=rounds)
    if whole.met or context.should_stop():
        return whole
    context.progress(0.9, "finishing with the robots that the repair asks for")
    return repair_until_feasible(exact, join(districts), no_points(), may_add=True, rounds=patient)

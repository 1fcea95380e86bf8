"""The search on large ground: lanes over districts; where these are far from the bound, districts one by one."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

from rota.errors import NoPlanFound
from rota.geometry.free_space import demanded_regions
from rota.mission import Mission
from rota.planners.patrol.bounds.area_bound import area_rate_bound
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.method_settings import DistrictSettings
from rota.planners.patrol.methods.large.cells import boxes_for, missions_of
from rota.planners.patrol.methods.large.lanes import in_districts
from rota.planners.patrol.methods.method import Method
from rota.planners.patrol.methods.sweeping.search import judged_by_lanes, sweep_with_fewest_robots
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour


def is_large(problem: Problem, settings: DistrictSettings) -> bool:
    """Whether so much ground must be seen, compared with what a robot sees at once, that it is planned in districts."""
    return asked_m2(problem) > settings.large_from * problem.reach_m**2


def asked_m2(problem: Problem) -> float:
    """Area of the ground that must be seen point by point."""
    return float(sum(region.shape.area for region in problem.regions if region.demand == "every_point"))


def fewest_on_large(context: Context, search: Method) -> Repaired:
    """The best plan for large ground (met unless all repair failed).

    Lanes first, which open ground needs no more robots than. Where they take many more than the bound, every district
    is searched by itself as small ground is (``search``), at once, and the tours of all are repaired together.
    """
    problem, settings = context.problem, context.settings.districts
    few = settings.enough * context.enough_robots
    lanes = in_lanes(context)
    if lanes is not None and (context.should_stop() or (lanes.met and lanes.robots <= few)):
        return lanes
    count = boxes_for(asked_m2(problem), settings.most_area * problem.reach_m**2)
    if count == 1:
        return better(lanes, search(context))
    missions = missions_of(problem.mission, count, settings.margin * problem.robot.sensor.reach_m)
    if lanes is not None and lanes.met and sum(map(least_robots, missions)) >= lanes.robots:
        return lanes  # each district takes whole robots
    return better(lanes, by_districts(context, search, missions))


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


def by_districts(context: Context, search: Method, missions: list[Mission]) -> Repaired:
    """Tours found for every district's mission by itself, repaired together, robots added if it takes them."""
    districts: list[list[Tour]] = []
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        seeds = range(context.seed, context.seed + len(missions))
        for tours in pool.map(partial(tours_of, context, search), missions, seeds):
            districts.append(tours)
            context.progress(
                0.3 + 0.6 * len(districts) / len(missions), f"{len(districts)} of {len(missions)} districts planned"
            )
    exact = replace(context, problem=judged_by_lanes(context.problem))
    whole = repair_until_feasible(
        exact, joined(districts), no_points(), may_add=False, rounds=context.settings.repair.rounds
    )
    if whole.met and whole.within_budgets:
        return whole
    context.progress(0.9, "finishing with the robots that the repair asks for")
    return repair_until_feasible(
        exact, joined(districts), no_points(), may_add=True, rounds=context.settings.repair.patient_rounds
    )


def tours_of(context: Context, search: Method, mission: Mission, seed: int) -> list[Tour]:
    """The tours that the search finds for one district, classes and parts as the whole problem numbers them.

    None where nobody can see enough of it from within: the repair of the whole will lead robots there.
    """
    try:
        problem = set_up_problem(mission)
    except NoPlanFound:
        return []
    bound = prove_bound(problem)
    alone = replace(
        context, problem=problem, bound=bound, enough_robots=bound.robots, seed=seed,
        progress=lambda share, what: None, watch=None,
    )  # fmt: skip
    whole = context.problem
    tours = []
    for tour in search(alone).tours:
        component = int(whole.paths.part_of(tour.vertices_m[:1])[0])
        period_class = whole.periods_s.index(problem.periods_s[tour.period_class])
        tours.append(replace(tour, period_class=period_class, component=max(component, 0)))
    return tours


def joined(districts: list[list[Tour]]) -> list[Tour]:
    """The tours of all districts, those that robots drive in turn numbered anew."""
    together: list[Tour] = []
    for tours in districts:
        first = 1 + max((tour.nest for tour in together), default=-1)
        together += [replace(tour, nest=tour.nest + first if tour.nest >= 0 else -1) for tour in tours]
    return together

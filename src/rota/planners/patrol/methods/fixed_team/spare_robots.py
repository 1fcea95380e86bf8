"""Fleets of more robots than it takes: those to spare help on the fullest tours, or stand aside."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import shapely
from shapely import LineString, MultiLineString

from rota.plan import Plan
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.allocation import starts
from rota.planners.patrol.methods.fewest import with_so_many
from rota.planners.patrol.methods.fixed_team.given_tours import busiest_helped, parts_short
from rota.planners.patrol.repair.repair import Settled, plan_of, settle
from rota.planners.patrol.tours.tour import Tour, driven
from rota.planners.patrol.verdict import touching


def with_spare_robots(context: Context, anyone: Context, robots: int, starting: Counter[int]) -> Plan | None:
    """A plan that passes in which fewer robots would do: the others help on the fullest tours, or stand aside."""
    problem = context.problem
    ways = starts(problem, context.work.groupings)
    least = max(context.bound.robots, 1)
    if least >= robots:
        return None
    some = np.linspace(robots - 1, least, min(robots - least, context.work.stretches))
    for fewer in (round(number) for number in some):
        if context.should_stop():
            return None
        found = with_so_many(anyone, ways, fewer, least_squeeze=context.work.least_squeeze)
        crowd = None if found is None else with_all_of(context, found, robots, starting)
        if crowd is not None:
            return crowd.plan
    return None


def with_all_of(context: Context, found: Settled, robots: int, starting: Counter[int]) -> Settled | None:
    """The settled plan with so many robots, spare ones helping or standing aside; None when it does not pass so."""
    if not (found.met and found.fits) or len(found.plan.trajectories) > robots:
        return None
    for tours in (helped(found.tours, robots, starting), stood_aside(context.problem, found.tours, robots)):
        if tours is None:
            continue
        plan = plan_of(context.problem, tours, seed=context.seed, bound=context.bound)
        verdict = context.judge(plan)
        if verdict.verdict == "met":
            return replace(found, tours=tours, plan=plan, verdict=verdict)
        if touching(verdict) is not None:
            apart = settle(context, tours, found.extra, may_add=False, rounds=context.work.repairs)
            if apart.met and len(apart.plan.trajectories) == robots:
                return apart
    return None


def helped(tours: list[Tour], robots: int, starting: Counter[int]) -> list[Tour]:
    """The tours with so many robots, the further ones where robots start and budgets are fullest."""
    tours = driven(tours)
    for _ in range(robots - sum(tour.robots for tour in tours)):
        tours = busiest_helped(tours, parts_short(tours, starting))
    return tours


def stood_aside(problem: Problem, tours: list[Tour], robots: int) -> list[Tour] | None:
    """The tours and further robots that stay where none on a tour comes past; None when there is no such room."""
    wide_m = 2 * problem.robot.body_radius_m * (1 + 1e-6)
    routes = [LineString(np.vstack([tour.vertices_m, tour.vertices_m[:1]])) for tour in tours]
    free_m = shapely.distance(MultiLineString(routes), shapely.points(problem.viewpoints.xy_m))
    tours = driven(tours)
    slowest = max(tours, key=lambda tour: tour.period_s)
    while sum(tour.robots for tour in tours) < robots:
        i = int(np.argmax(free_m))
        if free_m[i] < wide_m:
            return None
        place_m = problem.viewpoints.xy_m[i : i + 1]
        component = int(problem.viewpoints.component[i])
        tours.append(replace(slowest, vertices_m=place_m, robots=1, component=component, pace=None))
        free_m = np.minimum(free_m, np.hypot(*(problem.viewpoints.xy_m - place_m).T))
    return tours

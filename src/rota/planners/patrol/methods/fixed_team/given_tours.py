"""A fleet with a fixed number of robots: spare robots join the busiest tours; too few of them are told so."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from rota.errors import NoPlanFound
from rota.geometry.free_space import nearest_free_point
from rota.mission import Mission
from rota.plan import Plan
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.repair.repair import Settled, plan_of, settle
from rota.planners.patrol.tours.tour import Tour, driven, tour_length_m
from rota.planners.patrol.verdict import counted, touching, worst_reached


def plan_for_fixed_fleet(context: Context, fewest: Settled, asked: Mission) -> Plan:
    """The plan for exactly the fleet's robots, from one with as few as possible; NoPlanFound when they are too few.

    asked: the mission with the robots' starts, which bind spare robots to parts of the ground.
    """
    problem = context.problem
    fleet = problem.mission.fleet.robots
    assert fleet is not None
    found = driven(fewest.tours)
    needed = sum(tour.robots for tour in found)
    if needed <= len(fleet):
        tours = found
        starting = parts_started_in(problem, asked)
        for _ in range(len(fleet) - needed):
            tours = busiest_helped(tours, parts_short(tours, starting))
        plan = plan_of(problem, tours, seed=context.seed, bound=context.bound)
        verdict = context.judge(plan)
        if verdict.verdict == "met":
            return plan
        if touching(verdict) is not None:
            apart = settle(context, tours, fewest.extra, may_add=False, rounds=context.work.repairs)
            if apart.met and len(apart.plan.trajectories) == len(fleet):
                return apart.plan
        reason = f"the plan for {len(fleet)} robots does not pass the check: {worst_reached(verdict)}"
        raise NoPlanFound(reason, best=plan)
    parts = {tour.component for tour in found}
    proved = proved_words(context)
    reason = f"{counted(len(fleet))} cannot meet the demand: {proved}; found: {needed} can"
    if len(parts) > len(fleet):
        some = plan_of(
            problem, [replace(tour, robots=1) for tour in found[: len(fleet)]], seed=context.seed, bound=context.bound
        )
        raise NoPlanFound(
            f"{reason}; the ground falls into {len(parts)} parts between which no robot can travel, and each must be"
            f" watched by a robot of its own; with {counted(len(fleet))} {worst_reached(context.judge(some))}",
            best=some,
        )
    tours = with_so_many(problem, found, len(fleet))
    plan = plan_of(problem, tours, seed=context.seed, bound=context.bound)
    verdict = context.judge(plan)
    if verdict.verdict == "met":
        return plan
    raise NoPlanFound(f"{reason}; with {counted(len(fleet))} {worst_reached(verdict)}", best=plan)


def parts_started_in(problem: Problem, asked: Mission) -> Counter[int]:
    """How many robots have a start of their own in each component of the ground."""
    own_m = [robot.start for robot in asked.fleet.robots or () if robot.start is not None]
    free_m = [nearest_free_point(problem.space, place_m) for place_m in own_m]
    return Counter(int(component) for component in problem.paths.part_of(np.array(free_m).reshape(-1, 2)))


def parts_short(tours: list[Tour], starting: Counter[int]) -> set[int]:
    """The parts whose tours have fewer robots than start there; all with tours when there is none."""
    parts = {tour.component for tour in tours}
    robots = {component: sum(tour.robots for tour in tours if tour.component == component) for component in parts}
    return {component for component in parts if robots[component] < starting[component]} or parts


def busiest_helped(tours: list[Tour], parts: set[int] | None = None) -> list[Tour]:
    """The tours with one robot more on the one whose budget is fullest, of those in these parts of the ground."""
    some = [i for i, tour in enumerate(tours) if parts is None or tour.component in parts]
    k = max(some, key=lambda i: tour_length_m(tours[i]) / tours[i].budget_m)
    return [*tours[:k], replace(tours[k], robots=tours[k].robots + 1), *tours[k + 1 :]]


def with_so_many(problem: Problem, tours: list[Tour], robots: int) -> list[Tour]:
    """The tours served by so many robots, fewer than they need: tours are joined until each has a robot.

    Only tours of one component are joined. ``robots`` is at least the number of components. The robots go
    where the ratio of round time to period is worst.
    """
    tours = [replace(tour, robots=1) for tour in tours]
    while len(tours) > robots:
        pairs = [
            (tour_length_m(a) + tour_length_m(b), i, j)
            for i, a in enumerate(tours)
            for j, b in enumerate(tours[:i])
            if a.component == b.component
        ]
        _, i, j = min(pairs)
        one = joined_tour(problem, tours[i], tours[j])
        tours = [tour for k, tour in enumerate(tours) if k not in (i, j)] + [one]
    for _ in range(robots - len(tours)):
        tours = busiest_helped(tours)
    return tours


def joined_tour(problem: Problem, a: Tour, b: Tour) -> Tour:
    """One tour that goes round both, changing over where they are nearest, at the shorter of the two periods."""
    apart = problem.paths.distances(a.vertices_m, b.vertices_m)
    i, j = (int(k) for k in np.unravel_index(int(np.argmin(apart)), apart.shape))
    first = np.vstack([np.roll(a.vertices_m, -i, axis=0), a.vertices_m[i : i + 1]])
    second = np.vstack([np.roll(b.vertices_m, -j, axis=0), b.vertices_m[j : j + 1]])
    way = problem.paths.paths_along(np.vstack([first, second, first[:1]]))[:-1]
    quick = a if a.period_class <= b.period_class else b
    return replace(quick, vertices_m=way, robots=1, pace=None)


def proved_words(context: Context) -> str:
    """The bound on the number of robots, and its proof."""
    return f"proved: at least {counted(max(context.bound.robots, 1))} ({context.bound.reason})"

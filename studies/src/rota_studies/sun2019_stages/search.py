"""The fewest robots of the method: deployments and frames in turn, cut for fewer and fewer robots, repaired, judged.

The paper stops at routes that Eq. 26 says are short enough. Here the check judges them: routes are led to what they
leave unseen (``repair.repair_until_feasible``), and where this makes them too long, the frame is cut for more robots.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.repair.repair import Repaired, plan_of, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota_studies.sun2019_stages.algorithms import Algorithms
from rota_studies.sun2019_stages.stages import Framed, Stages, cut_in_segments, framed_sensors, measure


def fewest_robots_by_stages(context: Context, algorithms: Algorithms) -> Repaired:
    """The best repaired plan of the method; it is met unless all repair failed.

    Each frame is cut for as many robots as Eq. 26 asks for, then
    for fewer and fewer while the check passes. When it never passes, the first frame is cut for more robots, which
    leaves every route a margin. With routes as printed there is one plan, as it comes. Raises NoPlanFound for square
    sensors, and when none of what is asked can be seen.
    """
    sensor = context.problem.robot.sensor
    if not isinstance(sensor, DiscSensor):
        raise NoPlanFound(
            f"fleet.sensor: a square of side {sensor.side_m:.6g} m cannot be used with patrol.method sun2019, which is"
            " made for discs; give shape: disc and a radius_m, or another method"
        )
    problem = context.problem
    best: Repaired | None = None
    first: Framed | None = None
    # covers have no chance in them, but the tours past their places have
    turns = range(context.settings.multistart.seeds)
    ways = [(turn, deploy) for turn in turns for deploy in algorithms.deployments]
    for k, (turn, deploy) in enumerate(ways):
        turn_context = replace(context, progress=progress_of_turn(context.progress, k, len(ways)))
        turn_context.progress(0.0, f"deploying sensors ({deploy.method}) and finding a frame past them")
        seed = context.seed + 1000 * turn
        framed = framed_sensors(problem.mission, problem.paths, deploy, algorithms, seed=seed)
        first = first or framed
        if algorithms.routes == "printed":
            return plan_as_printed(context, framed, algorithms)
        best = reduce_team(turn_context, framed, algorithms, best)
        if context.should_stop() or (is_good(best) and robots_of(best) <= context.enough_robots):
            break
    assert best is not None
    assert first is not None
    return best if is_good(best) or context.should_stop() else search_upwards(context, first, algorithms, best)


def progress_of_turn(progress: Callable[[float, str], None], turn: int, turns: int) -> Callable[[float, str], None]:
    """Progress within one of ``turns`` turns, of which the last ends at 0.9."""
    return lambda share, what: progress(0.9 * (turn + share) / turns, what)


def reduce_team(context: Context, framed: Framed, algorithms: Algorithms, best: Repaired | None) -> Repaired:
    """The plan with the fewest robots that this frame gives, or the best so far if that has no more.

    Routes are shorter than Eq. 26 has them where lanes meet borders, and lanes may lie farther apart than sensors do
    (measured on the paper's cases, shortened: loads up to 1.28 came to pass, nothing from 1.30 to 1.66).
    """
    stages = cut(context, framed, algorithms, None)
    if best is not None and is_good(best):
        stages = cut(context, framed, algorithms, min(len(stages.segments), robots_of(best) - 1))
    robots = len(stages.segments)
    while best is None or (stages.load <= 1.4 and not context.should_stop()):
        context.progress(0.5, f"leading {robots} robots round their segments")
        plan = repaired_routes(context, stages, algorithms)
        if not is_better(plan, best):
            return best if best is not None else plan
        best = plan
        least = max(len(framed.parts), context.enough_robots)
        if not is_good(plan) or min(robots, robots_of(plan)) <= least:
            break
        robots = min(robots, robots_of(plan)) - 1
        stages = cut(context, framed, algorithms, robots)
    return best


def search_upwards(context: Context, framed: Framed, algorithms: Algorithms, best: Repaired) -> Repaired:
    """A plan of up to eight robots more than the partition asks for; at last, of as many as repair asks for."""
    first = len(cut(context, framed, algorithms, None).segments)
    for robots in range(first + 1, first + 9):
        if context.should_stop():
            return best
        context.progress(0.9, f"leading {robots} robots round their segments")
        plan = repaired_routes(context, cut(context, framed, algorithms, robots), algorithms)
        best = plan if is_better(plan, best) else best
        if is_good(best):
            return best
    context.progress(0.9, "finishing with the robots that the repair asks for")
    tours = tours_of(context.problem, cut(context, framed, algorithms, None))
    last = repair_until_feasible(context, tours, no_points(), may_add=True, rounds=3 * context.settings.repair.rounds)
    return last if is_better(last, best) else best


def cut(context: Context, framed: Framed, algorithms: Algorithms, robots: int | None) -> Stages:
    """The frames cut for ``robots`` robots, or for as many as Eq. 26 asks for."""
    return cut_in_segments(framed, context.problem.robot, context.problem.paths, algorithms, robots=robots)


def repaired_routes(context: Context, stages: Stages, algorithms: Algorithms) -> Repaired:
    """The routes repaired until the check passes or the rounds are over.

    Routes that become too long by that are shortened, or the frame is cut anew by their lengths, up to four times.
    Where that does not help, they get a further robot.
    """
    tours, rounds = tours_of(context.problem, stages), context.settings.repair.rounds
    if algorithms.routes == "shortened":
        return repair_until_feasible(context, tours, no_points(), may_add=False, rounds=rounds)
    robots = len(stages.segments)
    best = repair_until_feasible(context, tours, no_points(), may_add=True, rounds=rounds)
    plan = best
    for _ in range(4):
        if (best.met and robots_of(best) <= robots) or context.should_stop() or len(plan.tours) < robots:
            break
        driven_m = np.array([tour_length_m(tour) for tour in plan.tours[:robots]])
        stages = cut(context, measure(stages, driven_m, context.problem.robot), algorithms, robots)
        plan = repair_until_feasible(
            context, tours_of(context.problem, stages), no_points(), may_add=True, rounds=rounds
        )
        best = plan if is_better(plan, best) else best
    return best


def plan_as_printed(context: Context, framed: Framed, algorithms: Algorithms) -> Repaired:
    """The plan of the routes as they are, judged."""
    tours = tours_of(context.problem, cut(context, framed, algorithms, None))
    plan = plan_of(context.problem, tours, seed=context.seed, bound=context.bound)
    return Repaired(tours=tours, plan=plan, verdict=context.judge(plan), extra=no_points())


def tours_of(problem: Problem, stages: Stages) -> list[Tour]:
    """The segments' routes as tours of a robot each, which serve what has the segment's period or a longer one."""
    period_classes = [
        int(np.argmin(np.abs(np.array(problem.periods_s) - segment.period_s))) for segment in stages.segments
    ]
    return [
        Tour(
            vertices_m=segment.route_m, period_class=k, period_s=problem.periods_s[k], robots=1, robot=problem.robot,
            component=segment.part,
        )
        for k, segment in zip(period_classes, stages.segments, strict=True)
    ]  # fmt: skip


def is_good(repaired: Repaired) -> bool:
    """Whether the plan passed, and no route is longer than its period allows."""
    return repaired.met and repaired.within_budgets


def is_better(plan: Repaired, best: Repaired | None) -> bool:
    """Whether a plan is better than the best so far: one that passes, then fewer robots."""
    if best is None or not is_good(plan):
        return best is None
    return not is_good(best) or robots_of(plan) < robots_of(best)


def robots_of(repaired: Repaired) -> int:
    """The robots of all its tours."""
    return sum(tour.robots for tour in repaired.tours)

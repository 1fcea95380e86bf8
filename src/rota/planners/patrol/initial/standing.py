"""Robots that stand: where a period is so short that moving gains next to nothing, as few places as see everything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.annealing.search import Annealing, budget_penalties
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import lay_out
from rota.planners.patrol.ground.viewpoints import choose_viewpoints
from rota.planners.patrol.tours.tour import Tour


def robots_stand(problem: Problem, period_s: float) -> bool:
    """Whether a robot can hardly move within so many seconds, no farther than it sees from where it is."""
    return problem.pace_m_s * period_s <= problem.reach_m


def tour_of_one(problem: Problem, vertices_m: Floats, period_class: int, component: int) -> Tour:
    """The closed tour (n, 2) of a single robot of the problem."""
    return Tour(
        vertices_m=vertices_m, period_class=period_class, period_s=problem.periods_s[period_class], robots=1,
        robot=problem.robot, component=component,
    )  # fmt: skip


def standing_tours(problem: Problem, wanted: Flags, period_class: int) -> list[Tour]:
    """Tours of one place each, or hardly more, that together see all wanted samples (s,) of the problem.

    The number of the greedy cover is halved until annealed places no longer see everything, then what lies between is
    searched. Their number is not proved to be the least.
    """
    chosen, _ = choose_viewpoints(problem.viewpoints.start, problem.viewpoints.seen, wanted, problem.points.area_m2)
    tours = [
        tour_of_one(problem, problem.viewpoints.xy_m[k][None], period_class, int(problem.viewpoints.component[k]))
        for k in chosen
    ]
    least, most = max(1, len(tours) // 2), len(tours)
    best = tours
    while least < most:
        few = (least + most) // 2
        fewer = move_until_all_is_seen(problem, tours[:few], wanted)
        if fewer is None:
            least = few + 1
        else:
            best, most = fewer, few
    return best


def move_until_all_is_seen(problem: Problem, tours: list[Tour], wanted: Flags) -> list[Tour] | None:
    """The tours moved until they see all wanted samples; None when annealing does not get there."""
    points, samples, _ = lay_out(problem.points[wanted], problem.walls, problem.robot)
    # seeing a sample is worth more than any way within the budgets
    weight = 1.0 + points.area_m2 / points.area_m2.mean()
    search = Annealing(
        tours,
        samples._replace(weight=problem.reach_m * weight),
        problem.paths.grid,
        length_weight=np.full(len(tours), 1e-3),
        budget_penalty=budget_penalties(tours, 4.0 * len(points)),
        seed=len(tours),
        range_margin_m=problem.range_margin_m,
    )
    moves = min(400_000, 4_000 * len(tours))  # so many for each robot
    search.run(moves, hot_m=4 * problem.reach_m, cold_m=0.05 * problem.reach_m, should_stop=lambda: False)
    if search.unseen or search.over_budget_share > 0:
        return None
    component = problem.paths.part_of(np.array([tour.vertices_m[0] for tour in search.tours]))
    return [replace(tour, component=int(k)) for tour, k in zip(search.tours, component, strict=True)]

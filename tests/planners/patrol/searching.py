"""A small mission and the searches that tests begin on missions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.bounds.best_bound import prove_bound, prove_by_area
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context, begin_search
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.planner import Request

YARD = Mission(
    name="yard", area=MultiPolygon([box(0, 0, 30, 20)]), obstacles=(Obstacle(shape=MultiPolygon([box(8, 5, 12, 9)])),),
    period_s=60, fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


def search_on(ground: Mission | Problem, prove: Callable[[Problem], ProvedBound] = prove_bound) -> Context:
    """A search with seed 0 that tells nobody and is not stopped; the check judges."""
    problem = set_up_problem(ground) if isinstance(ground, Mission) else ground
    request = Request(
        mission=problem.mission, seed=0, judge=check_plan, progress=lambda _share, _what: None,
        should_stop=lambda: False,
    )  # fmt: skip
    return begin_search(problem, request, prove)


def cheap_search_on(ground: Mission | Problem) -> Context:
    """The same with the bound of the area alone, where no more is asked than what a search knows."""
    return search_on(ground, prove_by_area)


def hasty_search_on(ground: Mission | Problem) -> Context:
    """The same with so few moves that it takes seconds."""
    context = search_on(ground)
    own = context.settings
    few = replace(
        own,
        screening=replace(own.screening, moves=2_000),
        annealing=replace(own.annealing, moves=30_000),
        alternation=replace(own.alternation, annealings=3, moves=20_000),
    )
    return replace(context, settings=few)

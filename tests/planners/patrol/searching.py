"""A small mission and the searches that tests begin on missions."""

from __future__ import annotations

from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.context import Context, begin_search
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings

YARD = Mission(
    name="yard", area=MultiPolygon([box(0, 0, 30, 20)]), obstacles=(Obstacle(shape=MultiPolygon([box(8, 5, 12, 9)])),),
    period_s=60, fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


def search_on(ground: Mission | Problem) -> Context:
    """A search with seed 0 that tells nobody and is not stopped; the check judges."""
    problem = set_up_problem(ground) if isinstance(ground, Mission) else ground
    return begin_search(
        problem, asked=problem.mission, seed=0, judge=check_plan, progress=lambda _share, _what: None,
        should_stop=lambda: False,
    )  # fmt: skip

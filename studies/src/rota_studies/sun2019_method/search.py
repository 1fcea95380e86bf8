"""The search by the stages that a mission asks for."""

from __future__ import annotations

from rota.planners.patrol.context import Context
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired
from rota_studies.sun2019_method.algorithms import algorithms_of
from rota_studies.sun2019_method.mission_settings import Sun2019
from rota_studies.sun2019_stages.search import fewest_robots_by_stages


def search_by_stages(context: Context) -> Repaired:
    """The plan with the fewest robots that the stages come to, done by whom the mission names."""
    planning = PatrolSettings.of(context.problem.mission)
    assert isinstance(planning.method_settings, Sun2019)
    return fewest_robots_by_stages(context, algorithms_of(planning.method_settings, planning.effort))

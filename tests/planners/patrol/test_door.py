"""The door of patrol: what it tells without planning."""

from __future__ import annotations

import rota
from rota.planner import planner_named
from rota.planners.patrol import PatrolPlanner


def test_the_bound_proved_without_planning_is_the_plan_s() -> None:
    mission = PatrolPlanner().small_mission()
    plan = rota.make_plan(mission)
    assert PatrolPlanner().proved_bound(mission) == (plan.lower_bound_robots, plan.lower_bound_reason)


def test_other_planners_prove_nothing() -> None:
    assert planner_named("swarm").proved_bound(PatrolPlanner().small_mission()) is None

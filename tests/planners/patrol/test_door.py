"""The door of patrol: what it tells without planning."""

from __future__ import annotations

from benchmarks.random_missions import random_mission

import rota
from rota.files.plan_file import plan_text
from rota.planners.patrol import PatrolPlanner
from rota.planning.make_plan import search_plan
from rota.planning.planner import planner_named


def test_the_bound_proved_without_planning_is_the_plan_s() -> None:
    mission = PatrolPlanner().small_mission()
    plan = rota.make_plan(mission)
    assert PatrolPlanner().proved_bound(mission) == (plan.lower_bound_robots, plan.lower_bound_reason)


def test_a_hasty_bound_proves_no_more() -> None:
    mission = random_mission(0)  # tours prove three robots
    hasty, proved = PatrolPlanner().hasty_bound(mission), PatrolPlanner().proved_bound(mission)
    assert (hasty[0], proved[0]) == (2, 3)


def test_other_planners_prove_nothing() -> None:
    assert planner_named("swarm").proved_bound(PatrolPlanner().small_mission()) is None


def test_who_looks_on_is_shown_lanes_first_and_gets_the_same_plan() -> None:
    mission = PatrolPlanner().small_mission().with_method("tours")
    told: list[str] = []
    search = search_plan(
        mission,
        on_better=lambda _plan, report: told.append(report.verdict),
        progress=lambda _, doing: told.append(doing),
    )
    assert told.index("sweeping in lanes") < told.index("met")
    assert plan_text(search.plan) == plan_text(rota.make_plan(mission))


def test_lanes_with_as_few_robots_as_are_proved_are_the_plan() -> None:
    mission = PatrolPlanner().small_mission().with_method("tours")
    told: list[str] = []
    search = search_plan(mission, progress=lambda _, doing: told.append(doing))
    assert len(search.plan.trajectories) == search.plan.lower_bound_robots == 1
    assert not any(doing.startswith("trying") for doing in told)

"""The reserve: a plan passes the check as if periods were shorter and sensors near-sighted; turns are in the budget."""

from dataclasses import replace
from typing import Any

import pytest
from shapely import MultiPolygon, box

import rota
from rota.check import Report, check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, SquareSensor, StartBox, Zone
from rota.model.plan import Plan
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.margins import shorter_sensor, with_reserve
from rota.planners.patrol.planner import plan_patrol
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.make_plan import search_plan
from rota.planning.plan_summary import approach_sentence
from rota.planning.planner import Request


def court(turn: float | None = None, **settings: Any) -> Mission:
    return Mission(
        name="court",
        area=MultiPolygon([box(0, 0, 15, 12)]),
        zones=(Zone(name="gate", shape=MultiPolygon([box(0, 0, 4, 4)]), period_s=20),),
        period_s=40,
        fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=3), turn_rate_rad_s=turn),
        planning=PatrolSettings(effort="quick", **settings),
    )


def test_the_tightened_mission_is_met_and_the_bound_is_that_of_the_mission_as_asked() -> None:
    mission = court(period_margin=0.2, range_margin_m=0.5)
    plan = rota.make_plan(mission)
    assert plan.mission == mission
    # written out by hand: 0.8 of the periods, 0.5 m less of the radius
    tight = replace(
        mission,
        period_s=32,
        zones=(replace(mission.zones[0], period_s=16),),
        fleet=replace(mission.fleet, sensor=DiscSensor(radius_m=2.5)),
        planning=PatrolSettings(effort="quick"),
    )
    assert check_plan(replace(plan, mission=tight)).verdict == "met"
    assert check_plan(plan).verdict == "met"
    assert plan.lower_bound_robots == prove_bound(set_up_problem(court())).robots
    assert with_reserve(mission).zones[0].period_s == pytest.approx(16)
    assert with_reserve(court()) == court()


def test_sensors_lose_the_margin_on_every_side() -> None:
    assert shorter_sensor(DiscSensor(radius_m=3), 0.2) == DiscSensor(radius_m=2.8)
    assert shorter_sensor(SquareSensor(side_m=3), 0.2) == SquareSensor(side_m=2.6)


@pytest.mark.parametrize(("field", "value"), [("period_margin", 1.0), ("period_margin", -0.1), ("range_margin_m", 3.0)])
def test_margins_that_leave_nothing_are_refused(field: str, value: float) -> None:
    with pytest.raises(rota.MissionError, match=f"patrol.{field}: {value:g} is not allowed"):
        court(**{field: value})


def test_turning_robots_from_a_box_keep_the_reserve_as_the_check_judges_them() -> None:
    slow = court(turn=0.8, period_margin=0.05)
    slow = replace(slow, fleet=replace(slow.fleet, start=StartBox(low_m=(0, 0), high_m=(2, 2))))
    plan = rota.make_plan(slow)
    report = check_plan(plan)
    assert report.verdict == "met"
    assert not report.violations
    for demand in report.demands:
        assert demand.worst_gap_s <= 0.95 * demand.period_s * (1 + 1e-9)
    assert all(trajectory.loop_start_s > 0 for trajectory in plan)
    # a plan made without turns in mind breaks the turn rate, so the check does look at it
    quick = rota.make_plan(court(method="parallel"))
    hasty = replace(quick, mission=court(turn=0.8))
    assert {violation.kind for violation in check_plan(hasty).violations} == {"turn"}


@pytest.mark.parametrize("method", ["parallel", "sequential", "decomposition"])
def test_traditional_methods_keep_the_reserve_and_begin_at_the_starts(method: str) -> None:
    start = StartBox(low_m=(0, 0), high_m=(2, 2))
    mission = court(turn=2.0, method=method, period_margin=0.1, range_margin_m=0.4)
    mission = replace(mission, fleet=replace(mission.fleet, start=start))
    found = search_plan(mission)
    assert found.report.verdict == "met"
    tight = replace(
        mission,
        period_s=36,
        zones=(replace(mission.zones[0], period_s=18),),
        fleet=replace(mission.fleet, sensor=DiscSensor(radius_m=2.6)),
        planning=PatrolSettings(effort="quick"),
    )
    assert check_plan(replace(found.plan, mission=tight)).verdict == "met"
    assert PatrolSettings.of(found.plan.mission).method == method
    assert all(max(trajectory.positions_m[0]) <= 2 for trajectory in found.plan)
    begins_s = found.plan.trajectories[0].loop_start_s
    assert approach_sentence(found.plan) == f"All robots are on their loops {begins_s:.1f} s after they set out."


def test_ground_that_only_the_full_reach_sees_is_not_lost_in_silence() -> None:
    mission = court(method="sequential", range_margin_m=0.4)

    def judge(plan: Plan) -> Report:
        report = check_plan(plan)
        return replace(report, verdict="violated") if plan.mission == mission else report

    with pytest.raises(rota.NoPlanFound, match=r"patrol.range_margin_m: 0.4 hides ground .*; give less") as caught:
        plan_patrol(
            Request(mission=mission, seed=0, judge=judge, progress=lambda share, doing: None, should_stop=lambda: False)
        )
    assert isinstance(caught.value.best, Plan)
    assert caught.value.best.mission == mission

"""The reserve: a plan passes the check as if periods were shorter and sensors near-sighted; turns are in the budget."""

from dataclasses import replace

import pytest
from shapely import MultiPolygon, box

import rota
from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, PatrolSettings, SquareSensor, StartBox, Zone
from rota.planners.patrol.asked import shorter_sensor, with_reserve
from rota.planners.patrol.problem import set_up_problem


def court(turn: float | None = None, **settings: float) -> Mission:
    return Mission(
        name="court",
        area=MultiPolygon([box(0, 0, 20, 16)]),
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
    assert plan.lower_bound_robots == set_up_problem(court()).lower_bound
    assert with_reserve(mission).zones[0].period_s == pytest.approx(16)
    assert with_reserve(court()) is not None
    assert with_reserve(court()) == court()


def test_sensors_lose_the_margin_on_every_side() -> None:
    assert shorter_sensor(DiscSensor(radius_m=3), 0.2) == DiscSensor(radius_m=2.8)
    assert shorter_sensor(SquareSensor(side_m=3), 0.2) == SquareSensor(side_m=2.6)


@pytest.mark.parametrize(("field", "value"), [("period_margin", 1.0), ("period_margin", -0.1), ("range_margin_m", 3.0)])
def test_margins_that_leave_nothing_are_refused(field: str, value: float) -> None:
    with pytest.raises(rota.MissionError, match=f"patrol.{field}: {value}"):
        court(**{field: value})


def test_turning_robots_keep_their_periods_as_the_check_judges_them() -> None:
    quick, slow = rota.make_plan(court()), rota.make_plan(court(turn=0.8, period_margin=0.05))
    report = check_plan(slow)
    assert report.verdict == "met"
    assert not report.violations
    for demand in report.demands:
        assert demand.worst_gap_s <= 0.95 * demand.period_s
    # a plan made without turns in mind breaks the turn rate, so the check does look at it
    hasty = replace(quick, mission=slow.mission)
    assert {violation.kind for violation in check_plan(hasty).violations} == {"turn"}


def test_a_reserve_and_starts_together() -> None:
    mission = court(period_margin=0.1)
    mission = replace(mission, fleet=replace(mission.fleet, start=StartBox(low_m=(0, 0), high_m=(2, 2))))
    plan = rota.make_plan(mission)
    report = check_plan(plan)
    assert report.verdict == "met"
    assert all(demand.worst_gap_s <= 0.9 * demand.period_s * (1 + 1e-9) for demand in report.demands)
    assert all(trajectory.loop_start_s > 0 for trajectory in plan)

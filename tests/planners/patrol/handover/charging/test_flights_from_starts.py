"""Robots that charge come from their starts into flights: closed forms by hand, and missions as users write them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import box
from tests.relieved import FLIGHT_S, relieved, with_battery

from rota import DiscSensor, Fleet, Mission, NoPlanFound, PatrolSettings, Plan, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, StartBox, StartPoints
from rota.model.plan import Charge, Trajectory
from rota.planners.patrol.handover.charging.flights_from_starts import _waiting, lead_to_flights

BATTERY = BatteryLimits(endurance_s=600, recharge_s=300)
HALL = Mission(
    name="hall", area=box(0, 0, 40, 24), period_s=90,
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), battery=BATTERY),
    chargers=(Charger(name="wall", at=(2, 2), places=4),), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


def begun_at(plan: Plan, *points: tuple[float, float]) -> Plan:
    """The plan's flights, reached from these points."""
    fleet = replace(plan.mission.fleet, start=StartPoints(points_m=points))
    return lead_to_flights(plan, replace(plan.mission, fleet=fleet), check_plan)


def test_robots_come_into_their_flights_from_where_they_stand() -> None:
    plan = relieved(2)
    led = begun_at(plan, (20, 25), (-4, -4))
    assert {tuple(one.positions_m[0].tolist()) for one in led} == {(20.0, 25.0), (-4.0, -4.0)}
    report = check_plan(led)
    assert report.verdict == "met"
    # the one on the loop first is 5 m from it, the other lands on the pad, sqrt(32) m away, or goes on to the loop
    assert 0 < min(one.loop_start_s for one in led) <= 5 * (1 + 1e-3) + 1
    assert report.holds_from_s < FLIGHT_S
    assert [one.loop_duration_s for one in led] == [one.loop_duration_s for one in plan]


def test_of_more_starts_than_robots_the_nearest_serve_and_fewer_are_refused() -> None:
    plan = relieved(2)
    led = begun_at(plan, (39, 29), (20, 0), (10, 10), (39, 28))
    assert len(led) == 2
    with pytest.raises(
        NoPlanFound, match=r"the plan needs 2 robots, but fleet.start has only 1 of the points"
    ) as found:
        begun_at(plan, (0, 0))
    assert isinstance(found.value.best, Plan)


def test_a_battery_too_small_for_the_way_is_refused() -> None:
    plan = with_battery(relieved(2), reserve_s=0.0)
    mission = replace(plan.mission, area=box(-400, -5, 40, 30), period_s=900.0)
    with pytest.raises(NoPlanFound, match="reach neither their flights nor a charger in time"):
        begun_at(replace(plan, mission=mission), (-399, 0), (-398, 0))  # 388 m and more of 400


@pytest.mark.parametrize(
    "turning",
    [
        {"turn_rate_rad_s": 0.5},
        pytest.param({}, marks=pytest.mark.slow),
        pytest.param({"turn_radius_m": 1.5}, marks=pytest.mark.slow),
    ],
)
def test_as_few_robots_serve_from_a_box_as_from_anywhere(turning: dict[str, float]) -> None:
    anywhere = replace(HALL, fleet=replace(HALL.fleet, **turning))
    boxed = replace(anywhere, fleet=replace(anywhere.fleet, start=StartBox(low_m=(30, 18), high_m=(38, 23))))
    plan, free = make_plan(boxed, seed=0), make_plan(anywhere, seed=0)
    assert len(plan) == len(free)
    assert plan.mission == boxed
    assert check_plan(plan).verdict == "met"
    places_m = np.array([one.positions_m[0] for one in plan])
    assert ((places_m >= (30, 18)) & (places_m <= (38, 23))).all()


def test_named_robots_begin_where_each_is_told_and_others_on_a_charger() -> None:
    team = tuple(
        replace(HALL.fleet.equal_robot(name), start=at)
        for name, at in (("a", (30.0, 20.0)), ("b", None), ("c", (5.0, 20.0)))
    )
    mission = replace(HALL, fleet=replace(HALL.fleet, robots=team))
    plan = make_plan(mission, seed=0)
    assert [plan[name].positions_m[0].tolist() for name in "abc"] == [[30, 20], [2, 2], [5, 20]]
    assert check_plan(plan).verdict == "met"


@pytest.mark.slow  # a whole search
def test_robots_parked_side_by_side_set_out_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = make_plan(replace(HALL, fleet=replace(HALL.fleet, body_radius_m=0.3), period_s=60), seed=0)
    parked = tuple((38.5, 2.0 + 0.63 * k) for k in range(len(plan)))
    led = begun_at(plan, *parked)
    assert {tuple(one.positions_m[0].tolist()) for one in led} == set(parked)
    assert check_plan(led).verdict == "met"
    monkeypatch.setattr("rota.planners.patrol.handover.charging.flights_from_starts.set_out_in_turn", lambda *_: [])
    with pytest.raises(NoPlanFound, match="with the ways from the starts the plan does not pass the check: no way was"):
        begun_at(plan, *parked)


@pytest.mark.parametrize(
    ("battery", "waits_s"),
    [
        # 10 s to the pad, charged again in 5; it turns in 1 s
        (BatteryLimits(endurance_s=600, recharge_s=300, standing_endurance_s=1e9), 100 - 5 - 1),
        # and what it takes where it waits is charged again in half of that time
        (BatteryLimits(endurance_s=600, recharge_s=300), (100 - 5 - 1) / 1.5),
    ],
)
def test_who_has_time_to_spare_on_a_charger_waits_at_its_start(battery: BatteryLimits, waits_s: float) -> None:
    robot = replace(HALL.fleet, battery=battery).equal_robot("a")
    way = Trajectory(
        robot="a", times_s=[0, 10, 110, 120, 140], positions_m=[[12, 2], [2, 2], [2, 2], [12, 2], [2, 2]],
        charges=(Charge(charger="wall", from_s=10, until_s=110),), loop_start_s=110,
    )  # fmt: skip
    later = _waiting(way, robot, HALL)
    assert later.times_s.tolist() == pytest.approx([0, waits_s, 10 + waits_s, 110, 120, 140])
    assert later.charges[0].from_s == pytest.approx(10 + waits_s)
    assert later.charges[0].until_s == 110
    hasty = replace(
        way, times_s=[0, 10, 15, 25, 45], charges=(Charge(charger="wall", from_s=10, until_s=15),), loop_start_s=15
    )
    assert _waiting(hasty, robot, HALL) is hasty
    wing = replace(robot, battery=replace(battery, standing_endurance_s=0))
    assert _waiting(way, wing, HALL) is way

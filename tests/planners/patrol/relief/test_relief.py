"""Plans of robots that charge: how many robots they take, by closed forms, and that the check passes them."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import YARD

from rota import check_plan, make_plan, search_plan
from rota.check.report import Report
from rota.errors import NoPlanFound
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan
from rota.planners.patrol import PatrolSettings
from rota.planners.patrol.bounds.charging_bound import charging_of
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.relief.relieve import endless, relieve
from rota.planning.planner import Request

# a corridor as wide as the sensor sees: one robot goes to and fro, past the charger in its middle
CORRIDOR = Mission(
    name="corridor",
    area=MultiPolygon([box(0, 0, 200, 10)]),
    period_s=50,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=10), battery=BatteryLimits(endurance_s=500, recharge_s=1000)),
    chargers=(Charger(name="pad", at=(100, 5), places=9),),
    planning=PatrolSettings(effort="quick"),
)


def with_battery(mission: Mission, **values: Any) -> Mission:
    return dataclasses.replace(mission, fleet=dataclasses.replace(mission.fleet, battery=BatteryLimits(**values)))


@pytest.mark.parametrize(
    ("battery", "swap_s", "robots"),
    [
        # away for a second and charging for k: 1 + k robots for one loop that goes past the charger
        ({"endurance_s": 500, "recharge_s": 1000}, None, 3),
        ({"endurance_s": 500, "recharge_s": 500}, None, 2),
        # a round takes some 37 s, and 50 s are allowed: it charges 4 s after each
        ({"endurance_s": 500, "recharge_s": 50}, None, 1),
        # six at full use of the period, but 37 of its 50 s are enough
        ({"endurance_s": 500, "recharge_s": 2500}, None, 5),
        ({"endurance_s": 500}, 100.0, 2),
        # nine rounds of 50 s but for a pause of 13.5 s: 3 x 436.5 s and twice the take-off in 3 x 450 s
        ({"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 15}, None, 3),
        ({"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 25}, None, 4),
        # five rounds, and no more: 3 x 236.5 s and 500 s, in turns of 250 s
        ({"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 250}, None, 5),
        # one round of 36.5 s and a swap, in turns of 50 s
        ({"endurance_s": 500, "takeoff_s": 450}, 100.0, 3),
        # a round of 36.6 s, its charge of 75.2 s, and for landing and climbing no more than 38.2 s of 3 x 50 s
        ({"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 1, "landing_s": 26, "climbing_s": 8}, None, 3),
        ({"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 1, "landing_s": 26, "climbing_s": 13}, None, 4),
        # one round and a swap of 13 s in 50 s, or with landing and climbing in 100 s
        ({"endurance_s": 500, "takeoff_s": 450}, 13.0, 1),
        ({"endurance_s": 500, "takeoff_s": 450, "landing_s": 26, "climbing_s": 13}, 13.0, 2),
    ],
)
def test_one_loop_past_the_charger_takes_one_robot_and_those_that_charge(
    battery: dict[str, float], swap_s: float | None, robots: int
) -> None:
    chargers = (dataclasses.replace(CORRIDOR.chargers[0], swap_s=swap_s),)
    fleet = dataclasses.replace(CORRIDOR.fleet, battery=BatteryLimits(**battery))
    plan = make_plan(dataclasses.replace(CORRIDOR, fleet=fleet, chargers=chargers))
    assert len(plan) == robots
    assert (plan.lower_bound_robots or 0) <= robots
    assert check_plan(plan).verdict == "met"


def test_what_a_second_away_takes_on_a_charger_counts_take_offs() -> None:
    # 375 s of flight at most and 125 s to take off are charged in 1000 s
    battery = {"endurance_s": 500, "recharge_s": 1000, "takeoff_s": 125}
    assert charging_of(with_battery(CORRIDOR, **battery)).per_s == pytest.approx(1000 / 375)
    swaps = (dataclasses.replace(CORRIDOR.chargers[0], swap_s=75),)
    assert charging_of(dataclasses.replace(with_battery(CORRIDOR, **battery), chargers=swaps)).per_s == 75 / 375
    # 39 s more of each stay are for landing and climbing; hovering meanwhile takes as much, if nothing else is said
    grounded = with_battery(CORRIDOR, **battery, landing_s=26, climbing_s=13)
    assert charging_of(grounded).per_s == pytest.approx((1000 + 39) / 375)
    hovering = with_battery(CORRIDOR, endurance_s=500, recharge_s=1000, landing_s=26, climbing_s=13)
    assert charging_of(hovering).per_s == pytest.approx((1000 + 39) / 461)


def test_a_robot_that_is_needed_now_and_then_charges_meanwhile() -> None:
    # a round takes some 37 s and charging after it 74 s: with 120 s for both nobody else is needed
    plan = make_plan(dataclasses.replace(CORRIDOR, period_s=120.0))
    assert len(plan) == 1
    assert check_plan(plan).verdict == "met"


def test_reliefs_keep_the_reserve_and_the_bound_is_that_of_the_mission_as_asked() -> None:
    # without a reserve one robot is enough: it charges 4 s after each round of 37 s; 45 s leave too little time
    asked = with_battery(CORRIDOR, endurance_s=500, recharge_s=175)
    careful = dataclasses.replace(asked, planning=PatrolSettings(effort="quick", period_margin=0.1, range_margin_m=0.5))
    plan = make_plan(careful)
    assert plan.mission == careful
    assert check_plan(dataclasses.replace(plan, mission=with_reserve(careful))).verdict == "met"
    assert (len(make_plan(asked)), len(plan)) == (1, 2)
    assert plan.lower_bound_robots == make_plan(asked).lower_bound_robots


@pytest.mark.parametrize(("standing_s", "robots"), [(400, 3), (200, 4)])
def test_standing_may_take_more_than_driving(standing_s: float, robots: int) -> None:
    """5.8 s of way, 4 s of pause; it stands for s = 388 or 194 s: 2 s + 23 or 3 s + 23 are busy in turns of s + 4."""
    gate = Zone(name="gate", shape=MultiPolygon([box(50, 30, 60, 40)]), period_s=4)
    battery = BatteryLimits(endurance_s=400, standing_endurance_s=standing_s, recharge_s=400)
    post = dataclasses.replace(
        CORRIDOR, area=MultiPolygon([box(0, 0, 60, 40)]), period_s=None, zones=(gate,),
        fleet=dataclasses.replace(CORRIDOR.fleet, battery=battery),
        chargers=(Charger(name="pad", at=(5, 5), places=9),),
    )  # fmt: skip
    plan = make_plan(post)
    assert len(plan) == robots
    assert check_plan(plan).verdict == "met"


def test_robots_with_bodies_relieve_each_other_without_touching() -> None:
    yard = dataclasses.replace(
        YARD,
        area=MultiPolygon([box(0, 0, 20, 14)]),
        fleet=dataclasses.replace(
            YARD.fleet, body_radius_m=0.1, battery=BatteryLimits(endurance_s=600, recharge_s=600)
        ),
        chargers=(Charger(name="pad", at=(1, 1), places=20),),
    )
    plan = make_plan(yard)
    assert check_plan(plan).verdict == "met"
    assert sum(len(trajectory.charges) > 0 for trajectory in plan) > 1


def test_chargers_with_too_few_places_are_refused_with_the_reason() -> None:
    wide = dataclasses.replace(CORRIDOR, area=MultiPolygon([box(0, 0, 200, 100)]))
    few = dataclasses.replace(wide, chargers=(Charger(name="pad", at=(100, 5), places=1),))
    with pytest.raises(NoPlanFound, match=r"chargers: they have 1 place, but 3\.\d+ robots must be on them on average"):
        make_plan(few)
    one = dataclasses.replace(CORRIDOR, chargers=(Charger(name="pad", at=(100, 5), places=1),))
    with pytest.raises(NoPlanFound, match=r"charger 'pad' has 1 place, and . robots are there at once: give it more"):
        make_plan(one)


def test_who_is_told_to_stop_tries_no_other_plan_than_the_one_found() -> None:
    one = with_reserve(dataclasses.replace(CORRIDOR, chargers=(Charger(name="pad", at=(100, 5), places=1),)))
    loops = make_plan(endless(one))
    tried = {}
    for stopped in (False, True):
        judged: list[Plan] = []

        def judge(plan: Plan, judged: list[Plan] = judged) -> Report:
            judged.append(plan)
            return check_plan(plan)

        request = Request(
            mission=one, seed=0, judge=judge, progress=lambda *_: None, should_stop=lambda stopped=stopped: stopped
        )
        with pytest.raises(NoPlanFound, match="robots are there at once") as caught:
            relieve(loops, one, request)
        assert caught.value.best is not None
        tried[stopped] = len(judged)
    assert tried[True] < tried[False]


def test_batteries_that_reach_nothing_are_refused() -> None:
    zone = Zone(name="far", shape=MultiPolygon([box(180, 0, 200, 10)]), period_s=60)
    far = dataclasses.replace(
        CORRIDOR, period_s=None, zones=(zone,), chargers=(Charger(name="pad", at=(5, 5), places=9),)
    )
    with pytest.raises(NoPlanFound, match=r"fleet.endurance_s: 30 less a reserve of 0 is too short: from a charger to"):
        make_plan(with_battery(far, endurance_s=30, recharge_s=30))


def test_a_charger_serves_that_lies_well_for_parts_of_a_round_and_not_the_nearest_one() -> None:
    """A battery lasts for half of the loop: robots change at the middle of both ways, or at both ends."""
    fleet = Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=7.5), battery=BatteryLimits(endurance_s=22, recharge_s=22))
    chargers = (Charger(name="end", at=(4, 5), places=4), Charger(name="middle", at=(100, 9), places=4))
    mission = dataclasses.replace(CORRIDOR, fleet=fleet, chargers=chargers)
    plan = make_plan(mission)
    assert (len(plan), check_plan(plan).verdict) == (3, "met")
    assert {charge.charger for one in plan for charge in one.charges} == {"middle"}


def test_a_fleet_that_is_named_charges_all_of_its_robots() -> None:
    five = dataclasses.replace(CORRIDOR, fleet=dataclasses.replace(CORRIDOR.fleet, robots=5))
    plan = make_plan(five)
    assert [trajectory.robot for trajectory in plan] == [f"robot-{k + 1}" for k in range(5)]
    assert check_plan(plan).verdict == "met"
    two = dataclasses.replace(CORRIDOR, fleet=dataclasses.replace(CORRIDOR.fleet, robots=2))
    with pytest.raises(NoPlanFound, match="3 robots are needed, those that charge included; the fleet has 2"):
        make_plan(two)


def test_plans_are_the_same_each_time_and_read_back() -> None:
    found = search_plan(CORRIDOR).plan
    assert plan_text(search_plan(CORRIDOR).plan) == plan_text(found)
    assert plan_from_text(plan_text(found), "it") == found

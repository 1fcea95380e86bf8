"""Plans of swarms whose robots charge: the check passes them, and finds a charge that is cut by a second."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.check.charging import battery_levels
from rota.errors import MissionError, NoPlanFound
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Obstacle, Robot, StartBox
from rota.model.plan import Charge, Plan
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.make_plan import search_plan
from rota.planning.planner import planner_of
from rota.planning.robot_processes import ProcessSettings
from rota.routes.flights import on_charger

WEST, EAST = Charger(name="west", at=(3, 15), places=1), Charger(name="east", at=(37, 15), places=1)
LASTS = BatteryLimits(endurance_s=240, recharge_s=100, reserve_s=20)


def mission(count: int = 5, chargers: tuple[Charger, ...] = (WEST, EAST), **changed: Any) -> Mission:
    """A yard of 40 m x 30 m with a shed in the middle, whose robots begin in a corner of it."""
    sensor = DiscSensor(radius_m=8)
    battery = changed.pop("battery", LASTS)
    like: dict[str, Any] = {"speed_m_s": 2, "sensor": sensor, "body_radius_m": 0.4}
    robots = tuple(Robot(name=f"r{k + 1}", battery=battery, **like) for k in range(count))
    fleet = Fleet(battery=battery, robots=robots, start=StartBox(low_m=(1, 1), high_m=(9, 9)), **like)
    yard: dict[str, Any] = {
        "name": "yard",
        "area": MultiPolygon([box(0, 0, 40, 30)]),
        "obstacles": (Obstacle(shape=MultiPolygon([box(17, 12, 23, 18)])),),
        "period_s": None,
        "fleet": fleet,
        "chargers": chargers,
        "planning": SwarmSettings(**{name: changed.pop(name) for name in ("controller",) if name in changed}),
    }
    return Mission(**{**yard, **changed})


@cache
def planned(count: int = 5) -> Plan:
    return run_mission(mission(count), seed=1).plan


def test_robots_charge_in_turn_for_ever_and_the_check_passes_the_plan() -> None:
    plan = planned()
    report = check_plan(plan_from_text(plan_text(plan), "yard"))
    assert (report.verdict, report.violations) == ("met", ())
    assert plan.run_end is not None
    assert plan.run_end.at_rest
    assert len({one.loop_duration_s for one in plan}) == len({one.loop_start_s for one in plan}) == 1
    times_s = np.linspace(plan.trajectories[0].loop_start_s, plan.trajectories[0].times_s[-1], 400)
    docked = np.stack([on_charger(one, times_s) for one in plan])
    assert docked.any(axis=1).all()
    assert docked.sum(axis=0).max() == 2
    held = report.holding
    assert held is not None
    assert held.in_range_least_m2 is not None
    assert held.in_range_mean_m2 is not None
    assert 0.3 * held.ground_m2 < held.in_range_least_m2 < held.in_range_mean_m2 < 0.8 * held.ground_m2


def test_the_same_seed_gives_the_same_plan_on_any_number_of_threads() -> None:
    assert plan_text(run_mission(mission(), seed=1, threads=2).plan) == plan_text(planned())
    assert plan_text(run_mission(mission(), seed=2).plan) != plan_text(planned())


def test_the_others_close_the_gap() -> None:
    plan = planned()
    for one in plan:
        stay = max(one.charges, key=lambda charge: charge.until_s - charge.from_s)
        moments_s = np.array([stay.from_s, stay.until_s])
        moved_m = [np.hypot(*np.diff(other.at(moments_s), axis=0)[0]) for other in plan if other is not one]
        assert max(moved_m) > 1


def with_charge(plan: Plan, lasts_s: float) -> Plan:
    """The plan of one robot, which gets up from its charge so early or late, and stands there until it leaves."""
    (one,) = plan
    (charge,) = one.charges
    until_s = charge.from_s + lasts_s
    k = int(np.searchsorted(one.times_s, until_s))
    changed = replace(
        one,
        times_s=np.insert(one.times_s, k, until_s),
        positions_m=np.insert(one.positions_m, k, one.at(until_s), axis=0),
        charges=(Charge(charger=charge.charger, from_s=charge.from_s, until_s=until_s),),
    )
    return replace(plan, trajectories=(changed,))


def test_a_charge_cut_by_a_second_is_found() -> None:
    plan = planned(1)
    (one,) = plan
    round_s = one.loop_duration_s
    assert round_s == pytest.approx((240 - 20) * (1 + 100 / 240), rel=0.01)
    least_s = round_s * 100 / 340
    assert one.charges[0].until_s - one.charges[0].from_s >= least_s
    levels = battery_levels(plan, one)
    assert 20 <= levels.levels_s.min() < 30
    assert check_plan(with_charge(plan, least_s + 0.5)).verdict == "met"
    (found,) = check_plan(with_charge(plan, least_s - 0.5)).violations
    assert (found.kind, found.who) == ("battery below its reserve", "r1")


def test_robots_that_take_off_dearly_are_back_sooner() -> None:
    # 60 s less a flight, and 25 s more to charge for them: rounds of (160 + 100 x 60 / 340) x 340 / 240 s
    plan = run_mission(mission(1, battery=replace(LASTS, takeoff_s=60)), seed=1).plan
    assert check_plan(plan).verdict == "met"
    assert plan.trajectories[0].loop_duration_s == pytest.approx((160 + 6000 / 340) * 340 / 240, rel=0.01)
    # and 39 s more for landing and climbing
    battery = replace(LASTS, takeoff_s=60, landing_s=26, climbing_s=13)
    lands = run_mission(mission(1, battery=battery), seed=1).plan
    assert check_plan(lands).verdict == "met"
    assert lands.trajectories[0].loop_duration_s == pytest.approx((160 + 6000 / 340) * 340 / 240 + 39, rel=0.01)


def test_robots_go_to_several_places_where_these_do_not_share_them_evenly() -> None:
    slow = BatteryLimits(endurance_s=240, recharge_s=200, reserve_s=20)
    plan = run_mission(mission(3, battery=slow), seed=1).plan
    assert check_plan(plan).verdict == "met"
    assert {charge.charger for charge in plan["r1"].charges} == {"west", "east"}


@pytest.mark.parametrize("controller", ["reciprocal", "voronoi", "virtual_force"])
def test_other_controllers_charge_as_well(controller: str) -> None:
    swapping = (replace(WEST, swap_s=20), replace(EAST, swap_s=20))
    plan = run_mission(mission(4, swapping, controller=controller), seed=1).plan
    assert check_plan(plan).verdict == "met"
    assert all(one.charges for one in plan)


def test_robots_without_an_endurance_hold_on() -> None:
    some = mission(4)
    robots = some.fleet.robots or ()
    lasting = replace(robots[0], battery=BatteryLimits())
    mixed = replace(some, fleet=replace(some.fleet, battery=BatteryLimits(), robots=(lasting, *robots[1:])))
    plan = run_mission(mixed, seed=1).plan
    assert check_plan(plan).verdict == "met"
    assert [bool(one.charges) for one in plan] == [False, True, True, True]


def test_chargers_that_cannot_suffice_are_refused_with_the_reason() -> None:
    with pytest.raises(
        NoPlanFound, match=r"chargers: 1 place cannot suffice for 6 robots, \d would do: batteries last"
    ):
        search_plan(mission(6, (WEST,)), seed=1)
    short = BatteryLimits(endurance_s=12, recharge_s=4)
    with pytest.raises(NoPlanFound, match=r"fleet\.endurance_s: batteries that last for 12 s are too short for 5 robo"):
        search_plan(mission(battery=short), seed=1)
    wall = Obstacle(shape=MultiPolygon([box(17, 0, 18, 30)]))
    with pytest.raises(NoPlanFound, match="chargers: robots come to too few of them"):
        search_plan(mission(3, (EAST,), obstacles=(wall,)), seed=1)


def test_a_search_that_is_stopped_has_no_plan() -> None:
    asked = iter(range(10**9))
    with pytest.raises(NoPlanFound, match="stopped before the round in which robots charge was planned"):
        run_mission(mission(), seed=1, should_stop=lambda: next(asked) > 50)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"delay_steps": 1}, "swarm.delay_steps: 1 is not allowed for robots that charge; only 0"),
        ({"filter": False}, "swarm.filter: false is not allowed for robots that charge; only true"),
        ({"altitudes_m": (20.0, 40.0)}, "swarm.altitudes_m: .* is not allowed for robots that charge; leave it out"),
    ],
)
def test_what_robots_that_charge_cannot_have_is_refused(changed: dict[str, Any], words: str) -> None:
    with pytest.raises(MissionError, match=words):
        mission(planning=SwarmSettings(**changed))


def test_processes_of_their_own_do_not_charge() -> None:
    with pytest.raises(MissionError, match="chargers: robots in processes of their own do not charge"):
        planner_of(mission()).robot_processes(mission(), ProcessSettings())

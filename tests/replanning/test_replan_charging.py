"""Robots that charge take over: closed forms of a relay on a ring with one pad, beside steps in time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.charging import docks
from benchmarks.time_sampling import Sampled, lattice
from shapely import MultiPolygon, box
from tests.relieved import with_battery
from tests.replanning.relays import BATTERY, PERIOD_S, relay
from tests.replanning.rings import ROUND_S

from rota import MissionError, NoPlanFound, Plan, Replanned, Trajectory, check_plan, make_plan, replan
from rota.check.lateness import lateness_of
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.battery_limits import BatteryLimits
from rota.model.fleet import Kind
from rota.model.mission import Charger, Obstacle
from rota.planners.patrol.driving.timed_line import steady
from rota.planners.patrol.handover.charging.arrivals import Arrivals
from rota.planners.patrol.handover.charging.flyers import Flyer
from rota.planners.patrol.handover.charging.timetables import circulations, round_of, timetables_of
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.routes.flights import on_charger

STEP_S = 0.05
LEFT_S = 2.4  # for which a place is in sight while a robot passes it


def levels_by_steps(
    line: Trajectory, level_s: float, until_s: float, battery: BatteryLimits = BATTERY, *, grounded: bool = False
) -> np.ndarray:
    """The level of a battery step by step, seconds of driving; grounded: the robot has not taken off before."""
    moments_s = (np.arange(int(until_s / STEP_S)) + 0.5) * STEP_S
    full_s, recharge_s, found = battery.endurance_s or 0.0, battery.recharge_s or math.inf, [level_s]
    for docked in on_charger(line, moments_s):
        if docked:
            found.append(min(found[-1] + full_s / recharge_s * STEP_S, full_s))
        else:
            found.append(found[-1] - STEP_S - battery.takeoff_s * grounded)
        grounded = bool(docked)
    return np.array(found)


def judge_by_steps(plan: Plan, at_s: float, found: Replanned, battery: BatteryLimits = BATTERY) -> None:
    """Batteries and lateness as steps in time say, from the file alone."""
    again = plan_from_text(plan_text(found.plan), "it")
    assert check_plan(again).verdict == found.report.verdict
    assert {one.kind for one in found.report.violations} <= {"gap"}
    for line in again:
        full_s, grounded = battery.endurance_s or 0.0, True
        level_s = full_s * line.battery
        if line.robot in [one.robot for one in plan]:
            before_s = levels_by_steps(plan[line.robot], full_s, at_s, battery, grounded=True)[-1]
            grounded = bool(on_charger(plan[line.robot], np.array([at_s - STEP_S / 2]))[0])
            leaves = grounded and level_s < before_s - 0.2  # at this very moment
            assert level_s == pytest.approx(before_s - battery.takeoff_s * leaves, abs=0.2)
            grounded = grounded and not leaves
        assert levels_by_steps(line, level_s, 600, battery, grounded=grounded).min() >= battery.reserve_s - 0.2
    sampled = Sampled(again, lattice(again.mission, 0.4), STEP_S, 500.0, more_m=STEP_S / 2)
    lateness = found.report.lateness
    assert lateness is not None
    if found.meets_demand:
        worst_s = max(one.worst_at_least_s for one in lateness.demands)
        assert sampled.worst_s == pytest.approx(worst_s, abs=0.4)


def test_the_relay_is_met_and_a_spare_robot_changes_nothing() -> None:
    assert [check_plan(relay(spare)).verdict for spare in (False, True)] == ["met", "met"]


def turning(plan: Plan) -> Plan:
    """The same of robots that turn within a millisecond at each corner: they end the flights that they are on."""
    fleet, lines = plan.mission.fleet, []
    robots = tuple(replace(one, turn_rate_rad_s=2e3, speed_m_s=1.001) for one in fleet.robots or ())
    for line in plan:
        moves = (np.diff(line.positions_m, axis=0) != 0).any(axis=1)
        corners = 1 + np.flatnonzero(moves[:-1] & moves[1:])
        times_s = np.insert(line.times_s, corners, line.times_s[corners] - 1e-3)
        places_m = np.insert(line.positions_m, corners, line.positions_m[corners], axis=0)
        lines.append(replace(line, times_s=times_s, positions_m=places_m))
    return Plan(mission=replace(plan.mission, fleet=replace(fleet, robots=robots)), trajectories=tuple(lines))


@pytest.mark.parametrize(
    ("at_s", "turns"),
    [
        (10.0, False),
        (250.0, True),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in [(250.0, False), (10.0, True)]),
    ],
)
def test_a_spare_robot_takes_the_place_of_one_that_is_lost_in_flight(at_s: float, turns: bool) -> None:
    plan = turning(relay(spare=True)) if turns else relay(spare=True)
    assert check_plan(plan).verdict == "met"
    answers: list[Replanned] = []
    found = replan(plan, at_s=at_s, lost=["a"], on_better=answers.append)  # 10 m round the ring
    judge_by_steps(plan, at_s, found)
    assert found.report.verdict == "met"
    assert found.report.lateness is not None
    assert found.report.lateness.holds_again_s < 2 * PERIOD_S  # type: ignore[operator]
    # who starts at the pad is 10 s behind: what lay ahead of the lost one is seen 10 s later than it would have been;
    # outside of a corner it is in sight for less long
    least_s = 10.0 + ROUND_S - LEFT_S - PERIOD_S
    worst_s = [max(one.worst_s for one in each.report.lateness.demands) for each in answers]  # type: ignore[union-attr]
    assert any(least_s - 0.5 <= late_s <= least_s + 0.8 for late_s in worst_s)
    assert worst_s[-1] <= least_s + 0.8  # other rounds may lose less


def test_nothing_is_late_where_a_robot_is_lost_on_its_charger_with_one_to_spare() -> None:
    plan = relay(spare=True)
    found = replan(plan, at_s=10.0, lost=["b"])  # on the pad, the next to fly
    judge_by_steps(plan, 10.0, found)
    assert found.report.verdict == "met"
    assert found.report.lateness is not None
    assert found.report.lateness.holds_again_s == 0


@pytest.mark.parametrize("lost", ["a", pytest.param("c", marks=pytest.mark.slow)])
def test_two_of_three_come_in_longer_turns_and_batteries_hold(lost: str) -> None:
    plan = relay(spare=False)
    found = replan(plan, at_s=10.0, lost=[lost])
    judge_by_steps(plan, 10.0, found)
    (demand,) = found.report.demands
    # 40 s of flight and 80 s of charging for two: a round each 60 s
    assert demand.worst_gap_at_least_s / PERIOD_S == pytest.approx((60 - LEFT_S) / PERIOD_S, abs=0.05)


@pytest.mark.parametrize("at_s", [10.0, 40.0, *(pytest.param(at_s, marks=pytest.mark.slow) for at_s in (0.0, 250.0))])
def test_take_offs_are_paid_once_where_plans_take_over(at_s: float) -> None:
    # 5 s and a round of 40 s take 75 s of charging, of 80 that there are; at 40 s the next one leaves
    plan = with_battery(relay(spare=True), recharge_s=100, takeoff_s=5)
    battery = plan.mission.fleet.battery
    assert check_plan(plan).verdict == "met"
    assert replan(plan, at_s=at_s).report.verdict == "met"
    found = replan(plan, at_s=at_s, lost=["a"], joined={"e": (5.0, 0.0)}, battery={"e": 0.7})
    judge_by_steps(plan, at_s, found, battery)


def test_take_offs_are_paid_once_where_two_share_one_charger() -> None:
    two = replan(with_battery(relay(spare=False), recharge_s=100, takeoff_s=5), at_s=10.0, lost=["c"])
    judge_by_steps(relay(spare=False), 10.0, two, two.plan.mission.fleet.battery)
    # 40 s of flight and 75 s of charging for two
    gap_s = two.report.demands[0].worst_gap_at_least_s
    assert gap_s / PERIOD_S == pytest.approx((57.5 - LEFT_S) / PERIOD_S, abs=0.05)


def test_one_that_joins_flies_as_soon_as_its_battery_lets_it() -> None:
    plan = relay(spare=False)
    for share in (1.0, 0.5):
        found = replan(plan, at_s=10.0, lost=["a"], joined={"e": (5.0, 0.0)}, battery={"e": share})
        judge_by_steps(plan, 10.0, found)
        assert found.report.verdict == "met"
        assert found.plan["e"].battery == share


def test_a_battery_that_is_told_to_be_fuller_than_what_was_driven_leaves_is_found() -> None:
    plan = relay(spare=True)
    found = replan(plan, at_s=10.0, lost=["b"]).plan
    flying = found["a"]  # 10 s of 60 are used
    assert flying.battery == pytest.approx(50 / 60)
    cheated = tuple(replace(line, battery=1.0) if line.robot == "a" else line for line in found)
    report = check_plan(plan_from_text(plan_text(replace(found, trajectories=cheated)), "it"))
    (violation,) = [one for one in report.violations if one.kind != "gap"]
    assert (violation.kind, violation.who) == ("battery fuller than what was driven leaves", "a")
    assert (violation.value, violation.limit, violation.time_s) == pytest.approx((60, 50, 0))
    assert violation.place_m == pytest.approx((10, 0))


def test_a_robot_whose_battery_is_emptier_than_planned_is_heeded() -> None:
    plan = relay(spare=True)
    found = replan(plan, at_s=10.0, battery={"a": 0.4})  # 24 s of 30 to the pad, with 10 that are kept
    judge_by_less = levels_by_steps(found.plan["a"], 24.0, 600)
    assert judge_by_less.min() >= BATTERY.reserve_s - 0.2
    assert {one.kind for one in found.report.violations} <= {"gap"}


def test_a_plan_that_took_over_is_replanned_with_what_its_batteries_had_left() -> None:
    plan = relay(spare=True)
    first = replan(plan, at_s=10.0, lost=["a"]).plan
    found = replan(first, at_s=37.0, lost=["b"])
    assert {one.kind for one in found.report.violations} <= {"gap"}
    for line in found.plan:
        before_s = levels_by_steps(first[line.robot], 60 * first[line.robot].battery, 37.0)[-1]
        assert 60 * line.battery == pytest.approx(before_s, abs=0.2)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"at_s": math.nan}, "at_s: nan is not allowed"),
        ({"at_s": -1.0}, r"at_s: -1\.0 is not allowed"),
        ({"lost": ["z"]}, "lost: robot 'z' is not in the plan"),
        ({"battery": {"z": 0.5}}, "battery: robot 'z' is not in the plan"),
        ({"joined": {"e": (0.0, 0.0)}, "battery": {"e": 1.2}}, r"battery: e=1\.2 is not allowed; 0"),
        ({"battery": {"a": math.nan}}, "battery: a=nan is not allowed"),
    ],
)
def test_changes_that_cannot_be_are_told(change: dict[str, object], told: str) -> None:
    with pytest.raises(MissionError, match=told):
        replan(relay(spare=True), **{"at_s": 10.0, **change})  # type: ignore[arg-type]


def test_a_changed_mission_keeps_chargers_and_batteries() -> None:
    plan = relay(spare=True)
    moved = replace(plan.mission, chargers=(Charger(name="pad", at=(10, 0), places=4),))
    with pytest.raises(MissionError, match="chargers: 'pad' of the changed mission is not where"):
        replan(plan, at_s=10.0, mission=moved)
    robots = tuple(replace(one, battery=replace(BATTERY, endurance_s=80)) for one in plan.mission.fleet.robots or ())
    stronger = replace(plan.mission, fleet=replace(plan.mission.fleet, robots=robots))
    with pytest.raises(MissionError, match="the battery of robot a in the changed mission is not as in the plan"):
        replan(plan, at_s=10.0, mission=stronger)


def test_robots_of_kinds_have_the_batteries_of_their_kinds_in_a_changed_mission_too() -> None:
    plan = relay(spare=False)
    robot = plan.mission.fleet.robot("a")
    plain = replace(plan.mission.fleet, battery=BatteryLimits(), robots=None)
    kind = Kind(name="quad", cost=1, speed_m_s=robot.speed_m_s, battery=BATTERY)
    mission = replace(plan.mission, fleet=replace(plain, kinds=(kind,)))
    lines = tuple(replace(line, robot=f"quad-{k}") for k, line in enumerate(plan, start=1))
    taken = replan(replace(plan, mission=mission, trajectories=lines), at_s=10.0, mission=mission)
    assert taken.kept == ("quad-1", "quad-2", "quad-3")
    assert taken.meets_demand


@pytest.mark.parametrize("at_s", [0.0, 30.0, 36.0, 39.5, 43.0, 100.0])
def test_stays_in_which_plans_take_over_have_time_to_land_and_to_climb(at_s: float) -> None:
    # 40 s of flight are charged in 50 s, beside 6 s of landing and 5 s of climbing, of 80 s that there are
    plan = with_battery(relay(spare=True), recharge_s=100, takeoff_s=1e-9, landing_s=6, climbing_s=5)
    assert check_plan(plan).verdict == "met"
    assert replan(plan, at_s=at_s).report.verdict == "met"
    found = replan(plan, at_s=at_s, lost=["a"])
    assert {one.kind for one in found.report.violations} <= {"gap"}
    assert found.meets_demand
    again = plan_from_text(plan_text(found.plan), "it")
    assert check_plan(again).verdict == found.report.verdict
    assert again.seam is not None
    for driven in again.seam.driven:
        leaves_s = min((one.until_s for one in plan[driven.robot].charges if one.until_s >= at_s), default=math.inf)
        docked = any(one.from_s < at_s <= one.until_s for one in plan[driven.robot].charges)
        assert driven.climbed_s == pytest.approx(max(0.0, 5 - (leaves_s - at_s)) if docked else 0.0, abs=1e-6)


def test_one_that_leaves_sooner_than_it_can_climb_is_found_where_a_plan_takes_over() -> None:
    plan = with_battery(relay(spare=True), recharge_s=100, takeoff_s=1e-9, landing_s=6, climbing_s=5)
    found = replan(plan, at_s=36.0).plan
    assert check_plan(found).verdict == "met"
    assert found.seam is not None
    climbing = next(one for one in found.seam.driven if one.climbed_s > 0)
    told = replace(found.seam, driven=tuple(replace(one, climbed_s=0.0) for one in found.seam.driven))
    (violation,) = check_plan(replace(found, seam=told)).violations
    assert violation.kind == "leaves before it can land and climb"
    assert violation.who.startswith(f"{climbing.robot}, ")
    assert violation.limit == pytest.approx(5)


@pytest.mark.parametrize("turn_rate_rad_s", [None, 1e15], ids=["at once", "as if it took time to turn"])
def test_one_to_spare_on_another_charger_comes_to_that_of_the_robot_that_is_lost(turn_rate_rad_s: float | None) -> None:
    plan = relay(spare=True)
    fleet, (x, y) = plan.mission.fleet, (3.0, 0.0)
    robots = tuple(replace(robot, turn_rate_rad_s=turn_rate_rad_s) for robot in fleet.robots or ())
    other = Charger(name="other", at=(x, y), places=1)
    mission = replace(plan.mission, chargers=(*plan.mission.chargers, other), fleet=replace(fleet, robots=robots))
    waits = replace(plan["d"], positions_m=[(x, y), (x, y)], charges=(replace(plan["d"].charges[0], charger="other"),))
    plan = Plan(mission=mission, trajectories=(*plan.trajectories[:3], waits))
    assert check_plan(plan).verdict == "met"
    found = replan(plan, at_s=10.0, lost=["b"])  # on the pad, the next to fly, after 30 s more
    judge_by_steps(plan, 10.0, found)
    assert found.report.verdict == "met"
    assert found.report.lateness is not None
    assert found.report.lateness.holds_again_s == 0
    assert [charge.charger for charge in found.plan["d"].charges][-1] == "pad"
    assert {charge.charger for charge in found.plan["d"].charges if charge.from_s >= found.plan["d"].loop_start_s} == {
        "pad"
    }


@pytest.mark.parametrize("spare", [False, True])
def test_robots_come_into_rounds_that_move_where_these_are_nearest_in_time(spare: bool) -> None:
    plan = turning(relay(spare=True))
    (robot, *_), chargers, lines = plan.mission.fleet.robots or (), plan.mission.chargers, plan.trajectories[:3]
    timetables = timetables_of(lines, robot, chargers)
    assert timetables is not None
    [[flown]] = [circulations(one) for one in timetables]
    round_, ways = round_of(flown, timetables[0].turn_s, np.zeros(2)), Ways(robot, PathsByBody(plan.mission))

    def arrivals(level_s: float) -> Arrivals:
        here_m = np.zeros(2)
        waits = Flyer(
            robot=robot, place_m=here_m, level_s=level_s, charger=chargers[0], lands=steady(np.zeros(1), here_m[None])
        )  # fmt: skip
        return Arrivals(round_, [waits], chargers, ways, moving=True, spare=spare)

    # the round is at (10, 0), and after 20 - x s at (x, 10), by a way round the block of 9.7 m + x from the pad
    full = arrivals(60.0)
    joins = full.finer(0, 10.0, full.arrival(0, 10.0))
    soon_s = 9.7 + 10.3 / 2 - 0.15
    assert (joins.joins_s, joins.phase_s) == pytest.approx((soon_s, 10 + soon_s), abs=0.05)
    assert joins.unserved_s == pytest.approx(joins.joins_s)
    # 10 s behind, to the end of the flight; there the round is on the pad
    late = full.behind(0, 10.0)
    assert late is not None
    assert late.enters is not None
    assert (late.leaves_s, late.enters.duration_s, late.joins_s) == pytest.approx((0, 40, 40), abs=0.51)
    # 30 s are flown then, and 10 s are kept; it charges, half as fast as it flies, while it waits
    low = arrivals(34.0)
    joins = low.finer(0, 10.0, low.arrival(0, 10.0))
    way_s = joins.joins_s - joins.leaves_s
    left_s = 34 + joins.leaves_s / 2 - way_s
    assert joins.leaves_s > 2
    # to spare are 5 % of 40 s, which is less than half of what 40 of 60 s leave beyond the 10
    assert left_s == pytest.approx(10 + 40 - joins.phase_s + 2 * spare, abs=0.2)
    assert full.behind(0, 50.0) is None  # it is on the pad


@pytest.mark.parametrize("lost", ["a", "b"])
def test_lateness_is_the_same_where_loops_that_meet_all_are_looked_at_to_their_end(lost: str) -> None:
    found = replan(turning(relay(spare=True)), at_s=10.0, lost=[lost], should_stop=lambda: True)
    assert found.report.verdict == "met"
    # what is not proved is looked at for the longest loop
    open_ones = tuple(replace(one, outcome="not proven") for one in found.report.demands)
    whole = lateness_of(found.plan, replace(found.report, demands=open_ones), finest_m=0.01, on_the_way=None)
    told = found.report.lateness
    assert told is not None
    for one, other in zip(told.demands, whole.demands, strict=True):
        assert one.worst_at_least_s == pytest.approx(other.worst_at_least_s)
        assert one.worst_s == pytest.approx(other.worst_s, abs=0.1)


def test_where_an_obstacle_cuts_the_ground_of_robots_that_charge_in_two_no_plan_takes_over() -> None:
    plan = relay(spare=False)
    wall = Obstacle(shape=MultiPolygon([box(3, -1, 4, 11)]))
    with pytest.raises(NoPlanFound, match="no plan takes over at t = 10 s"):
        replan(plan, at_s=10.0, mission=replace(plan.mission, obstacles=(wall,)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 24])
def test_drones_that_remain_share_their_docks_anew(seed: int) -> None:
    plan = make_plan(docks(seed))
    found: list[Replanned] = []
    replan(plan, at_s=plan.trajectories[0].loop_start_s + 500, lost=["robot-1"], on_better=found.append)
    ratios = [max(one.worst_gap_at_least_s / one.period_s for one in each.report.demands) for each in found]
    # flights left out for good make places wait five to eight periods; two of three robots need one and a half
    assert ratios[0] > 4
    assert ratios[-1] <= 1.5
    assert found[-1].report.lateness is not None
    assert all(one.unseen_area_m2 == 0 for one in found[-1].report.demands)

"""Batteries and chargers in the check: levels beside steps in time, and each rule at its place and moment."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.check.charging import battery_levels
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Charge, Driven, Plan, Seam, Trajectory
from rota.routes.moments import go_on

PAD = Charger(name="pad", at=(0, 0), places=1)
BATTERY = BatteryLimits(endurance_s=100, recharge_s=50, reserve_s=10)


def mission(battery: BatteryLimits = BATTERY, *chargers: Charger, **changed: Any) -> Mission:
    fleet = {"speed_m_s": 1, "sensor": DiscSensor(radius_m=200), "battery": battery, **changed}
    return Mission(
        name="m",
        area=MultiPolygon([box(-100, -100, 100, 100)]),
        period_s=1000,
        fleet=Fleet(**fleet),
        chargers=chargers or (PAD,),
    )


def there_and_back(name: str = "a", *, far_m: float = 40, docked_s: float = 60, from_s: float = 0.0) -> Trajectory:
    """Docked at the pad first, then out along x and back, again and again; or begun later in that."""
    times_s = np.array([0.0, docked_s, docked_s + far_m, docked_s + 2 * far_m])
    places_m = np.array([(0.0, 0.0), (0.0, 0.0), (far_m, 0.0), (0.0, 0.0)])
    charge = Charge(charger="pad", from_s=0, until_s=docked_s)
    if from_s:
        times_s, places_m = np.append(0.0, times_s + from_s), np.vstack([(0.0, 0.0), places_m])
        charge = Charge(charger="pad", from_s=from_s, until_s=from_s + docked_s)
    return Trajectory(robot=name, times_s=times_s, positions_m=places_m, charges=(charge,), loop_start_s=from_s)


def told(plan: Plan) -> list[tuple[str, str]]:
    return [(violation.kind, violation.who) for violation in check_plan(plan).violations]


def test_a_robot_that_charges_in_time_is_met_for_ever() -> None:
    assert check_plan(Plan(mission=mission(), trajectories=(there_and_back(),))).verdict == "met"


def test_a_battery_that_lasts_a_second_too_little_is_told_at_its_place_and_time() -> None:
    plan = Plan(mission=mission(), trajectories=(there_and_back(far_m=45.5),))
    (violation,) = check_plan(plan).violations
    assert violation.kind == "battery below its reserve"
    # 90 s of 100 may be used: a second of driving before it is back
    assert violation.time_s == pytest.approx(60 + 90)
    assert violation.place_m == pytest.approx((1.0, 0.0))
    assert (violation.value, violation.limit) == pytest.approx((9.0, 10.0))


def test_a_battery_that_is_charged_too_little_each_round_is_told() -> None:
    # 80 s are used, and 39 s of charging give back 78
    plan = Plan(mission=mission(), trajectories=(there_and_back(docked_s=39),))
    (violation,) = check_plan(plan).violations
    assert violation.kind == "takes more than it charges"
    assert violation.value == pytest.approx(2.0)
    assert told(Plan(mission=mission(), trajectories=(there_and_back(docked_s=40),))) == []


@pytest.mark.parametrize("round_s", [1e-6, 1e-3, 1.0])
def test_rounds_of_a_moment_hide_no_battery_that_runs_down(round_s: float) -> None:
    stands = Trajectory(robot="a", times_s=np.array([0.0, round_s]), positions_m=np.zeros((2, 2)))
    assert told(Plan(mission=mission(), trajectories=(stands,))) == [("takes more than it charges", "a")]


def test_a_swapped_battery_is_full_after_that_time_and_not_before() -> None:
    swaps = dataclasses.replace(PAD, swap_s=30)
    for docked_s, kinds in ((30, []), (29, ["battery below its reserve"])):
        plan = Plan(mission=mission(BATTERY, swaps), trajectories=(there_and_back(docked_s=docked_s),))
        assert [kind for kind, _ in told(plan)] == kinds


def test_standing_may_take_less_than_driving() -> None:
    hovering = dataclasses.replace(BATTERY, standing_endurance_s=200, reserve_s=0)
    times_s = np.array([0.0, 50.0, 60.0, 220.0, 230.0])
    places_m = np.array([(0.0, 0.0), (0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (0.0, 0.0)])
    charge = Charge(charger="pad", from_s=0, until_s=50)
    robot = Trajectory(robot="a", times_s=times_s, positions_m=places_m, charges=(charge,))
    # 20 s of driving and 160 s of hovering at half of its cost make 100 s
    assert told(Plan(mission=mission(hovering), trajectories=(robot,))) == []
    shorter = dataclasses.replace(hovering, standing_endurance_s=190)
    assert told(Plan(mission=mission(shorter), trajectories=(robot,))) == [("battery below its reserve", "a")]


@pytest.mark.parametrize(("from_s", "round_s"), [(100.0, 2.0), (1e7, 1e-3)])
@pytest.mark.parametrize("places", [1, 2])
def test_rounds_shorter_than_a_moment_hide_nobody_at_a_charger(from_s: float, round_s: float, places: int) -> None:
    """Two robots that stay for ever, told as rounds; so late a moment is a hundredth of a second."""
    pad = dataclasses.replace(PAD, places=places)
    stays = [
        Trajectory(
            robot=name, times_s=np.array([0.0, come_s, from_s, from_s + round_s]), loop_start_s=from_s,
            positions_m=np.array([(away_m, 0.0), (0, 0), (0, 0), (0, 0)]),
            charges=(Charge(charger="pad", from_s=come_s, until_s=from_s),
                     Charge(charger="pad", from_s=from_s, until_s=from_s + round_s)),
        )
        for name, away_m, come_s in (("a", 10.0, 10.0), ("b", 20.0, from_s - round_s / 2))
    ]  # fmt: skip
    kinds = [kind for kind, _ in told(Plan(mission=mission(BATTERY, pad), trajectories=tuple(stays)))]
    assert ("charger too full" in kinds) == (places == 1)


@pytest.mark.parametrize(
    ("creeps_m", "parts", "kinds"), [(0.0, 1, 1), (1e-6, 1, 1), (0.014, 1, 1), (3e-4, 90, 1), (5, 1, 0)]
)
def test_who_creeps_where_hovering_takes_more_hovers(creeps_m: float, parts: int, kinds: int) -> None:
    """20 s of flight, and 30 s of hovering at four times its cost: 140 s of 100, though it creeps to and fro."""
    hovering = dataclasses.replace(BATTERY, standing_endurance_s=25, reserve_s=0)
    rows = [(60 + 30 * k / parts, 10 + creeps_m * (k % 2 if k < parts else 0)) for k in range(1, parts + 1)]
    if creeps_m and parts == 1:
        rows = [(75, 10 + creeps_m), (90, 10)]
    times_s, xs_m = np.array([(0.0, 0.0), (50, 0), (60, 10), *rows, (100, 0)]).T
    robot = Trajectory(
        robot="a", times_s=times_s, positions_m=np.column_stack([xs_m, np.zeros(len(xs_m))]),
        charges=(Charge(charger="pad", from_s=0, until_s=50),),
    )  # fmt: skip
    found = told(Plan(mission=mission(hovering), trajectories=(robot,)))
    assert found == [("battery below its reserve", "a")] * kinds


def test_each_departure_takes_what_it_costs() -> None:
    # out and back takes 80 s, and 5 s to take off: 42.5 s charge it again
    for docked_s, kinds in ((42.5, []), (42.0, ["takes more than it charges"])):
        battery = dataclasses.replace(BATTERY, takeoff_s=5)
        plan = Plan(mission=mission(battery), trajectories=(there_and_back(docked_s=docked_s),))
        assert [kind for kind, _ in told(plan)] == kinds
    battery = dataclasses.replace(BATTERY, takeoff_s=11)
    (violation,) = check_plan(Plan(mission=mission(battery), trajectories=(there_and_back(),))).violations
    assert violation.kind == "battery below its reserve"
    # a second of driving before it is back
    assert (violation.time_s, violation.value) == pytest.approx((60 + 79, 9))
    assert violation.place_m == pytest.approx((1.0, 0.0))


def test_a_stay_is_landing_charging_and_climbing_and_a_second_too_little_of_it_is_told() -> None:
    # 40 s of driving and 39 s of hovering meanwhile are charged in 39.5 s, beside 26 s and 13 s on the ground
    battery = dataclasses.replace(BATTERY, landing_s=26, climbing_s=13)
    for docked_s, kinds in ((78.5, []), (77.5, ["takes more than it charges"])):
        plan = Plan(mission=mission(battery), trajectories=(there_and_back(far_m=20, docked_s=docked_s),))
        assert [kind for kind, _ in told(plan)] == kinds
    one = there_and_back(far_m=20, docked_s=78.5)
    levels = battery_levels(plan, one)
    # of the second stay, from 118.5 s on
    np.testing.assert_allclose(
        np.interp([118, 119, 144, 145, 184, 185, 196], levels.times_s, levels.levels_s),
        [21.5, 21, 21, 22, 100, 100, 100],
    )
    for by_s in (10.0, 40.0, 70.0):  # a stay goes on across the seam of its loop, wherever that is in it
        turned = go_on(one, by_s)
        assert told(Plan(mission=mission(battery), trajectories=(turned,))) == []
        later, at_s = battery_levels(plan, turned), np.array([119.0, 145.0, 184.0, 190.0])
        np.testing.assert_allclose(
            np.interp(at_s - by_s, later.times_s, later.levels_s), np.interp(at_s, levels.times_s, levels.levels_s)
        )


def test_a_swap_begins_when_the_robot_has_landed_and_ends_before_it_climbs() -> None:
    swaps = dataclasses.replace(PAD, swap_s=30)
    battery = dataclasses.replace(BATTERY, landing_s=6, climbing_s=4, takeoff_s=1)
    for docked_s, kinds in ((40, []), (39, ["battery below its reserve"])):
        plan = Plan(mission=mission(battery, swaps), trajectories=(there_and_back(docked_s=docked_s),))
        assert [kind for kind, _ in told(plan)] == kinds


def test_a_stay_in_which_nobody_can_land_and_climb_is_told() -> None:
    battery = BatteryLimits(endurance_s=1000, recharge_s=1, landing_s=26, climbing_s=13)
    for docked_s, kinds in ((41.0, []), (38.0, ["leaves before it can land and climb", "takes more than it charges"])):
        plan = Plan(mission=mission(battery), trajectories=(there_and_back(docked_s=docked_s),))
        assert sorted(kind for kind, _ in told(plan)) == kinds
    (first, _) = sorted(check_plan(plan).violations, key=lambda one: one.kind)
    assert (first.who, first.value, first.limit) == ("a, pad", pytest.approx(38), 39)
    assert first.time_s == pytest.approx(118 + 38)


def test_who_begins_in_the_air_has_taken_off_once() -> None:
    times_s, places_m = np.array([0.0, 30.0, 75.0, 105.0]), np.array([(30.0, 0.0), (0.0, 0.0), (0.0, 0.0), (30.0, 0.0)])
    one = Trajectory(
        robot="a", times_s=times_s, positions_m=places_m, charges=(Charge(charger="pad", from_s=30, until_s=75),)
    )
    plan = Plan(mission=mission(dataclasses.replace(BATTERY, takeoff_s=20)), trajectories=(one,))
    levels = battery_levels(plan, one)
    # full less 20 s, 30 s back, full, less 20 s, 30 s out; then on in the air
    np.testing.assert_allclose(levels.levels_s[levels.times_s == 0.0], [100, 80])
    np.testing.assert_allclose(
        np.interp([30, 74, 76, 105, 106], levels.times_s, levels.levels_s), [50, 100, 79, 50, 49]
    )
    rests = Trajectory(robot="a", times_s=np.zeros(1), positions_m=np.zeros((1, 2)))
    (violation,) = check_plan(dataclasses.replace(plan, trajectories=(rests,))).violations
    assert (violation.kind, violation.time_s) == ("battery below its reserve", pytest.approx(70))


@pytest.mark.parametrize(("battery", "docked_s", "least_s"), [(1.0, 0, 10), (0.8, 0, 10), (1.0, 5, 10), (0.6, 0, -10)])
def test_who_is_told_at_the_change_alone_has_taken_off_once(battery: float, docked_s: float, least_s: float) -> None:
    """70 s out and back: from the pad at once or later, and told before the take-off of 20 s or after it."""
    first = ([0.0], [(0.0, 0.0)]) if docked_s else ([], [])
    times_s = np.array([*first[0], docked_s, docked_s + 35, docked_s + 70, docked_s + 130])
    places_m = np.array([*first[1], (0.0, 0.0), (35.0, 0.0), (0.0, 0.0), (0.0, 0.0)])
    stays = [(0.0, docked_s)] * bool(docked_s) + [(docked_s + 70, docked_s + 130)]
    one = Trajectory(
        robot="a", times_s=times_s, positions_m=places_m, battery=battery,
        charges=tuple(Charge(charger="pad", from_s=begins_s, until_s=ends_s) for begins_s, ends_s in stays),
    )  # fmt: skip
    was = Driven(robot="a", sensor=DiscSensor(radius_m=200), times_s=[0.0], positions_m=[(0.0, 0.0)], battery=battery)
    asked = mission(dataclasses.replace(BATTERY, takeoff_s=20))
    plan = Plan(mission=asked, trajectories=(one,), seam=Seam(at_s=9, driven=(was,)))
    levels = battery_levels(plan, one)
    assert np.interp(docked_s + 69.999, levels.times_s, levels.levels_s) == pytest.approx(least_s, abs=0.01)


def test_what_is_charged_elsewhere_counts_for_nothing() -> None:
    away = dataclasses.replace(PAD, at=(0, 3))
    (violation,) = check_plan(Plan(mission=mission(BATTERY, away), trajectories=(there_and_back(),))).violations
    assert (violation.kind, violation.who) == ("charges away from its charger", "a, pad")
    assert violation.value == pytest.approx(3.0)


def test_a_robot_that_rests_anywhere_runs_down() -> None:
    standing = Trajectory(robot="a", times_s=np.zeros(1), positions_m=np.zeros((1, 2)))
    (violation,) = check_plan(Plan(mission=mission(), trajectories=(standing,))).violations
    assert (violation.kind, violation.time_s) == ("battery below its reserve", pytest.approx(90))


def test_a_charger_has_room_for_so_many_at_once() -> None:
    # 60 s docked of 140: two robots 70 s apart are never docked together, three are
    def team(count: int, places: int) -> Plan:
        robots = [there_and_back(f"r{k}") for k in range(count)]
        shifted = [one if k == 0 else shift(one, 70.0 * k / (count - 1)) for k, one in enumerate(robots)]
        return Plan(mission=mission(BATTERY, dataclasses.replace(PAD, places=places)), trajectories=tuple(shifted))

    assert told(team(2, 1)) == []
    (violation,) = check_plan(team(3, 1)).violations
    assert (violation.kind, violation.value, violation.limit) == ("charger too full", 2, 1)
    assert told(team(3, 2)) == []


def shift(one: Trajectory, by_s: float) -> Trajectory:
    """The same loop begun so much later; it is docked until then, and so at the end."""
    times_s = np.concatenate([[0.0], one.times_s[1:] + by_s])
    places_m = one.positions_m.copy()
    end_s = one.times_s[-1]
    # what reaches beyond the round's end comes first
    k = int(np.searchsorted(times_s, end_s)) - 1
    share = (end_s - times_s[k]) / (times_s[k + 1] - times_s[k])
    seam_m = places_m[k] + share * (places_m[k + 1] - places_m[k])
    late_s, late_m = times_s[k + 1 :] - end_s, places_m[k + 1 :]
    times = np.concatenate([[0.0], late_s, times_s[1 : k + 1], [end_s]])
    places = np.vstack([seam_m, late_m, places_m[1 : k + 1], seam_m])
    charge = Charge(charger="pad", from_s=float(late_s[-1]), until_s=float(times_s[1]))
    return Trajectory(robot=one.robot, times_s=times, positions_m=places, charges=(charge,))


def test_robots_on_a_charger_see_nothing_and_are_in_nobodys_way() -> None:
    zone = Zone(name="pad", shape=MultiPolygon([box(-1, -1, 1, 1)]), period_s=55)
    asked = dataclasses.replace(mission(sensor=DiscSensor(radius_m=30)), period_s=None, zones=(zone,))
    (violation,) = check_plan(Plan(mission=asked, trajectories=(there_and_back(),))).violations
    # out of range for some 20 s, but unseen for the 60 s on the charger beside it
    assert violation.kind == "gap"
    assert violation.value == pytest.approx(60)
    bodies = mission(BATTERY, dataclasses.replace(PAD, places=2), body_radius_m=1.0)
    rests = Trajectory(
        robot="b", times_s=np.array([0.0, 140.0]), positions_m=np.zeros((2, 2)),
        charges=(Charge(charger="pad", from_s=0, until_s=140),),
    )  # fmt: skip
    assert told(Plan(mission=bodies, trajectories=(there_and_back("a"), rests))) == []


def test_levels_are_those_of_small_steps_in_time() -> None:
    chance = np.random.default_rng(5)
    chargers = {"slow": Charger(name="slow", at=(0, 0)), "swap": Charger(name="swap", at=(50, 0), swap_s=7)}
    for number in range(40):
        takeoff_s = 3.0 * (number % 2)
        legs = int(chance.integers(3, 12))
        times_s = np.concatenate([[0.0], np.cumsum(chance.integers(1, 15, legs))]).astype(float)
        at = [["slow", "swap", None][k] for k in chance.integers(3, size=legs)]
        places = [(0.0, 0.0) if name == "slow" else (50.0, 0.0) if name == "swap" else None for name in at]
        spots = [next((p for p in (places[k], places[k - 1]) if p), (float(k), 9.0)) for k in range(legs)]
        spots.append(spots[0])
        charges = tuple(
            Charge(charger=name, from_s=times_s[k], until_s=times_s[k + 1])
            for k, name in enumerate(at)
            if name and spots[k] == spots[k + 1] == chargers[name].at
        )
        one = Trajectory(robot="a", times_s=times_s, positions_m=np.array(spots), charges=charges)
        grounding_s = (2.5, 1.25) if number % 3 == 2 else (0.0, 0.0)
        battery = BatteryLimits(
            endurance_s=100, recharge_s=50, standing_endurance_s=150, takeoff_s=takeoff_s, landing_s=grounding_s[0],
            climbing_s=grounding_s[1],
        )  # fmt: skip
        plan = Plan(mission=mission(battery, *chargers.values()), trajectories=(one,))
        levels = battery_levels(plan, one)
        asked_s = np.arange(0.25, 2 * times_s[-1], 0.5)
        stepped = stepped_levels(one, chargers, asked_s, takeoff_s or sum(grounding_s) * 100 / 150, grounding_s)
        np.testing.assert_allclose(np.interp(asked_s, levels.times_s, levels.levels_s), stepped, atol=1e-6)


def stepped_levels(
    one: Trajectory, chargers: dict[str, Charger], asked_s: np.ndarray[Any, Any], takeoff_s: float,
    grounding_s: tuple[float, float],
) -> list[float]:  # fmt: skip
    """The battery by small steps: full at first, 100 s of driving, 150 s of standing, 50 s of charging.

    grounding_s: of each stay these are for landing and for climbing; a robot that begins on the ground has landed.
    """
    step_s, level, stood, now, found = 0.25, 100.0, 0.0, 0.0, []
    before: str | None = "ground"
    middles_s = np.arange(step_s / 2, 4 * one.times_s[-1], step_s)
    stays = np.array([any(c.from_s <= s <= c.until_s for c in one.charges) for s in middles_s % one.times_s[-1]])
    edges = np.flatnonzero(np.diff(stays)) + 1
    for k in itertools.count():
        if len(found) == len(asked_s):
            return found
        if abs(now - asked_s[len(found)]) < 1e-9:
            found.append(level)
        phase = (now + step_s / 2) % one.times_s[-1]
        leg = int(np.searchsorted(one.times_s, phase)) - 1
        charge = next((c.charger for c in one.charges if c.from_s <= phase <= c.until_s), None)
        stood = stood + step_s if charge is not None and charge == before else step_s if charge else 0.0
        level -= takeoff_s if charge is None and before is not None else 0.0
        before = charge
        came, leaves = edges[edges <= k].max(initial=-100), edges[edges > k].min(initial=10**6)
        rests = charge is not None and not (
            (k - came) * step_s >= grounding_s[0] - 1e-9 and (leaves - k - 1) * step_s >= grounding_s[1] - 1e-9
        )
        if rests:
            stood = 0.0 if (k - came) * step_s < grounding_s[0] - 1e-9 else stood - step_s
        elif charge is None:
            moves = (one.positions_m[leg] != one.positions_m[leg + 1]).any()
            level -= step_s if moves else step_s * 100 / 150
        elif chargers[charge].swap_s is None:
            level = min(level + step_s * 2, 100.0)
        elif stood >= 7 - 1e-9:
            level = 100.0
        now = (k + 1) * step_s
    raise AssertionError

"""Circuits of robots that charge: cuts beside brute force, launches followed one by one, and plans by closed forms."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota import PatrolSettings, check_plan, make_plan
from rota.errors import NoPlanFound
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Sensor, SquareSensor, Zone
from rota.planners.patrol.circuits.ground import Circuit, Ground, cut_at_chargers, grounds_of, without_seen
from rota.planners.patrol.circuits.launches import Ring, fewest_rings
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.relief.flights import robot_of_jobs

PAD = Charger(name="pad", at=(300, 5), places=20)

# a corridor as wide as the sensor sees, with the charger in its middle: 60 s from there to an end and back
CORRIDOR = Mission(
    name="corridor",
    area=MultiPolygon([box(0, 0, 600, 10)]),
    period_s=120,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=10), battery=BatteryLimits(endurance_s=90, recharge_s=90)),
    chargers=(PAD,),
    planning=PatrolSettings(effort="quick"),
)


def circuit(lasts_s: float, most_s: float) -> Circuit:
    return Circuit(
        charger=PAD, line=steady(np.array([0.0, lasts_s]), np.array([PAD.at] * 2)), most_s=most_s, used_s=lasts_s
    )


@pytest.mark.parametrize("seed", range(20))
def test_a_line_is_cut_as_by_brute_force(seed: int) -> None:
    chance = np.random.default_rng(seed)
    times_s = np.concatenate([[0.0], np.cumsum(chance.uniform(1, 5, 7))])
    ways_s = chance.uniform(0, 4, (2, 8))
    usable_s = 16.0

    def flown_s(begin: int, end: int) -> float:
        return float(np.min(ways_s[:, begin] + ways_s[:, end]) + times_s[end] - times_s[begin])

    possible = []
    for size in range(7):
        for inner in itertools.combinations(range(1, 7), size):
            ends = (0, *inner, 7)
            pieces_s = [flown_s(a, b) for a, b in itertools.pairwise(ends)]
            if max(pieces_s) <= usable_s:
                possible.append(sum(pieces_s))
    cuts = cut_at_chargers(ways_s, times_s, usable_s)
    assert [begin for begin, _ in cuts] == [0, *(end for _, end in cuts[:-1])]
    assert cuts[-1][1] == 7
    assert max(flown_s(*cut) for cut in cuts) <= usable_s
    assert sum(flown_s(*cut) for cut in cuts) == pytest.approx(min(possible))


def test_a_way_too_long_for_a_battery_is_told() -> None:
    with pytest.raises(NoPlanFound, match=r"fleet.endurance_s: a circuit from a charger and back takes longer"):
        cut_at_chargers(np.array([[1.0, 9.0]]), np.array([0.0, 5.0]), 14.0)


def follow(rings: list[Ring], circuits: list[Circuit], battery: BatteryLimits) -> tuple[list[list[float]], float]:
    """When each circuit is launched in some time, and the least level of any battery, robot by robot."""
    launched: list[list[float]] = [[] for _ in circuits]
    least_s = battery.endurance_s or 0.0
    for ring in rings:
        for robot in range(ring.robots):
            free_s, level_s = 0.0, battery.endurance_s or 0.0
            for number in range(6):
                for launch in ring.launches:
                    begins_s = launch.begins_s + robot * ring.turn_s + number * ring.lasts_s
                    assert begins_s >= free_s - 1e-6
                    own = circuits[launch.circuit]
                    stayed_s = begins_s - free_s if free_s else 0.0
                    filled_s = stayed_s * battery.endurance_s / battery.recharge_s  # type: ignore[operator]
                    level_s = min(battery.endurance_s or 0.0, level_s + filled_s) - own.used_s - battery.takeoff_s
                    free_s = begins_s + own.line.duration_s
                    launched[launch.circuit].append(begins_s)
                    least_s = min(least_s, level_s)
    return launched, least_s


@pytest.mark.parametrize("seed", range(12))
def test_launches_are_in_time_and_robots_are_charged_for_them(seed: int) -> None:
    chance = np.random.default_rng(seed)
    circuits = [circuit(float(chance.uniform(5, 90)), float(chance.choice([20, 30, 40, 60]))) for _ in range(3)]
    recharge_s, takeoff_s = float(chance.choice([50, 200, 400])), 12.0 * (seed % 2)
    landing_s, climbing_s = (5.0, 3.0) if seed % 3 == 2 else (0.0, 0.0)
    battery = BatteryLimits(
        endurance_s=200, recharge_s=recharge_s, reserve_s=10, takeoff_s=takeoff_s or 1e-9, landing_s=landing_s,
        climbing_s=climbing_s,
    )  # fmt: skip
    rings = fewest_rings(circuits, battery, least=1, most=60, seed=0)
    launched, least_s = follow(rings, circuits, battery)
    assert least_s >= battery.reserve_s - 1e-6
    lasts_s = max(ring.lasts_s for ring in rings)
    for own, times in zip(circuits, launched, strict=True):
        later = np.array(sorted(t for t in times if lasts_s <= t <= 3 * lasts_s))
        assert np.diff(later).max() <= own.most_s + 1e-6
    # nobody does with fewer than are in the air and charge on average
    stays_s = [landing_s + climbing_s + (own.used_s + takeoff_s) * recharge_s / 200 for own in circuits]
    busy = sum((own.used_s + stay_s) / own.most_s for own, stay_s in zip(circuits, stays_s, strict=True))
    assert busy - 1e-6 <= sum(ring.robots for ring in rings) <= busy + 2


def test_too_many_robots_are_refused() -> None:
    with pytest.raises(NoPlanFound, match="circuits from charger 'pad' are flown by no team of 1 to 2 robots"):
        fewest_rings([circuit(60, 20)], BatteryLimits(endurance_s=90, recharge_s=90), least=1, most=2, seed=0)


def test_a_reserve_that_no_flight_leaves_is_refused_soon() -> None:
    with pytest.raises(NoPlanFound, match="are flown by no team of 1 to 10000 robots"):
        fewest_rings(
            [circuit(60, 20)], BatteryLimits(endurance_s=90, recharge_s=90, reserve_s=40), least=1, most=10_000, seed=0
        )


def test_a_loop_longer_than_a_battery_is_two_circuits_by_as_many_robots_as_charging_takes() -> None:
    # both ways of the corridor take 120 s, once in a period, and charging as long: two robots, who need all of it
    plan = make_plan(CORRIDOR)
    assert len(plan) == 2
    assert check_plan(plan).verdict == "met"
    assert max(len(trajectory.charges) for trajectory in plan) >= 2
    # of a take-off of 15 s each charges for 75 s after 60 s: 2.25 robots
    battery = dataclasses.replace(CORRIDOR.fleet.battery, takeoff_s=15)
    plan = make_plan(dataclasses.replace(CORRIDOR, fleet=dataclasses.replace(CORRIDOR.fleet, battery=battery)))
    assert len(plan) == 3
    assert check_plan(plan).verdict == "met"


def test_chargers_with_too_little_room_are_refused() -> None:
    narrow = dataclasses.replace(CORRIDOR, chargers=(dataclasses.replace(PAD, places=1),))
    with pytest.raises(NoPlanFound, match="charger 'pad' has 1 place"):
        make_plan(dataclasses.replace(narrow, period_s=60))


def test_a_named_fleet_flies_circuits_with_all_of_its_robots() -> None:
    plan = make_plan(dataclasses.replace(CORRIDOR, fleet=dataclasses.replace(CORRIDOR.fleet, robots=3)))
    assert [trajectory.robot for trajectory in plan] == ["robot-1", "robot-2", "robot-3"]
    assert all(trajectory.charges for trajectory in plan)
    assert check_plan(plan).verdict == "met"


@pytest.mark.parametrize("sensor", [DiscSensor(radius_m=10), SquareSensor(side_m=20)])
def test_what_circuits_see_on_their_way_is_left_out_and_nothing_else(sensor: Sensor) -> None:
    field = dataclasses.replace(
        CORRIDOR,
        fleet=dataclasses.replace(CORRIDOR.fleet, sensor=sensor),
        area=MultiPolygon([box(0, 0, 200, 200)]),
        period_s=300,
        zones=(Zone(name="urgent", shape=MultiPolygon([box(80, 80, 120, 120)]), period_s=60),),
        chargers=(dataclasses.replace(PAD, at=(100, 100)),),
    )
    urgent, rest = grounds_of(field)
    assert [urgent.period_s, rest.period_s] == [60, 300]
    line_m = np.array([(100.0, 100.0), (30.0, 100.0), (100.0, 100.0)])
    flown = Circuit(charger=field.chargers[0], line=steady(np.array([0.0, 7, 14]), line_m), most_s=60, used_s=14)
    left: Ground = without_seen(rest, [flown], field)
    gone = rest.regions[0].shape.difference(left.regions[0].shape)
    assert gone.area > 0.8 * (50 * 20)  # of the way that is off the zone
    seen = shapely.LineString(line_m[:2]).buffer(10, quad_segs=64)
    assert gone.difference(seen).area == pytest.approx(0, abs=1e-6)


def test_turns_by_next_to_nothing_take_no_rows_of_their_own() -> None:
    times_s = np.array(
        [0.0, 5.0, np.nextafter(5.0, 6.0), 10.0, 15.0]
    )  # the second step is lost beside the time of the launch
    places_m = np.array([(0.0, 0.0), (5.0, 0.0), (5.0, 0.0), (5.0, 5.0), (0.0, 0.0)])
    line = TimedLine(times_s, places_m, np.zeros(4))
    robot = robot_of_jobs("robot-1", [Charger(name="pad", at=(0, 0))], [(210.4, line)], 400.0)
    np.testing.assert_allclose(robot.times_s, [0, 210.4, 215.4, 220.4, 225.4, 400])
    np.testing.assert_allclose(robot.positions_m[2:5], [(5, 0), (5, 5), (0, 0)])

"""Reserves beside closed forms: a lane of known width, and rounds of a known time."""

from __future__ import annotations

from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from shapely import box

from rota.check import check_plan, margins_of, report_schema, report_table, report_to_json
from rota.check.margins import worst_ratio_of
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Robot, SquareSensor, Zone
from rota.model.plan import Charge, Plan, Trajectory

LENGTH_M, WIDTH_M, ROUND_S = 40.0, 6.0, 20.0


def lane(side_m: float = 8.0, period_s: float = 25.0, zones: tuple[Zone, ...] = ()) -> Plan:
    """A lane of 40 m by 6 m, driven to and fro along its middle in 20 s by a robot that sees a square."""
    sensor = SquareSensor(side_m=side_m)
    robots = [Robot(name="a", speed_m_s=4.0, sensor=sensor)]
    mission = Mission(
        name="lane", area=box(0, 0, LENGTH_M, WIDTH_M), period_s=period_s, zones=zones,
        fleet=Fleet(speed_m_s=4.0, sensor=sensor, robots=robots),
    )  # fmt: skip
    places_m = [[0, WIDTH_M / 2], [LENGTH_M, WIDTH_M / 2], [0, WIDTH_M / 2]]
    way = Trajectory(robot="a", times_s=[0, ROUND_S / 2, ROUND_S], positions_m=places_m)
    return Plan(mission=mission, trajectories=(way,))


def test_the_range_may_shrink_to_the_lane_and_to_the_longest_gap() -> None:
    """At an end the gap is 2 (40 - half side) / 4: with 25 s to spend it is the width alone that asks for 3 m of 4."""
    plan = lane()
    margins = {margin.kind: margin for margin in margins_of(plan, check_plan(plan))}
    ranges, period = margins["range"], margins["period"]
    assert ranges.spare == pytest.approx(1.0, abs=0.02)  # places lie up to 1 cm inside of corners
    assert (ranges.limit, ranges.unit, ranges.who, ranges.robots) == (4.0, "m", "area", ("a",))
    assert ranges.place_m is not None
    assert min(ranges.place_m[1], WIDTH_M - ranges.place_m[1]) < 0.02
    assert period.spare == pytest.approx(25 - (LENGTH_M - 4) / 2, abs=0.02)
    assert period.place_m is not None
    assert min(period.place_m[0], LENGTH_M - period.place_m[0]) < 0.02
    tight = lane(period_s=18.5)
    ranges = next(m for m in margins_of(tight, check_plan(tight)) if m.kind == "range")
    assert ranges.spare == pytest.approx(1.0, abs=0.02)
    tighter = lane(period_s=18.1)
    ranges = next(m for m in margins_of(tighter, check_plan(tighter)) if m.kind == "range")
    assert ranges.spare == pytest.approx(0.2, abs=0.02)


def test_the_thinnest_comes_first_and_is_told_in_text_and_json() -> None:
    plan = lane(period_s=18.1)
    report = check_plan(plan)
    assert report.margins == ()
    report = replace(report, margins=margins_of(plan, report))
    assert [margin.kind for margin in report.margins] == ["period", "range"]
    assert [margin.share for margin in report.margins] == sorted(margin.share for margin in report.margins)
    lines = report_table(report).splitlines()
    assert lines[-2].startswith("least time to spare: 0.")
    assert " of 18.1 s (0.5 %), in area at (" in lines[-2]
    assert lines[-2].endswith(", seen by a")
    assert lines[-1].startswith("least range to spare: 0.2")
    told = report_to_json(report)
    jsonschema.Draft202012Validator(report_schema()).validate(told)
    assert [each["kind"] for each in told["margins"]] == ["period", "range"]
    assert told["margins"][0]["robots"] == ["a"]


def test_a_zone_to_visit_may_have_the_least_time() -> None:
    """Its near side is passed at x = 38 on the way out and again on the way back: the gap is 2 x 38 m at 4 m/s."""
    plan = lane(zones=(Zone(name="end", shape=box(38, 0, 40, 6), period_s=19.2, demand="visit"),))
    thinnest = margins_of(plan, check_plan(plan))[0]
    assert (thinnest.kind, thinnest.who, thinnest.robots, thinnest.place_m) == ("period", "end", ("a",), None)
    assert thinnest.spare == pytest.approx(0.2)


def test_nothing_is_to_spare_where_the_plan_is_not_met() -> None:
    plan = lane(period_s=10.0)
    assert margins_of(plan, check_plan(plan)) == ()


def test_discs_of_two_ranges_shrink_by_the_same() -> None:
    """Two robots at 12 m from each other see discs of 10 and 8 m: the ground between is theirs for 6 m less in all."""
    robots = [Robot(name="far", speed_m_s=1.0, sensor=DiscSensor(radius_m=10.0)), Robot(name="near", speed_m_s=1.0)]
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=8.0), robots=robots)
    mission = Mission(name="posts", area=box(0, 0, 12, 0.01), period_s=5.0, fleet=fleet)
    ways = [Trajectory(robot=r.name, times_s=[0], positions_m=[[12.0 * k, 0.005]]) for k, r in enumerate(robots)]
    plan = Plan(mission=mission, trajectories=tuple(ways))
    ranges = next(m for m in margins_of(plan, check_plan(plan)) if m.kind == "range")
    assert ranges.spare == pytest.approx(3.0, abs=0.05)
    assert ranges.limit == 8.0


def test_the_ratio_at_places_is_never_above_the_proved_one() -> None:
    plan = lane()
    report = check_plan(plan)
    assert report.worst_ratio_at_least * 0.99 < worst_ratio_of(plan) <= report.worst_ratio
    assert np.isfinite(worst_ratio_of(plan))


def test_the_battery_with_least_above_its_reserve_is_told() -> None:
    """Out 40 m and back with 100 s, of which 10 s are the reserve: 10 s are left when it comes home."""
    battery = BatteryLimits(endurance_s=100, recharge_s=50, reserve_s=10)
    plan = lane()
    fleet = replace(plan.mission.fleet, battery=battery, robots=None, speed_m_s=1.0, sensor=SquareSensor(side_m=90.0))
    pad = Charger(name="pad", at=(0, WIDTH_M / 2), places=1)
    mission = replace(plan.mission, fleet=fleet, chargers=(pad,), period_s=200.0)
    home, far = (0.0, WIDTH_M / 2), (LENGTH_M, WIDTH_M / 2)
    way = Trajectory(
        robot="a", times_s=[0, 60, 100, 140], positions_m=[home, home, far, home],
        charges=(Charge(charger="pad", from_s=0, until_s=60),),
    )  # fmt: skip
    charged = Plan(mission=mission, trajectories=(way,))
    margins = {margin.kind: margin for margin in margins_of(charged, check_plan(charged))}
    assert (margins["battery"].who, margins["battery"].place_m) == ("a", home)
    assert margins["battery"].spare == pytest.approx(10.0)
    assert margins["battery"].text() == "least battery to spare: 10 of 100 s (10 %), of a at (0.00, 3.00)"

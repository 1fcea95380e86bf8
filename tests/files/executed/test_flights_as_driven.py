"""Robots that charge as files of their single flights have them fly, beside the plan, moment by moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.relieved import FLIGHT_S, TURN_S, relieved
from tests.replanning.relays import PERIOD_S, relay
from tests.replanning.rings import ROUND_S

from rota import Plan, Trajectory, check_plan, replan
from rota.check import report_table
from rota.command.cli import run
from rota.command.executed import executed_plan
from rota.errors import PlanError
from rota.files.executed.flights_as_driven import fly_single_flights
from rota.files.executed.plan_as_driven import DRIVEN, flights_as_driven
from rota.files.plan_file import write_plan
from rota.routes.flights import on_charger

LEFT_S = 2.4  # for which a place of the ring is in sight while a robot passes it
FLIGHTS = ("qgroundcontrol", "qgroundcontrol-px4", "waypoints", "dji-wpml", "nav2", "vda5050")


def slower(lasts: dict[str, float]) -> object:
    """What drives each flight as planned, but that those of some robots take so many seconds longer, all the way."""

    def drive(way: Trajectory) -> Trajectory:
        lands = way.charges[0].from_s
        share = 1 + lasts.get(way.robot.partition(".")[0], 0.0) / lands
        times_s = np.where(way.times_s <= lands, way.times_s * share, lands * share + way.times_s - lands)
        return replace(way, times_s=times_s, loop_start_s=float(times_s[-1]), charges=())

    return lambda plan: tuple(drive(way) for way in plan)


def differ_m(plan: Plan, made: Plan, until_s: float) -> float:
    """How far robots are from where they are by plan at most; they charge at the same times, but for moments."""
    moments_s, worst_m = np.arange(0.0, until_s, 0.37), 0.0
    for way, other in zip(plan, made, strict=True):
        worst_m = max(worst_m, float(np.abs(way.at(moments_s) - other.at(moments_s)).max()))
        assert np.count_nonzero(on_charger(way, moments_s) != on_charger(other, moments_s)) <= 0.002 * len(moments_s)
    return worst_m


@pytest.mark.parametrize("name", sorted(DRIVEN.keys() - {"rosbag2", "rosbag2-sqlite3", "rosbag1"}))
def test_all_formats_have_robots_fly_as_planned_but_for_their_digits(name: str) -> None:
    plan = relieved(3)
    made = executed_plan(plan, name)
    assert check_plan(made.plan).verdict == "met"
    # a millimetre a waypoint, and the seconds that come of that
    assert differ_m(plan, made.plan, 3000.0) < (0.02 if name in FLIGHTS[:3] else 0.002)
    assert made.has_flights == (name in FLIGHTS)
    assert ("each starts when flights.csv says; no file says how full batteries are" in made.told) == (name in FLIGHTS)


@pytest.mark.parametrize("joins", [False, True])
def test_a_plan_that_took_over_with_flights_under_way_is_flown_so(joins: bool) -> None:
    """One that joins flies onto the ring from where it stands, once, before its flights from the pad."""
    new = {"joined": {"e": (5.0, 0.0)}, "battery": {"e": 0.5}} if joins else {}
    plan = replan(relay(spare=not joins), at_s=53.0, lost=["a"], **new).plan
    assert check_plan(plan).verdict == "met"
    for name in ("nav2", "csv"):
        made = executed_plan(plan, name).plan
        assert differ_m(plan, made, 700.0) < 0.002
        assert [way.battery for way in made] == [way.battery for way in plan]
        assert check_plan(made).verdict == "met"
    flown = [one.flight for one in flights_as_driven(plan, "nav2")[1]]
    assert min(one.starts_s for one in flown) <= 0.0
    assert any(one.every_s == 0 for one in flown) == joins


def test_what_a_flight_takes_longer_is_charged_less() -> None:
    """Flights of 180 s take 20 s longer, all the way: robots land 20 s later, and leave when they would."""
    plan = relieved(3)
    made, flown = fly_single_flights(plan, slower({f"robot-{k}": 20.0 for k in (1, 2, 3)}))
    assert [one.longer_s for one in flown] == pytest.approx([20.0] * 3)
    moments_s = np.arange(0.05, 1500, 0.1)
    for k, way in enumerate(made):
        flies = np.mod(moments_s - k * TURN_S, 3 * TURN_S) < FLIGHT_S + 20.0
        assert (on_charger(way, moments_s) == ~flies).mean() > 0.999
    levels_s = [
        next(one for one in check_plan(_with_reserve(made, reserve_s)).violations if "battery" in one.kind)
        for reserve_s in (201.0, 230.0)
    ]
    assert [one.value for one in levels_s] == pytest.approx([400 - FLIGHT_S - 20.0] * 2)


def _with_reserve(plan: Plan, reserve_s: float) -> Plan:
    """The plan of a mission whose batteries keep so much."""
    fleet = plan.mission.fleet
    return replace(
        plan, mission=replace(plan.mission, fleet=replace(fleet, battery=replace(fleet.battery, reserve_s=reserve_s)))
    )


def test_a_flight_that_takes_longer_than_others_leaves_a_gap_whose_place_and_time_are_told() -> None:
    """All go round a ring in 40 s, one after the other: b takes 5 s longer, and is latest where its round ends."""
    plan = relay(spare=False)
    made, _ = fly_single_flights(plan, slower({"b": 5.0}))
    report = check_plan(made)
    (gap,) = [one for one in report.violations if one.kind == "gap"]
    assert gap.value == pytest.approx(ROUND_S + 5.0 - LEFT_S, abs=0.7)
    assert gap.limit == PERIOD_S
    assert gap.place_m is not None
    assert (
        np.hypot(gap.place_m[0], gap.place_m[1] - 1.2) < 1.2
    )  # before the pad at (0, 0), to which it comes from (0, 10)
    assert f"({gap.place_m[0]:.3f}, {gap.place_m[1]:.3f})" in report_table(report)


def test_a_flight_that_has_not_landed_when_its_next_one_begins_is_told() -> None:
    with pytest.raises(
        PlanError, match=r"robot robot-2: it has not landed when flight robot-2\.1 is to start, by flights"
    ):
        fly_single_flights(relieved(3), slower({"robot-2": 3 * TURN_S - FLIGHT_S + 1.0}))


def test_what_is_refused_and_what_is_said(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    path = f"{tmp_path}/plan.rota.json"
    write_plan(relieved(3), path)
    assert run(["check", path, "--executed", "nav2"]) == 0
    assert "as nav2 flies its single flights, places are up to 0 m off" in capsys.readouterr().err
    for more, told in (
        (
            ["--in-phase-every", "60"],
            "--in-phase-every: not allowed for a plan whose robots charge: each of its flights",
        ),
        (["--vehicle", "arducopter"], "--vehicle: not allowed for a plan whose robots charge: without it"),
    ):
        assert run(["check", path, "--executed", "waypoints", *more]) == 2
        assert told in capsys.readouterr().err

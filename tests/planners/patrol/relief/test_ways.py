"""Robots with mass, that take time to turn or turn on arcs: ways from chargers into rounds, and plans with them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from tests.planners.patrol.relief.test_relief import CORRIDOR

from rota import Replanned, check_plan, make_plan, replan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Fleet, Mission
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Plan
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.relief.ways import Ways, motions_of
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody

SPEED_M_S = 10.0
A_M_S2 = 2.5
SPARE = 2e-3  # planned with a thousandth less than robots can do
# 4 s of getting up speed over 20 m, 10 s at full speed, 4 s of braking; there, and back
RAMPS = TimedLine(
    np.array([0.0, 4, 14, 18, 22, 32, 36]),
    np.array([[20.0, 5], [40, 5], [140, 5], [160, 5], [140, 5], [40, 5], [20, 5]]),
    np.array([A_M_S2, 0, -A_M_S2, A_M_S2, 0, -A_M_S2]),
)
MASS = MotionLimits(acceleration_m_s2=A_M_S2)


def corridor(**fleet: Any) -> Mission:
    """A corridor as wide as sensors see, which one robot covers going to and fro, with a charger on the way."""
    changed: Fleet = dataclasses.replace(CORRIDOR.fleet, **fleet)
    return dataclasses.replace(CORRIDOR, period_s=70.0, fleet=changed)


def ways_of(mission: Mission) -> Ways:
    return Ways(mission.fleet.equal_robot("robot-1"), PathsByBody(mission))


def test_a_way_into_a_moving_round_takes_its_run_up() -> None:
    """The charger at x = 100, the round at full speed from x = 60 on: back to 40 from rest to rest, 20 m of run-up."""
    ways, charger_m, phase_s = ways_of(corridor(motion=MASS)), np.array([100.0, 5.0]), 6.0
    lasts_s = 60 / SPEED_M_S + SPEED_M_S / A_M_S2 + SPEED_M_S / A_M_S2
    found = ways.last_s(RAMPS, np.array([phase_s]), charger_m[None], 1.0, np.array([0]))
    assert found[0, 0] == pytest.approx(lasts_s, rel=SPARE)
    into = ways.into(charger_m, RAMPS, phase_s, 1.0, np.inf)
    assert into.duration_s == pytest.approx(lasts_s, rel=SPARE)
    just_m = into.at(np.array([into.duration_s - 1e-3]))
    assert np.allclose(into.places_m[-1] - just_m, [[1e-3 * SPEED_M_S, 0.0]], atol=1e-4)
    slower = ways.into(charger_m, RAMPS, phase_s, 2.0, np.inf)  # a round at half the speed: twice the run-up
    assert slower.duration_s == pytest.approx(lasts_s + SPEED_M_S / A_M_S2, rel=SPARE)
    # back: 20 m of braking ahead to x = 80, and 20 m from rest to rest
    back = ways.back(charger_m, RAMPS, phase_s, 1.0, np.inf)
    assert back.duration_s == pytest.approx(SPEED_M_S / A_M_S2 + 2 * (20 / A_M_S2) ** 0.5, rel=SPARE)
    assert np.allclose(back.places_m[[0, -1]], [[60.0, 5.0], [100.0, 5.0]])


def test_where_a_battery_lasts_for_parts_of_a_round_ways_are_looked_for_at_even_spots() -> None:
    charger_m, phases_s, even = np.array([[100.0, 5.0]]), np.array([6.0, 9.0, 12.0, 24.0]), np.array([0, 3])
    parts = corridor(motion=MASS, battery=BatteryLimits(endurance_s=30, recharge_s=30))
    whole = corridor(motion=MASS, battery=BatteryLimits(endurance_s=300, recharge_s=30))
    found = ways_of(parts).last_s(RAMPS, phases_s, charger_m, 1.0, even)
    every = ways_of(whole).last_s(RAMPS, phases_s, charger_m, 1.0, even)
    assert np.isfinite(every).all()
    assert (np.isfinite(found) == [True, False, False, True]).all()
    assert (found[:, even] == every[:, even]).all()


def test_a_round_is_told_as_it_goes_on_and_as_it_came() -> None:
    on, came = (motions_of(RAMPS, np.array([18.0, 2.0]), before=before) for before in (False, True))
    assert [at.speed_m_s for at in on] == pytest.approx([0.0, 5.0])
    assert [at.speed_m_s for at in came] == pytest.approx([0.0, 5.0])
    assert [at.direction.tolist() for at in on if at.direction is not None] == [[-1.0, 0.0], [1.0, 0.0]]
    assert [at.direction.tolist() for at in came if at.direction is not None] == [[-1.0, 0.0], [-1.0, 0.0]]
    stays = motions_of(steady(np.zeros(1), np.array([[3.0, 4.0]])), np.zeros(1), before=False)
    assert [(at.direction, at.speed_m_s) for at in stays] == [(None, 0.0)]


@pytest.mark.parametrize(
    ("fleet", "robots"),
    [
        # away for a second and charging for two: three robots, as without mass, for rounds that take longer
        ({"motion": MASS}, 3),
        ({"motion": dataclasses.replace(MASS, corner_m=1.5)}, 3),
        ({"motion": dataclasses.replace(MASS, corner_m=1.5, jerk_m_s3=5.0)}, 3),
        ({"motion": MASS, "turn_rate_rad_s": 1.0}, 3),
        ({"motion": MASS, "body_radius_m": 0.3, "turn_rate_rad_s": 1.0}, 3),
        ({"turn_rate_rad_s": 1.0}, 2),
        ({"turn_radius_m": 3.0}, 2),
    ],
)
def test_robots_that_are_no_points_without_mass_relieve_each_other(fleet: dict[str, Any], robots: int) -> None:
    plan = make_plan(corridor(**fleet))
    assert check_plan(plan).verdict == "met"
    assert len(plan) == robots
    assert all(trajectory.charges for trajectory in plan)


@pytest.fixture(scope="module")
def cutting() -> Plan:
    """Three robots with mass that cut corners and take turns at the corridor."""
    return make_plan(corridor(motion=dataclasses.replace(MASS, corner_m=1.5)))


def test_a_change_within_a_curve_is_judged_with_the_curve(cutting: Plan) -> None:
    """A plan that is taken over by itself is as good as it was, wherever its robots are."""
    flier = cutting.trajectories[0]
    lasts_s = np.diff(flier.times_s)
    in_curves = np.flatnonzero((lasts_s < 0.5) & (flier.times_s[1:] < flier.charges[0].from_s))[:12:4]
    assert len(in_curves) == 3
    for leg in in_curves.tolist():
        found = replan(cutting, at_s=float(flier.times_s[leg] + 0.6 * lasts_s[leg]))
        assert found.report.verdict == "met", leg


@pytest.mark.parametrize("at_s", [7.0, 250.0, 900.0])
def test_two_of_three_fly_in_longer_turns_however_much_mass_they_have(cutting: Plan, at_s: float) -> None:
    """Away for L seconds and charging for 2 L, nobody is there for L / 2 after each: in all that and a round."""
    found = replan(cutting, at_s=at_s, lost=["robot-2"], should_stop=lambda: True)
    assert {violation.kind for violation in found.report.violations} == {"gap"}
    charges = [one for trajectory in cutting for one in trajectory.charges]
    stays_s = max(one.until_s - one.from_s for one in charges)
    (demand,) = found.report.demands
    assert stays_s / 4 < demand.worst_gap_s < stays_s / 4 + 70


@pytest.mark.slow  # the search for other flights
def test_two_of_three_find_flights_that_come_oftener_than_theirs_in_longer_turns(cutting: Plan) -> None:
    answers: list[Replanned] = []
    replan(cutting, at_s=250.0, lost=["robot-2"], on_better=answers.append)
    first_s, last_s = (demand.worst_gap_s for one in (answers[0], answers[-1]) for demand in one.report.demands)
    assert 70 < last_s < 0.5 * first_s


def test_a_new_one_with_mass_comes_to_a_charger_first(cutting: Plan) -> None:
    """It stands 80 m from the charger: from rest to rest in 8 + 4 s, and takes the place of one that is lost."""
    found = replan(cutting, at_s=250.0, lost=["robot-2"], joined={"new": (20.0, 5.0)})
    assert {violation.kind for violation in found.report.violations} <= {"gap"}
    new = found.plan["new"]
    assert new.charges[0].from_s == pytest.approx(80 / SPEED_M_S + SPEED_M_S / A_M_S2, rel=SPARE)
    assert found.report.lateness is not None
    assert found.report.lateness.holds_again_s is not None

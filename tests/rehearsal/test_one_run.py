"""Single runs beside the check, closed forms and brute force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.rehearsal.rehearsed_plans import counting_one, crossing, post, round_a_block, taking_turns, with_mass

from rota import Plan, Trajectory, check_plan, worst_gaps_s
from rota.live.keeping import LATE_S
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.contacts import contacts_of
from rota.rehearsal.kernels import Driven
from rota.rehearsal.least_times import least_times_s
from rota.rehearsal.many_runs import rehearse_once
from rota.rehearsal.scene import Scene, scene_of
from rota.rehearsal.stages import drive_in_stages
from rota.vehicles.motion import Wind

HOUR_S = 3600.0


def drive(scene: Scene, seed: int, number: int) -> Driven:
    """How robots drive in a run, without their batteries."""
    return drive_in_stages(scene, seed, number)[0][0].driven


@pytest.mark.parametrize(
    "plan",
    [
        round_a_block(), round_a_block((64.0, 96.0)), round_a_block((64.0,)), round_a_block((70.0, 70.0, 105.0)),
        round_a_block(square=True), with_mass(), post(), crossing(),
        taking_turns(), counting_one(round_a_block((64.0, 96.0))),
    ],
    ids=["shared", "2 to 3", "alone", "three", "squares", "mass", "stays", "crossing", "charging", "sensors"],
)  # fmt: skip
def test_without_chance_gaps_are_those_of_the_check(plan: Plan) -> None:
    scene = scene_of(plan, Conditions(hours=0.5))
    run, _, worst_s = rehearse_once(scene, 0, 0)
    points = len(scene.points_m)
    exact_s = np.minimum(worst_gaps_s(plan, scene.points_m), 0.5 * HOUR_S)  # what is never seen is as long as the run
    assert np.abs(worst_s[:points] - exact_s).max() <= 1e-6
    assert run.contacts == ()
    verdicts = {demand.name: demand for demand in check_plan(plan).demands}
    for k, demand in enumerate(scene.demands):
        gap_s, verdict = run.worst_gaps_s[k], verdicts[demand.name]
        assert gap_s <= verdict.worst_gap_s + 1e-6
        if demand.demand == "visit":
            assert gap_s == pytest.approx(verdict.worst_gap_s, abs=1e-6)
        late = max(0.0, gap_s - demand.period_s) > 1e-6
        assert (run.late_shares[k].max() > 0) <= late


def test_what_was_late_is_as_brute_force_has_it() -> None:
    """A robot that fails and one that is slow: moments at which a place was seen within the period, one by one."""
    plan = round_a_block((64.0, 70.0))
    scene = scene_of(plan, Conditions(hours=0.2, failures_per_hour=3.0, speed_noise=0.1, hands_off=True))
    number = next(n for n in range(50) if 100 < drive(scene, 0, n).fails_s.min() < 600)
    driven = drive(scene, 0, number)
    run, late_s, _ = rehearse_once(scene, 0, number)
    door = len(scene.points_m)
    moments_s = np.arange(0, scene.end_s, 0.01)
    inside = np.zeros(len(moments_s), bool)
    for robot, way in enumerate(plan):
        planned_s = np.interp(moments_s, driven.times_s[robot], scene.tick_s * np.arange(driven.times_s.shape[1]))
        x, y = way.at(planned_s).T
        inside |= (x >= 17) & (x <= 19) & (y >= 7) & (y <= 9) & (moments_s <= driven.fails_s[robot])
    seen_s = np.maximum.accumulate(np.where(inside, moments_s, 0.0))
    expected_s = 0.01 * np.count_nonzero(moments_s - seen_s > 40.0)
    assert expected_s > 5
    assert late_s[door] == pytest.approx(expected_s, abs=0.5)
    assert run.late_shares[0].mean() * 720 == pytest.approx(late_s[door])


def test_a_robot_that_stays_is_available_until_a_period_after_it_fails() -> None:
    """In the mean over F, exponential with rate r: 1 - ((T - P) - (1 - exp(-r (T - P))) / r) / T."""
    hours, period_s, rate = 2.0, 600.0, 0.5
    scene = scene_of(post(period_s), Conditions(hours=hours, failures_per_hour=rate))
    shares = []
    for number in range(800):
        run, _, worst_s = rehearse_once(scene, 1, number)
        fails_s = float(drive(scene, 1, number).fails_s[0])
        unseen_s = max(0.0, hours * HOUR_S - fails_s)
        assert worst_s == pytest.approx(np.full(len(worst_s), unseen_s), abs=1e-6)
        shares.append(1 - run.late_shares[0].mean())
        assert shares[-1] == pytest.approx(1 - max(0.0, unseen_s - period_s) / (hours * HOUR_S), abs=1e-9)
    left_h = hours - period_s / HOUR_S
    exact = 1 - (left_h - (1 - math.exp(-rate * left_h)) / rate) / hours
    assert abs(np.mean(shares) - exact) < 3 * np.std(shares) / math.sqrt(len(shares))


@pytest.mark.parametrize(
    ("from_deg", "round_s"), [(90.0, 20 / 0.7 + 20), (0.0, 40 / math.sqrt(1 - 0.09)), (270.0, 20 / 0.7 + 20)]
)
def test_against_the_wind_a_robot_is_late_and_with_it_not_early(from_deg: float, round_s: float) -> None:
    """It drives 20 m east and back at 1 m/s through the air, in wind of 0.3 m/s."""
    plan = crossing()
    asked = Conditions(hours=1.0, wind_m_s=0.3, wind_from_deg=from_deg, hands_off=True)
    driven = drive(scene_of(plan, asked), 0, 0)
    assert driven.times_s[0, 40] == pytest.approx(round_s)
    assert driven.times_s[0, 3600] == pytest.approx(90 * round_s)


def test_late_robots_make_up_where_the_plan_is_slower_than_they_can() -> None:
    """A round of 64 m in 80 s at up to 1 m/s: it loses no time as long as 64 s of driving take less than 80."""
    plan = round_a_block((80.0,))
    least_s = least_times_s(plan, Wind(), 1.0, 800)
    assert least_s.sum() == pytest.approx(640.0)
    driven = drive(scene_of(plan, Conditions(hours=1.0, wind_m_s=0.1)), 0, 0)
    rounds = driven.times_s[0, ::80] - 80.0 * np.arange(len(driven.times_s[0, ::80]))
    assert np.abs(rounds).max() < 1e-6


def test_noise_makes_robots_late_and_never_early() -> None:
    asked = {"hours": 2.0, "speed_noise": 0.05}
    apart, kept = (drive(scene_of(round_a_block(), Conditions(**asked, hands_off=off)), 3, 7) for off in (True, False))
    ticks = np.arange(apart.times_s.shape[1])
    for driven in (apart, kept):
        assert (driven.times_s >= ticks - 1e-6).all()
        assert (np.diff(driven.times_s, axis=1) > 0).all()
    # all wait for who is late, so that nobody is behind others by more than that and what is lost in a second
    assert np.ptp(kept.times_s, axis=0).max() <= LATE_S + 0.2
    assert np.ptp(apart.times_s, axis=0).max() > 10


def test_nobody_waits_for_a_robot_that_has_failed() -> None:
    asked = Conditions(hours=1.0, failures_per_hour=5.0, wind_m_s=0.3, wind_from_deg=90.0)
    scene = scene_of(crossing(), asked)
    number = next(n for n in range(50) if drive(scene, 0, n).fails_s[0] < 600 < 3700 < drive(scene, 0, n).fails_s[1])
    driven = drive(scene, 0, number)
    after_s = np.diff(driven.times_s[1, 700::40])
    # from then on only the one that crosses the wind counts
    assert after_s == pytest.approx(np.full(len(after_s), 40 / math.sqrt(1 - 0.09)))


def test_bodies_touch_where_brute_force_finds_them_nearest() -> None:
    plan = crossing()
    asked = Conditions(hours=1.0, wind_m_s=0.3, wind_from_deg=90.0, hands_off=True)
    scene = scene_of(plan, asked)
    driven = drive(scene, 0, 0)
    (contact,) = contacts_of(plan, scene.pairs, driven)
    moments_s = np.arange(0, 1500, 0.01)
    ticks = np.arange(driven.times_s.shape[1])
    a_m, b_m = (way.at(np.interp(moments_s, driven.times_s[k], ticks)) for k, way in enumerate(plan))
    near = np.hypot(*(a_m - b_m).T) < 1.0
    first = np.flatnonzero(near)[0]
    assert moments_s[first] - 0.02 <= contact.time_s <= moments_s[first] + 1.5
    assert contact.place_m == pytest.approx((10, 10), abs=1.0)
    assert (contact.robots, contact.stands) == ((0, 1), False)


def test_a_robot_that_failed_on_the_crossing_is_driven_into() -> None:
    plan = crossing(body_m=1.0)
    scene = scene_of(plan, Conditions(hours=1.0, failures_per_hour=5.0))
    drives = [drive(scene, 0, number) for number in range(300)]
    hit = 0
    for driven in drives:
        x = float(plan["a"].at(driven.fails_s[0])[0])
        stands_there = abs(x - 10) < 1.9 and driven.fails_s[0] + 40 < min(driven.fails_s[1], scene.end_s)
        found = contacts_of(plan, scene.pairs, driven)
        assert not any(not contact.stands for contact in found)
        if stands_there:
            hit += 1
            assert any(contact.stands for contact in found)
        elif driven.fails_s.min() > scene.end_s:
            assert found == []
    assert hit > 5


def test_who_is_at_a_charger_is_in_nobodys_way() -> None:
    plan = taking_turns()
    scene = scene_of(plan, Conditions(hours=1.0))
    assert len(scene.pairs) == 1
    assert contacts_of(plan, scene.pairs, drive(scene, 0, 0)) == []


def test_bodies_that_speed_up_and_brake_touch_where_they_do() -> None:
    """One goes 16 m from rest to rest in 8 s, the other stands beside its way: they touch when it is there."""
    way = with_mass().trajectories[0]
    mission = replace(with_mass().mission, fleet=replace(with_mass().mission.fleet, body_radius_m=0.25))
    other = Trajectory(robot="robot-2", times_s=[0], positions_m=[[9.5, 2.4]])
    plan = Plan(mission=replace(mission, fleet=replace(mission.fleet, robots=2)), trajectories=(way, other))
    scene = scene_of(plan, Conditions(hours=0.1))
    (contact,) = contacts_of(plan, scene.pairs, drive(scene, 0, 0))
    # within 0.3 m of x = 9.5 on the way out from (8, 2) at 5 + 4 s, at 3 m/s and braking by 0.75 m/s2
    times_s = np.arange(9.0, 11.0, 1e-5)
    near = np.hypot(*(way.at(times_s) - (9.5, 2.4)).T) < 0.5
    assert times_s[near][0] - 1e-4 <= contact.time_s <= times_s[near][-1] + 1e-4
    assert contact.place_m[1] == pytest.approx(2.2)
    just_off = replace(plan, trajectories=(way, replace(other, positions_m=[[9.5, 2.5]])))
    assert contacts_of(just_off, scene.pairs, drive(scene_of(just_off, Conditions(hours=0.1)), 0, 0)) == []

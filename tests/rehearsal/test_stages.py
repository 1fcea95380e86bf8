"""Runs in which plans for those that remain take over, beside brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.rehearsal.rehearsed_plans import post, round_a_block, taking_turns
from tests.relieved import relieved, with_battery
from tests.replanning.relays import relay

import rota
from rota import Plan
from rota.check.charging import battery_levels
from rota.model.seam import Seam
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.rehearsal import rehearsal_table, rehearsal_to_json
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.many_runs import rehearse_once
from rota.rehearsal.scene import Scene, scene_of
from rota.rehearsal.stages import IN_PHASE_S, TAKES_OVER_S, Stage, drive_in_stages
from rota.routes.flights import on_charger
from rota.routes.moments import way_before

STEP_S = 0.05


def places_of(stages: list[Stage], robot: int, moments_s: np.ndarray) -> np.ndarray:
    """Where a robot is at moments (n,) of a run, (n, 2), nan after it has failed: by the plan that it drives then."""
    places_m = np.full((len(moments_s), 2), np.nan)
    for stage in stages:
        times_s = stage.driven.times_s[robot]
        planned_s = np.interp(moments_s, times_s, stage.driven.tick_s * np.arange(len(times_s)))
        now = (moments_s >= times_s[0]) & (moments_s <= min(stage.until_s[robot], stage.driven.fails_s[robot]))
        places_m[now] = stage.scene.plan.trajectories[robot].at(planned_s[now])[:, :2]
    return places_m


def test_a_run_with_a_plan_that_takes_over_is_as_brute_force_has_it() -> None:
    """Three robots on a ring of 64 s, of which two fail one after the other."""
    plan = round_a_block((64.0, 64.0, 64.0))
    scene = scene_of(plan, Conditions(hours=0.3, failures_per_hour=2.0, speed_noise=0.05, replan=True))
    number = next(n for n in range(50) if len(drive_in_stages(scene, 0, n)[0]) == 3)
    stages, refusal = drive_in_stages(scene, 0, number)
    assert refusal is None
    fails_s = np.sort(stages[0].driven.fails_s)
    run, late_s, worst_s = rehearse_once(scene, 0, number)
    assert (run.takeovers, run.failed) == (2, 2 + (fails_s[2] < scene.end_s))
    moments_s = np.arange(0, scene.end_s, STEP_S)
    tracks = [places_of(stages, robot, moments_s) for robot in range(3)]
    for robot, track_m in enumerate(tracks):
        steps_m = np.hypot(*np.diff(track_m[moments_s < stages[0].driven.fails_s[robot]], axis=0).T)
        # nobody jumps where a plan takes over; who leaves out a wait of half a second is twice as fast
        assert np.nanmax(steps_m) <= 2 * STEP_S
    for stage, failed_s in zip(stages[1:], fails_s[:2], strict=True):
        assert TAKES_OVER_S <= stage.driven.times_s[:, 0].max() - failed_s <= TAKES_OVER_S + 3
    seen = np.zeros(len(moments_s), bool)
    for track_m in tracks:
        with np.errstate(invalid="ignore"):
            seen |= (np.abs(track_m - (18.0, 8.0)) <= 1.0).all(axis=1)
    door = len(scene.points_m)
    seen_s = np.maximum.accumulate(np.where(seen, moments_s, 0.0))
    assert late_s[door] == pytest.approx(STEP_S * np.count_nonzero(moments_s - seen_s > 40.0), abs=2.0)
    assert worst_s[door] == pytest.approx((moments_s - seen_s).max(), abs=0.5)


def test_failures_are_the_same_with_and_without_replanning() -> None:
    plan, asked = round_a_block((64.0, 64.0)), {"hours": 0.3, "failures_per_hour": 2.0, "runs": 5, "seed": 2}
    without, replanned = (rota.rehearse(plan, **asked, replan=replan) for replan in (False, True))
    assert without.failed == replanned.failed
    assert without.takeovers is None
    assert replanned.takeovers is not None
    assert 0 < replanned.takeovers.mean <= replanned.failed.mean
    assert any(line.startswith("plans that take over, 15 s after") for line in rehearsal_table(replanned).splitlines())
    calm = [rota.rehearse(plan, hours=0.3, speed_noise=0.05, runs=3, replan=replan) for replan in (False, True)]
    assert (calm[0].parts_available == calm[1].parts_available).all()


def test_a_post_that_is_left_is_taken_over() -> None:
    """One of two robots that each see all of a room fails: with or without replanning nothing is late."""
    made = rota.rehearse(post(60.0, 2), hours=0.5, failures_per_hour=0.5, runs=10, replan=True)
    by_hand = rota.rehearse(post(60.0, 2), hours=0.5, failures_per_hour=0.5, runs=10)
    assert made.available == by_hand.available


def test_where_no_plan_takes_over_it_is_told_once_and_runs_go_on() -> None:
    plan, asked = post(60.0, 2), {"hours": 0.5, "failures_per_hour": 1.0, "runs": 4}
    plan = replace(plan, mission=replace(plan.mission, planning=SwarmSettings()))
    made, without = rota.rehearse(plan, **asked, replan=True), rota.rehearse(plan, **asked)
    assert made.refusal is not None
    assert made.refusal.endswith("planner: swarm is not allowed; only robots that drive rounds of patrol take over")
    assert (made.parts_available == without.parts_available).all()
    told = [line for line in rehearsal_table(made).splitlines() if "take over" in line and "swarm" in line]
    assert len(told) == 1
    assert rehearsal_to_json(made)["not_replanned"] == made.refusal


def stages_with_losses(plan: Plan, conditions: Conditions, count: int) -> tuple[Scene, int, list[Stage]]:
    """The stages of the first run in which so many plans take over, with its scene and number."""
    scene = scene_of(plan, conditions)
    for number in range(60):
        stages, refusal = drive_in_stages(scene, 0, number)
        if len(stages) == count + 1:
            assert refusal is None
            return scene, number, stages
    raise AssertionError("no such run")


DEAR = with_battery(relieved(3), takeoff_s=30)  # to take off


@pytest.mark.parametrize("plan", [relay(spare=True), relay(spare=False), taking_turns(), relieved(3), DEAR])
def test_without_noise_batteries_are_the_checks_also_after_a_loss(plan: Plan) -> None:
    """What is least in a battery is so before the change or after it: each as the check has it."""
    scene, number, (first, second) = stages_with_losses(
        plan, Conditions(hours=0.5, failures_per_hour=2.0, replan=True), 1
    )
    fails_s = first.driven.fails_s
    charging = rehearse_once(scene, 0, number)[0].charging
    assert charging is not None
    assert charging.hurries_s.max() == 0
    at_s = float(np.nanmax(first.until_s))
    for k, way in enumerate(plan):
        before, line = battery_levels(plan, way), second.scene.plan.trajectories[k]
        if fails_s[k] >= scene.end_s:
            then_s = before.at(at_s, way)
            assert first.fills.levels_s[k] == pytest.approx(then_s, abs=1e-6)
            assert second.scene.batteries.endurance_s[k] * line.battery == pytest.approx(then_s, abs=1e-6)
            before_it = way_before(way, plan.mission.fleet.robot(way.robot).sensor, at_s, 1.0)
            later = replace(second.scene.plan, seam=Seam(at_s=at_s, driven=(before_it,)))
            after_s = battery_levels(later, line).levels_s.min()
            least_s = min(after_s, *(before.at(float(t), way) for t in np.arange(0, at_s, scene.tick_s)))
            assert charging.least_s[k] == pytest.approx(least_s, abs=1e-6)


def test_batteries_go_on_where_plans_take_over_as_steps_in_time_have_them() -> None:
    """A relay of four with noise, of which two are lost: levels by steps, from where each is by the plan of then."""
    asked = Conditions(hours=0.5, failures_per_hour=2.0, speed_noise=0.03, late_relief_s=1.0, replan=True)
    scene, number, stages = stages_with_losses(relay(spare=True), asked, 2)
    charging = rehearse_once(scene, 0, number)[0].charging
    assert charging is not None
    for robot in range(4):
        ends_s = min(stages[0].driven.fails_s[robot], stages[-1].driven.times_s[robot, -1])
        moments_s = np.arange(0, ends_s, STEP_S)
        docked = np.zeros(len(moments_s), bool)
        for stage in stages:
            times_s = stage.driven.times_s[robot]
            planned_s = np.interp(moments_s, times_s, stage.driven.tick_s * np.arange(len(times_s)))
            now = (moments_s >= times_s[0]) & (moments_s <= stage.until_s[robot])
            docked[now] = on_charger(stage.scene.plan.trajectories[robot], planned_s[now])
        level_s, least_s, left = 60.0, 60.0, 0
        for k in range(len(moments_s)):
            level_s = min(60.0, level_s + STEP_S * 60 / 120) if docked[k] else level_s - STEP_S
            least_s = min(least_s, level_s)
            left += k > 0 and docked[k - 1] and not docked[k]
        assert charging.least_s[robot] == pytest.approx(least_s, abs=0.5)
        assert stages[-1].fills.left[robot] == left
    assert 0 < charging.reliefs == stages[-1].fills.left.sum()


def test_who_is_late_where_nobody_waits_is_late_for_the_plan_that_takes_over() -> None:
    """Hands off, each robot goes over at one moment, from where it is, though some are far behind others by then."""
    asked = Conditions(hours=0.5, failures_per_hour=2.0, speed_noise=0.2, hands_off=True, replan=True)
    _, _, (first, second) = stages_with_losses(round_a_block((64.0, 64.0, 64.0)), asked, 1)
    alive = first.driven.fails_s > first.until_s
    then_s = first.until_s[alive]
    assert np.ptp(then_s) <= 2 * IN_PHASE_S + 1
    behind = [
        np.interp(then_s.mean(), first.driven.times_s[k], np.arange(len(first.driven.times_s[k]))) for k in range(3)
    ]
    assert np.ptp(np.array(behind)[alive]) > 10
    for k in np.flatnonzero(alive):
        old, new = (stage.scene.plan.trajectories[k] for stage in (first, second))
        ticks = first.driven.tick_s * np.arange(first.driven.times_s.shape[1])
        planned_s = float(np.interp(first.until_s[k], first.driven.times_s[k], ticks))
        assert np.hypot(*(old.at(planned_s) - new.positions_m[0])) < 1e-6

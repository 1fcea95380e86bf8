"""Runs in which plans for those that remain take over, beside brute force."""

from __future__ import annotations

import numpy as np
import pytest
from tests.rehearsal.rehearsed_plans import post, round_a_block, taking_turns

import rota
from rota import Plan
from rota.rehearsal import rehearsal_table, rehearsal_to_json
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.run import rehearse_once
from rota.rehearsal.scene import scene_of
from rota.rehearsal.stages import TAKES_OVER_S, Stage, drive_in_stages

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
        assert np.nanmax(steps_m) <= 1.2 * STEP_S  # nobody jumps where a plan takes over
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


@pytest.mark.parametrize("plan", [taking_turns()], ids=["charging"])
def test_where_replanning_is_refused_it_is_told_once_and_runs_go_on(plan: Plan) -> None:
    asked = {"hours": 0.5, "failures_per_hour": 1.0, "runs": 6}
    made, without = rota.rehearse(plan, **asked, replan=True), rota.rehearse(plan, **asked)
    assert made.refusal is not None
    assert made.refusal.endswith("chargers: robots that charge are not replanned in rehearsals")
    assert (made.parts_available == without.parts_available).all()
    told = [line for line in rehearsal_table(made).splitlines() if "are not replanned" in line]
    assert len(told) == 1
    assert rehearsal_to_json(made)["not_replanned"] == made.refusal

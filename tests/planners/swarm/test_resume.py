"""Runs that are stopped and gone on with: the outcome is that of a run without a stop, byte for byte."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from shapely import MultiPolygon, box

from rota.errors import CheckpointError, MissionError
from rota.files.checkpoint_file import read_checkpoint, write_checkpoint
from rota.files.plan_file import plan_text
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, Obstacle, StartBox
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.trajectory_log import LONGEST_BLOCK
from rota.planning.make_plan import search_plan


def mission(robots: int = 16, most_steps: int = 300, side_m: float = 170, **changed: Any) -> Mission:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=0.5)
    box_m = StartBox(low_m=(1, 1), high_m=(side_m / 4, side_m / 4))
    listed = tuple(fleet.equal_robot(f"r{k}") for k in range(robots))
    return Mission(
        name="resumed",
        area=MultiPolygon([box(0, 0, side_m, side_m)]),
        obstacles=(Obstacle(shape=MultiPolygon([box(60, 60, 75, 70)])),),
        moving_obstacles=(MovingObstacle(radius_m=2, times_s=(0, 70), positions_m=((0, 50), (100, 50))),),
        fleet=Fleet(speed_m_s=2, sensor=fleet.sensor, body_radius_m=0.5, robots=listed, start=box_m),
        planning=SwarmSettings(most_steps=most_steps, **changed),
    )


@cache
def whole_run(controller: Any) -> SwarmRun:
    """Without a stop; the same whatever it is compared with."""
    return run_mission(mission(controller=controller), seed=4)


def stopped_after(steps: int):
    calls = iter(range(10**9))
    return lambda: next(calls) >= steps


@pytest.mark.parametrize("steps", [[0], [1], [100], [LONGEST_BLOCK - 1, LONGEST_BLOCK], [70, LONGEST_BLOCK + 30]])
@pytest.mark.parametrize("controller", ["settle", "reciprocal", "voronoi", "virtual_force"])
def test_a_resumed_run_ends_as_one_without_a_stop(controller: Any, steps: list[int], tmp_path: Path) -> None:
    asked = mission(controller=controller)
    whole = whole_run(controller)
    state = None
    for stop in steps:
        begun = 0 if state is None else state.steps
        state = run_mission(asked, seed=4, should_stop=stopped_after(stop - begun), resume=state).state
        assert state.steps == stop
        write_checkpoint(state, tmp_path / "half.rota-run")
        state = read_checkpoint(tmp_path / "half.rota-run")
    rest = run_mission(asked, seed=4, resume=state)
    assert plan_text(rest.plan) == plan_text(whole.plan)
    assert (rest.steps, rest.at_rest) == (whole.steps, whole.at_rest)


@pytest.mark.parametrize(("threads", "then"), [(1, 2), (2, 1), (2, 2)])
def test_sampled_velocities_go_on_where_they_were_on_any_number_of_threads(threads: int, then: int) -> None:
    asked = mission(
        robots=600, side_m=1200, most_steps=24, controller="reciprocal", velocity="sampled", samples=60, filter=False
    )
    whole = run_mission(asked, seed=9)
    state = run_mission(asked, seed=9, should_stop=stopped_after(11), threads=threads).state
    assert plan_text(run_mission(asked, seed=9, resume=state, threads=then).plan) == plan_text(whole.plan)


@pytest.mark.parametrize("controller", ["settle", "reciprocal", "voronoi", "virtual_force"])
def test_messages_that_are_under_way_arrive_after_a_stop(controller: Any, tmp_path: Path) -> None:
    asked = mission(robots=30, most_steps=40, controller=controller, delay_steps=2, messages_lost=0.2)
    whole = run_mission(asked, seed=2)
    exact = run_mission(mission(robots=30, most_steps=40, controller=controller), seed=2)
    assert whole.plan.trajectories != exact.plan.trajectories
    write_checkpoint(run_mission(asked, seed=2, should_stop=stopped_after(17)).state, tmp_path / "half.rota-run")
    state = read_checkpoint(tmp_path / "half.rota-run")
    assert plan_text(run_mission(asked, seed=2, resume=state, threads=2).plan) == plan_text(whole.plan)
    with pytest.raises(CheckpointError, match="past: messages of 3 steps; 11 are needed"):
        run_mission(asked, seed=2, resume=dataclasses.replace(state, past=state.past[:3]))


def test_a_run_that_its_most_steps_ended_goes_on_with_more_of_them() -> None:
    few, many = (dataclasses.replace(mission(most_steps=most), moving_obstacles=()) for most in (50, 2000))
    found = search_plan(few, seed=1)
    assert found.checkpoint is not None
    rest, whole = search_plan(many, seed=1, resume=found.checkpoint), search_plan(many, seed=1)
    assert rest.plan == whole.plan
    assert rest.checkpoint is None  # it came to rest
    with pytest.raises(CheckpointError, match=r"swarm\.most_steps: 49 is not allowed; the run has made 50 steps"):
        search_plan(dataclasses.replace(few, planning=SwarmSettings(most_steps=49)), seed=1, resume=found.checkpoint)


def test_a_run_goes_on_with_its_own_mission_and_seed_only() -> None:
    run = run_mission(mission(), seed=1, should_stop=stopped_after(3)).state
    with pytest.raises(CheckpointError, match="seed: 2 is not allowed; the run has the seed 1"):
        run_mission(mission(), seed=2, resume=run)
    with pytest.raises(CheckpointError, match=r"another mission: swarm.time_step_s, swarm.thinning_m differ"):
        run_mission(mission(time_step_s=0.2, thinning_m=0.01), seed=1, resume=run)
    with pytest.raises(CheckpointError, match="another mission: area, fleet differ"):
        run_mission(mission(side_m=171), seed=1, resume=run)
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25))
    patrol = Mission(name="p", area=mission().area, fleet=fleet, period_s=90, planning=PatrolSettings())
    with pytest.raises(MissionError, match="patrol makes no runs"):
        search_plan(patrol, resume=run)

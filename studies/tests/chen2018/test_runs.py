"""Runs of the study: on the paper's maps, each once, the same as any other run of the planner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box
from tests.planners.swarm.conftest import in_box
from tests.planners.swarm.test_last_filter import wishing

from rota.planners.swarm.metrics import Observer
from rota.planners.swarm.planner import run_mission
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.dense import closest_approach_m, dense_contacts, dense_state
from rota_studies.chen2018.runs import EXACT, FILTERED, SETTLE, Job, Runs, obstacle_distances_m, settled_step
from rota_studies.study_runs import StudyStopped


@pytest.mark.parametrize("start", maps.STARTS)
def test_the_small_case_has_the_sizes_of_table_2(start: maps.Start) -> None:
    mission = maps.small(start)
    assert mission.area.bounds == (0, 0, 250, 250)
    box = mission.fleet.start
    assert np.subtract(box.high_m, box.low_m) == pytest.approx([50, 50])
    robot = mission.fleet.robots[24]
    assert (len(mission.fleet.robots), robot.speed_m_s, robot.body_radius_m) == (25, 2, 0.5)
    # as dense with any number
    assert maps.square(100, start).area.area == pytest.approx(100 / 25 * 250**2)


def test_obstacles_stand_clear_of_the_start_boxes() -> None:
    for mission in (maps.with_obstacle("between"), maps.with_obstacle("corner"), maps.large()):
        box = shapely.box(*mission.fleet.start.low_m, *mission.fleet.start.high_m)
        assert all(obstacle.shape.distance(box) > 1 for obstacle in mission.obstacles)
        assert all(mission.area.contains(obstacle.shape) for obstacle in mission.obstacles)
    assert maps.with_obstacle("between").obstacles[0].shape.area == pytest.approx(100)


def test_table_3_is_the_mean_of_its_cases_but_for_one_misprint() -> None:
    for name, (*cases, mean) in paper.TABLE_3_MS.items():
        assert np.mean(cases) == pytest.approx(mean, abs=0.0006) or name == "RD"
    assert np.mean(paper.TABLE_3_MS["RD"][:3]) == pytest.approx(14.801)


def test_an_outcome_is_that_of_the_planner(make_runs: Callable[..., Runs]) -> None:
    mission = maps.with_obstacle("between")
    outcome = make_runs(seed=3)(mission, FILTERED)
    asked = replace(mission, planning=replace(FILTERED.settings, most_steps=60))
    run = run_mission(asked, seed=3)
    assert (outcome.steps, outcome.at_rest) == (60, False)
    ends = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert outcome.drawn.places_at(60) == pytest.approx(ends, rel=1e-6)
    discs = shapely.union_all([Point(end).buffer(25, quad_segs=64) for end in ends])
    free = mission.area.difference(mission.obstacles[0].shape)
    assert outcome.coverage == pytest.approx(discs.intersection(free).area / free.area, rel=1e-3)
    distances = obstacle_distances_m(mission, outcome.drawn.places_m)
    x, y = np.abs(ends - 125).T - 5
    assert distances[-1] == pytest.approx(np.hypot(np.maximum(x, 0), np.maximum(y, 0)), rel=1e-5)


def test_what_is_known_is_not_run_again(make_runs: Callable[..., Runs]) -> None:
    runs = make_runs()
    told: list[str] = []
    runs.tell = told.append
    first = runs.seeds(maps.small("corner"), SETTLE)
    assert runs.all([Job(maps.small("corner"), SETTLE, seed, 60) for seed in (1, 0)]) == first[::-1]
    assert sorted(told) == ["25 robots, corner: settle, seed 0", "25 robots, corner: settle, seed 1"]


def test_a_stop_within_a_run_shows_nothing(make_runs: Callable[..., Runs]) -> None:
    asked: list[None] = []

    def should_stop() -> bool:
        asked.append(None)
        return len(asked) > 20

    with pytest.raises(StudyStopped):
        make_runs(should_stop=should_stop)(maps.small("centre"), EXACT)


def test_closest_approach_by_hand() -> None:
    # two that pass each other at 3 m, and one far off
    before, after = np.array([[0, 0], [10, 3], [50, 50.0]]), np.array([[10, 0], [0, 3], [50, 50.0]])
    assert closest_approach_m(before, after) == pytest.approx(3)
    assert closest_approach_m(before, before) == pytest.approx(np.hypot(10, 3))


def test_dense_states_do_not_touch_and_the_filter_keeps_it_so() -> None:
    rng = np.random.default_rng(8)
    for _ in range(100):
        places, velocities = dense_state(rng)
        assert closest_approach_m(places, places) >= 1 - 1e-12
        assert np.hypot(*velocities.T).max() <= paper.SPEED_M_S
    contacts, least_m = dense_contacts(EXACT.settings, seed=8, tried=100)
    assert contacts > 10
    assert least_m < 1
    assert dense_contacts(FILTERED.settings, seed=8, tried=100)[0] == 0


def test_a_run_that_was_cut_off_has_settled_only_after_a_while_without_change() -> None:
    wish = np.array([[-2.0, 0], [0.0, 0]])
    swarm = in_box([[0.9, 125], [125, 125]], decide=wishing(wish), safe=False)
    observer = Observer(swarm, MultiPolygon([box(0, 0, 250, 250)]), 1e-5)
    for step in range(60):
        if step == 44:
            wish[0] = 0.0
        swarm.step()
        observer.note(0.0)
        if step + 1 == 50:  # the coverage changed up to step 42, more than three quarters of the run
            assert settled_step(observer.history(), 0.0005, at_rest=False) == math.inf
            assert settled_step(observer.history(), 0.0005, at_rest=True) == 42
    assert settled_step(observer.history(), 0.0005, at_rest=False) == 42
    assert settled_step(observer.history(), 1.0, at_rest=False) == 0

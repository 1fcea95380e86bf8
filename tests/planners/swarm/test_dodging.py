"""Dodging discs that do not give way: the least change, by brute force, and robots at rest that are in the way."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, Robot
from rota.planners.swarm.dodge_kernels import out_of_way
from rota.planners.swarm.planner import DECIDE, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

AHEAD_S, STEP_S = 5.0, 0.25


def nearest_m(place: np.ndarray, velocities: np.ndarray, ahead_s: float) -> np.ndarray:
    """Least distance to a place within a time, going straight, (n,) for velocities (n, 2)."""
    speed2 = np.maximum((velocities**2).sum(axis=1), 1e-300)
    t = np.clip(velocities @ place / speed2, 0, ahead_s)
    return np.asarray(np.hypot(*(place - t[:, None] * velocities).T))


def test_the_change_is_the_least_that_leaves_the_disc_alone() -> None:
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(np.linspace(-6, 6, 401), np.linspace(-6, 6, 401)), axis=-1).reshape(-1, 2)
    changed = 0
    for _ in range(80):
        place, velocity, reach_m = rng.uniform(-6, 6, 2), rng.uniform(-3, 3, 2), rng.uniform(0.5, 3)
        if np.hypot(*place) <= reach_m:
            continue
        change = np.array(out_of_way(*place, *velocity, reach_m, AHEAD_S, STEP_S))
        assert nearest_m(place, (velocity + change)[None], AHEAD_S)[0] >= reach_m - 1e-9
        free = grid[nearest_m(place, grid, AHEAD_S) >= reach_m]
        least = np.hypot(*(free - velocity).T).min()
        assert np.hypot(*change) <= least + 1e-9
        assert np.hypot(*change) >= least - 0.05  # the lattice is 0.03 m/s fine
        changed += bool(change.any())
    assert changed > 10


def test_a_disc_that_is_met_already_is_left_within_one_step() -> None:
    change = np.array(out_of_way(1.0, 0.0, 0.0, 0.0, 1.5, AHEAD_S, STEP_S))
    assert change == pytest.approx([-0.5 / STEP_S, 0])
    assert np.hypot(*out_of_way(0.0, 0.0, 0.0, 0.0, 1.5, AHEAD_S, STEP_S)) == pytest.approx(1.5 / STEP_S)


@pytest.mark.parametrize("controller", DECIDE)
def test_robots_at_rest_make_way_whatever_moves_them(controller: Any) -> None:
    robots = tuple(
        Robot(name=f"r{k}", speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=0.5, start=start)
        for k, start in enumerate([(40.0, 50.0), (75.0, 51.0), (110.0, 50.6), (60.0, 90.0)])
    )
    obstacle = MovingObstacle(radius_m=3, times_s=(0, 150, 250), positions_m=((-10, 51), (-10, 51), (160, 51)))
    asked = Mission(
        name="crossing",
        area=MultiPolygon([box(0, 0, 150, 100)]),
        fleet=Fleet(speed_m_s=2, sensor=robots[0].sensor, robots=robots),
        moving_obstacles=(obstacle,),
        planning=SwarmSettings(controller=controller, most_steps=1300),
    )
    assert check_plan(run_mission(asked, seed=0).plan).violations == ()
    free = dataclasses.replace(asked, planning=dataclasses.replace(SwarmSettings.of(asked), filter=False))
    if controller == "virtual_force":  # whose robots stand where the obstacle comes
        assert {v.kind for v in check_plan(run_mission(free, seed=0).plan).violations} == {"moving obstacle"}

"""The reciprocal controller in three dimensions: processor time of a step, and what the example covers."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from benchmarks.row import Options, Row
from benchmarks.swarm_step import speedup_row
from rota.files.mission_file import read_mission
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.space_kernels import Bands
from rota.planners.swarm.space_rollout import SpaceSwarm
from rota.planners.swarm.state import Rule
from rota.planners.swarm.world import kinds_of
from rota.planning.plan_summary import range_at_the_end

EXAMPLE = Path(__file__).parents[1] / "examples" / "swarm-space.yaml"
ROBOTS, STEPS, SETTLING_STEPS, MOST_US = 100_000, 7, 10, 20.0
AREA_M2, BAND_M = 250**2 / 25, (30.0, 60.0)
SEEDS, WITHIN = range(100, 110), 0.01


def swarm_space(options: Options) -> Iterator[Row]:
    """A step of many robots on one thread, with the last filter; the example from ten seeds it was not tuned on."""
    swarm_of(100).step()  # compiles
    swarm = swarm_of(ROBOTS)
    times = []
    for k in range(SETTLING_STEPS + STEPS):
        began_s = time.process_time()
        swarm.step()
        if k >= SETTLING_STEPS:
            times.append(time.process_time() - began_s)
    microseconds = statistics.median(times) / ROBOTS * 1e6
    name = f"swarm in space, one step of {ROBOTS:,} robots, one thread, for one robot"
    yield Row(name, f"< {MOST_US} us", f"{microseconds:.2f} us", microseconds < MOST_US)
    yield speedup_row(f"swarm in space, {ROBOTS:,} robots, two threads", swarm_of, ROBOTS)
    yield example_row("settle", WITHIN)
    yield example_row("reciprocal", WITHIN)


def example_row(controller: Literal["settle", "reciprocal"], within: float) -> Row:
    """What the example covers by a controller, beside the most that any heights and places can: discs side by side."""
    mission = read_mission(EXAMPLE).mission
    mission = replace(mission, planning=replace(SwarmSettings.of(mission), controller=controller))
    ceiling_m = SwarmSettings.of(mission).altitudes_m[-1]  # type: ignore[index]
    shares, steps, rest, low = [], [], 0, 0
    for seed in SEEDS:
        run = run_mission(mission, seed=seed)
        seen, free, _ = range_at_the_end(run.plan)
        shares.append(seen.area / free.area)
        steps.append(run.steps)
        rest += run.at_rest
        low += sum(bool(trajectory.positions_m[-1, 2] < ceiling_m - 1e-3) for trajectory in run.plan)
    robots = mission.fleet.robots or ()
    footprints = sum(math.pi * robot.sensor.radius_at_m(ceiling_m) ** 2 for robot in robots)  # type: ignore[union-attr]
    most = footprints / mission.area.area
    measured = (
        f"{statistics.mean(shares):.2%}, worst {min(shares):.2%}; {low} robots below the ceiling; {rest} of"
        f" {len(shares)} at rest, after {min(steps):,} to {max(steps):,} steps"
    )
    name = f"swarm in space, the example by {controller}, seeds {SEEDS[0]} to {SEEDS[-1]}"
    asked = f"mean within {100 * within:.0f} point of {most:.2%}, the most possible; nobody low, all at rest"
    reached = statistics.mean(shares) >= most - within and low == 0 and rest == len(shares)
    return Row(name, asked, measured, reached)


def swarm_of(robots: int, threads: int = 1) -> SpaceSwarm:
    """Robots at random places over a square, as dense as in Chen et al. 2018, Table 2, and in a band of 30 m."""
    side_m = math.sqrt(robots * AREA_M2)
    low, high = (1, 1, BAND_M[0]), (side_m - 1, side_m - 1, BAND_M[1])
    places = np.random.default_rng(0).uniform(low, high, (robots, 3))
    corners = np.array([[0, 0], [side_m, 0], [side_m, side_m], [0, side_m], [0, 0]])
    fleet = kinds_of(robots, body_m=0.5, sensor_m=25, speed_m_s=2, neighbour_range_m=51, wall_range_m=25)
    rule = Rule(neighbours=4, circle=False, horizon_s=1.0, alpha=1.0, samples=0, seed=0, time_step_s=0.25)
    walls = np.hstack([corners[:-1], corners[1:]])
    return SpaceSwarm(
        Beginning(places), fleet, walls, rule, bands=Bands(*(np.full(robots, end) for end in BAND_M)),
        full_m=np.full(robots, -np.inf), threads=threads,
    )  # fmt: skip

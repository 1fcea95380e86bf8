"""The reciprocal controller in three dimensions: processor time of a step, and what the example covers."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.row import Options, Row
from rota.files.mission_file import read_mission
from rota.plan_summary import range_at_the_end
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.rollout import Beginning
from rota.planners.swarm.space_kernels import Band
from rota.planners.swarm.space_rollout import SpaceSwarm
from rota.planners.swarm.state import Rule
from rota.planners.swarm.world import kinds_of

EXAMPLE = Path(__file__).parents[1] / "examples" / "swarm-space.yaml"
ROBOTS, STEPS, SETTLING_STEPS, MOST_US = 100_000, 7, 10, 20.0
AREA_M2, BAND_M = 250**2 / 25, (30.0, 60.0)
SEEDS, LEAST_MEAN, LEAST_WORST = range(100, 110), 0.66, 0.64  # discs at the ceiling have 67.96 % at most


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
    mission = read_mission(EXAMPLE).mission
    shares, steps, rest = [], [], 0
    for seed in SEEDS:
        run = run_mission(mission, seed=seed)
        seen, free, _ = range_at_the_end(run.plan)
        shares.append(seen.area / free.area)
        steps.append(run.steps)
        rest += run.at_rest
    measured = (
        f"{statistics.mean(shares):.2%}, worst {min(shares):.2%}; {rest} of {len(shares)} at rest,"
        f" after {min(steps):,} to {max(steps):,} steps"
    )
    asked = f"mean {LEAST_MEAN:.0%}, worst {LEAST_WORST:.0%}, all at rest"
    name = f"swarm in space, the example, seeds {SEEDS[0]} to {SEEDS[-1]}"
    reached = statistics.mean(shares) >= LEAST_MEAN and min(shares) >= LEAST_WORST and rest == len(shares)
    yield Row(name, asked, measured, reached)


def swarm_of(robots: int) -> SpaceSwarm:
    """Robots at random places over a square, as dense as in Chen et al. 2018, Table 2, and in a band of 30 m."""
    side_m = math.sqrt(robots * AREA_M2)
    low, high = (1, 1, BAND_M[0]), (side_m - 1, side_m - 1, BAND_M[1])
    places = np.random.default_rng(0).uniform(low, high, (robots, 3))
    corners = np.array([[0, 0], [side_m, 0], [side_m, side_m], [0, side_m], [0, 0]])
    fleet = kinds_of(robots, body_m=0.5, sensor_m=25, speed_m_s=2, neighbour_range_m=51, wall_range_m=25)
    rule = Rule(neighbours=4, circle=False, horizon_s=1.0, alpha=1.0, samples=0, seed=0, time_step_s=0.25)
    walls = np.hstack([corners[:-1], corners[1:]])
    return SpaceSwarm(
        Beginning(places), fleet, walls, rule, band=Band(*BAND_M), full_m=np.full(robots, -np.inf)
    )  # fmt: skip

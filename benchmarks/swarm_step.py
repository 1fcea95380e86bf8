"""One step of the swarm's published controller: processor time for one robot, and what a second thread brings."""

from __future__ import annotations

import math
import resource
import statistics
import sys
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.row import Options, Row
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.rollout import Beginning, Controller, Surroundings, Swarm
from rota.planners.swarm.state import Rule
from rota.planners.swarm.world import kinds_of

SIZES = (1_000, 100_000, 1_000_000)
MOST_US, LEAST_SPEEDUP, MOST_BYTES = 1.0, 1.6, 4e9
AREA_M2 = 250**2 / 25  # for one robot: as in Chen et al. 2018, Table 2, like all else here
SETTLING_STEPS, ROBOT_STEPS, FEWEST_STEPS, THREAD_STEPS = 20, 2_000_000, 5, 41


def swarm_step(options: Options) -> Iterator[Row]:
    """The reciprocal controller with its exact centroid and the last filter, from random places, after a few steps."""
    swarm_of(100).step()  # compiles
    for robots in SIZES:
        times = step_times(swarm_of(robots), robots)
        microseconds = statistics.median(times) / robots * 1e6
        measured = f"{microseconds:.2f} us"
        if robots == SIZES[-1]:
            measured += f"; peak {peak_bytes() / 1e9:.2f} GB of the process"
        name = f"swarm, one step of {robots:,} robots, one thread, for one robot"
        yield Row(name, f"< {MOST_US} us", measured, microseconds < MOST_US and peak_bytes() < MOST_BYTES)


def swarm_threads(options: Options) -> Iterator[Row]:
    """The same step by one thread and by two, in turns, so that both have the machine as it is."""
    swarms = [swarm_of(SIZES[1], threads) for threads in (1, 2)]
    for swarm in swarms:
        for _ in range(SETTLING_STEPS):
            swarm.step()
    times: list[list[float]] = [[], []]
    for _ in range(THREAD_STEPS):
        for swarm, mine in zip(swarms, times, strict=True):
            began_s = time.perf_counter()
            swarm.step()
            mine.append(time.perf_counter() - began_s)
    one, two = (statistics.median(mine) for mine in times)
    least, least_two = (min(mine) for mine in times)
    measured = (
        f"{one / two:.2f} x ({one * 1e3:.0f} and {two * 1e3:.0f} ms, medians of wall time in turns;"
        f" the least of each: {least / least_two:.2f} x)"
    )
    yield Row(f"swarm, {SIZES[1]:,} robots, two threads", f"> {LEAST_SPEEDUP} x", measured, one / two > LEAST_SPEEDUP)


def swarm_of(robots: int, threads: int = 1) -> Swarm:
    """Robots at random places of a square, as dense as in Table 2 and in motion."""
    side_m = math.sqrt(robots * AREA_M2)
    places = np.random.default_rng(0).uniform(1, side_m - 1, (robots, 2))
    corners = np.array([[0, 0], [side_m, 0], [side_m, side_m], [0, side_m], [0, 0]])
    fleet = kinds_of(robots, body_m=0.5, sensor_m=25, speed_m_s=2, neighbour_range_m=51, wall_range_m=25)
    rule = Rule(neighbours=4, circle=False, horizon_s=1.0, alpha=1.0, samples=0, seed=0, time_step_s=0.25)
    walls = np.hstack([corners[:-1], corners[1:]])
    return Swarm(Beginning(places), fleet, Surroundings(walls), Controller(decide_reciprocal, rule), threads=threads)


def step_times(swarm: Swarm, robots: int) -> list[float]:
    """Processor seconds of many steps in a row, each."""
    for _ in range(SETTLING_STEPS):
        swarm.step()
    times = []
    for _ in range(max(ROBOT_STEPS // robots, FEWEST_STEPS)):
        began_s = time.process_time()
        swarm.step()
        times.append(time.process_time() - began_s)
    return times


def peak_bytes() -> float:
    """The most memory that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

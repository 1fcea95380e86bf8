"""One step of a swarm: processor time for one robot, and what a second thread brings."""

from __future__ import annotations

import math
import resource
import statistics
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.row import Options, Row
from benchmarks.shell import rota, run
from rota.planners.swarm.deciding import FEWEST_IN_BLOCKS, Controller
from rota.planners.swarm.planner import ALL_NEIGHBOURS
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.state import Rule
from rota.planners.swarm.world import kinds_of

SIZES = (1_000, 100_000, 1_000_000)
MOST_US, LEAST_SPEEDUP, MOST_BYTES = 1.0, 1.6, 4e9
AREA_M2 = 250**2 / 25  # for one robot: as in Chen et al. 2018, Table 2, like all else here
PAPER = Rule(neighbours=4, circle=False, horizon_s=1.0, alpha=1.0, samples=0, seed=0, time_step_s=0.25)
SETTLING_STEPS, ROBOT_STEPS, FEWEST_STEPS, THREAD_STEPS = 20, 2_000_000, 5, 41
COMMAND_NAME, COMMAND_RUNS, LEAST_COMMAND = "`rota plan` of 1,000 robots that settle, two cores", 3, 1.3
COMMAND_MISSION = """\
rota: 1
name: swarm-threads
area: [[0, 0], [1600, 0], [1600, 1600], [0, 1600]]
fleet:
  robots: 1000
  speed_m_s: 2
  sensor: {shape: disc, radius_m: 25}
  body_radius_m: 0.5
  start: {box: [[700, 700], [900, 900]]}
planner: swarm
swarm:
  most_steps: 1000
"""
ON_ONE_CORE = "import os, sys; os.sched_setaffinity(0, {0}); os.execv(sys.argv[1], sys.argv[1:])"


def swarm_step(options: Options) -> Iterator[Row]:
    """The reciprocal controller with its exact centroid and the last filter, from random places, after a few steps."""
    for robots in (SIZES[0], FEWEST_IN_BLOCKS):
        swarm_of(robots).step()  # compiles
    for robots in SIZES:
        times = step_times(swarm_of(robots), robots)
        microseconds = statistics.median(times) / robots * 1e6
        measured = f"{microseconds:.2f} us"
        if robots == SIZES[-1]:
            measured += f"; peak {peak_bytes() / 1e9:.2f} GB of the process"
        name = f"swarm, one step of {robots:,} robots, one thread, for one robot"
        yield Row(name, f"< {MOST_US} us", measured, microseconds < MOST_US and peak_bytes() < MOST_BYTES)


def swarm_threads(options: Options) -> Iterator[Row]:
    """Steps by one thread and by two, in turns, so that both have the machine as it is; and the whole command."""
    for name, robots, make in (
        ("swarm", SIZES[1], swarm_of),
        ("swarm, settle", SIZES[1], settling_swarm_of),
        ("swarm, settle", SIZES[0], settling_swarm_of),
    ):
        yield speedup_row(f"{name}, {robots:,} robots, two threads", make, robots)
    yield command_row(options.folder)


def speedup_row(name: str, make: Callable[[int, int], Any], robots: int) -> Row:
    """What a second thread brings to a swarm's steps; ``make`` makes it of so many robots, for so many threads."""
    swarms = [make(robots, threads) for threads in (1, 2)]
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
        f"{one / two:.2f} x ({one * 1e3:.3g} and {two * 1e3:.3g} ms, medians of wall time in turns;"
        f" the least of each: {least / least_two:.2f} x)"
    )
    return Row(name, f"> {LEAST_SPEEDUP} x", measured, one / two > LEAST_SPEEDUP)


def command_row(folder: Path) -> Row:
    """What a second core brings to ``rota plan`` of many robots, check included."""
    mission = folder / "swarm-threads.yaml"
    mission.write_text(COMMAND_MISSION)
    on_one = [sys.executable, "-c", ON_ONE_CORE, Path(sysconfig.get_path("scripts")) / "rota"]
    plan = ["plan", mission, "-o", folder / "swarm-threads.rota.json"]
    walls: list[list[float]] = [[], []]
    for _ in range(COMMAND_RUNS):
        for mine, made in zip(walls, (run([*on_one, *plan]), rota(*plan)), strict=True):
            if made.code not in (0, 1):  # 1: the check is not met, which does not matter here
                return Row(COMMAND_NAME, f"> {LEAST_COMMAND} x", made.failure(), False)
            mine.append(made.wall_s)
    one, two = (statistics.median(mine) for mine in walls)
    measured = f"{one / two:.2f} x ({one:.1f} and {two:.1f} s, medians of {COMMAND_RUNS} runs in turns)"
    return Row(COMMAND_NAME, f"> {LEAST_COMMAND} x", measured, one / two > LEAST_COMMAND)


def settling_swarm_of(robots: int, threads: int = 1) -> Swarm:
    """As ``swarm_of``, by settle."""
    rule = PAPER._replace(neighbours=ALL_NEIGHBOURS)
    return _in_square(robots, Controller(decide_settle, rule), threads, neighbour_range_m=50)


def swarm_of(robots: int, threads: int = 1) -> Swarm:
    """Robots at random places of a square, as dense as in Table 2 and in motion."""
    return _in_square(robots, Controller(decide_reciprocal, PAPER), threads, neighbour_range_m=51)


def _in_square(robots: int, controller: Controller, threads: int, neighbour_range_m: float) -> Swarm:
    """Robots at random places of a square."""
    side_m = math.sqrt(robots * AREA_M2)
    places = np.random.default_rng(0).uniform(1, side_m - 1, (robots, 2))
    corners = np.array([[0, 0], [side_m, 0], [side_m, side_m], [0, side_m], [0, 0]])
    fleet = kinds_of(robots, body_m=0.5, sensor_m=25, speed_m_s=2, neighbour_range_m=neighbour_range_m, wall_range_m=25)
    walls = np.hstack([corners[:-1], corners[1:]])
    return Swarm(Beginning(places), fleet, Surroundings(walls), controller, threads=threads)


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

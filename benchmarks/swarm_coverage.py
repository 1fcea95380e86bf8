"""How much swarms cover and when they rest: Chen et al. 2018's small case from two starts, and the large one."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from rota.geometry.free_space import free_ground
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, StartBox
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

Floats = NDArray[np.float64]

SEEDS = range(100, 110)  # none of which anything was tuned on
SENSOR_M, SPEED_M_S, BODY_M = 25.0, 2.0, 0.5
STARTS = {"centre": (100.0, 150.0), "corner": (1.0, 51.0)}
MOST_STEPS, LEAST_MEAN, LEAST_WORST = 2000, 0.778, 0.77
LARGE_STEPS, LARGE_LEAST, EARLY_STEP = 5226, 0.92, 3000
LARGE_OBSTACLES_M = ((500, 650, 700, 750), (1100, 700, 1150, 900), (1200, 200, 1300, 350), (1500, 600, 1600, 800))
ROUNDING_M = 1e-9


class Outcome(NamedTuple):
    """Exact share covered in the end, steps, whether at rest, least distance of bodies and of a body and a wall.

    so_far: share covered after every step, by pixels.
    """

    covered: float
    steps: int
    at_rest: bool
    between_m: float
    beside_m: float
    so_far: Floats


def swarm_coverage(options: Options) -> Iterator[Row]:
    """The controller by default, with all else by default as well."""
    runs: list[Outcome] = []
    for start, (low, high) in STARTS.items():
        found = [outcome(small(low, high), seed) for seed in SEEDS]
        runs += found
        mean, worst = statistics.mean(run.covered for run in found), min(run.covered for run in found)
        steps, rest = [run.steps for run in found], sum(run.at_rest for run in found)
        measured = (
            f"{mean:.2%}, worst {worst:.2%}; {rest} of {len(found)} at rest, after {statistics.mean(steps):,.0f} steps,"
            f" {min(steps):,} to {max(steps):,}"
        )
        yield Row(
            f"swarm, 25 robots from the {start}, seeds {SEEDS[0]} to {SEEDS[-1]}",
            f"mean {LEAST_MEAN:.1%}, worst {LEAST_WORST:.0%}, all at rest within {MOST_STEPS:,} steps",
            measured,
            mean >= LEAST_MEAN and worst >= LEAST_WORST and rest == len(found),
        )
    large_run = outcome(large(), SEEDS[0])
    early = large_run.so_far[min(EARLY_STEP, large_run.steps)]
    runs.append(large_run)
    yield Row(
        "swarm, 1,000 robots in 2,000 m x 1,000 m with 4 obstacles, from a corner",
        f"{LARGE_LEAST:.0%}, at rest within {LARGE_STEPS:,} steps",
        f"{large_run.covered:.2%}, {'at rest' if large_run.at_rest else 'not at rest'} after {large_run.steps:,} steps;"
        f" {early:.1%} after {EARLY_STEP:,}",
        large_run.covered >= LARGE_LEAST and large_run.at_rest,
    )
    between, beside = min(run.between_m for run in runs), min(run.beside_m for run in runs)
    yield Row(
        f"swarm, least distance in these {len(runs)} runs between bodies, and to walls",
        f"never below -{ROUNDING_M:.0e} m",
        f"{between:.2g} and {beside:.2g} m",
        min(between, beside) >= -ROUNDING_M,
    )


def small(low_m: float, high_m: float) -> Mission:
    """25 robots in 250 m x 250 m from a square."""
    return mission(25, (250, 250), StartBox(low_m=(low_m, low_m), high_m=(high_m, high_m)), MOST_STEPS)


def large() -> Mission:
    """1,000 robots in 2,000 m x 1,000 m; where the obstacles of Figure 21 lie the paper does not say."""
    start = StartBox(low_m=(0, 0), high_m=(1000, 500))
    return mission(1000, (2000, 1000), start, LARGE_STEPS, LARGE_OBSTACLES_M)


def mission(
    robots: int,
    size_m: tuple[float, float],
    start: StartBox,
    most_steps: int,
    obstacles_m: tuple[tuple[float, float, float, float], ...] = (),
) -> Mission:
    """Robots as in Table 2."""
    like = Fleet(speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=SENSOR_M), body_radius_m=BODY_M)
    return Mission(
        name="coverage",
        area=MultiPolygon([box(0, 0, *size_m)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([box(*corners)])) for corners in obstacles_m),
        fleet=Fleet(
            speed_m_s=SPEED_M_S,
            sensor=like.sensor,
            body_radius_m=BODY_M,
            robots=tuple(like.equal_robot(f"robot-{k + 1}") for k in range(robots)),
            start=start,
        ),
        planning=SwarmSettings(most_steps=most_steps),
    )


def outcome(asked: Mission, seed: int) -> Outcome:
    """Run a mission and measure every step; bodies are as wide as the mission says."""
    run = run_mission(asked, seed=seed, observed=True)
    assert run.history is not None
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    covered = covered_share(places, np.full(len(places), SENSOR_M), free_ground(asked))
    wider_m = run.state.thinned_m  # bodies are kept so much wider
    between_m = float(run.history.body_gap_m.min()) + 2 * wider_m
    beside_m = float(run.history.wall_gap_m.min()) + wider_m
    return Outcome(covered, run.steps, run.at_rest, between_m, beside_m, run.history.coverage)

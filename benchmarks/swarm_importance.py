"""How much importance swarms cover, beside CoverageControl's controller on its own maps, from the same starts."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from dataclasses import replace
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, box

from benchmarks.peer_environment import peer_answer
from benchmarks.row import Options, Row
from rota.model.mission import DiscSensor, Fleet, ImportanceMap, Mission
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import Controller, SwarmSettings

Floats = NDArray[np.float64]

REQUIREMENT, PROGRAM = "coverage_control", "peer_voronoi.py"
SEEDS = range(100, 112)  # none of which anything was tuned on
# a quarter of the package's default world of 1,024 m with 32 robots and 32 features: as many to a square metre
SIDE_M, ROBOTS, FEATURES = 512, 8, 8
SPREADS_M, PEAKS = (40.0, 50.0), (6.0, 10.0)  # the package's defaults, and so are the sensor, the speed and the step
SENSOR_M, SPEED_M_S, TIME_STEP_S, MOST_STEPS = 64, 5.0, 1.0, 2000
WITH_MANY, LEAST_SHARE, AS_MUCH = 24, 0.05, 1e-3
NOT_ASKED = ""


class Ends(NamedTuple):
    """What robots come to: the share of importance in range, the package's cost, and after how many steps.

    rests: whether the run ended by itself.
    """

    covered: float
    cost: float
    steps: int
    rests: bool


def swarm_importance(options: Options) -> Iterator[Row]:
    """Few robots and many on Gaussian maps, and few where all ground is worth as much.

    CoverageControl (GPL-3.0, never a dependency) runs its controller that knows the whole map, as Rota's robots do,
    with its default features, square sensor of 64 m, speed and step; Rota's have the discs of 32 m within these
    squares, the same map and the same starts. Its robots spread to be near all that matters, whether in range or not:
    its cost is importance times the squared distance to the nearest robot. p: sign test.
    """
    for robots, features in ((ROBOTS, FEATURES), (WITH_MANY, FEATURES), (ROBOTS, 0)):
        what = f"{features} Gaussians" if features else "all ground worth as much"
        name = f"swarm, {robots} robots in {SIDE_M} m x {SIDE_M} m, {what}, seeds {SEEDS[0]} to {SEEDS[-1]}"
        runs: dict[str, list[Ends]] = {"settle": [], "voronoi": [], "peer": []}
        for seed in SEEDS:
            problem = problem_of(options, robots, features, seed)
            answer = peer_answer(options.folder, REQUIREMENT, PROGRAM, problem)
            if isinstance(answer, str):
                yield Row(f"{name}, beside CoverageControl", "more covered", f"not measured: {answer}", None)
                return
            field = np.load(problem["map_file"]).astype(np.float64)  # (x, y)
            runs["peer"].append(ends_of(np.array(answer["ends"]), field, answer["steps"], answer["converged"]))
            for controller in ("settle", "voronoi"):
                runs[controller].append(ours(problem, field, controller, seed))
        yield from rows_of(name, answer["version"], runs)


def rows_of(name: str, version: str, runs: dict[str, list[Ends]]) -> Iterator[Row]:
    """What was covered, and the peer's own cost, of ours beside the peer's; of that cost nothing is asked."""
    peer, peers = f"CoverageControl {version} (ClairvoyantCVT)", runs["peer"]
    for controller in ("settle", "voronoi"):
        found = runs[controller]
        rest, steps = sum(run.rests for run in found), statistics.mean(run.steps for run in found)
        more = [own.covered - other.covered for own, other in zip(found, peers, strict=True)]
        if max(map(abs, more)) < AS_MUCH:
            asked, reached, how = "as much", True, f"never apart by more than {max(map(abs, more)):.2%}"
        else:
            asked, reached, how = "more", statistics.mean(more) > 0 and is_clear(more), told(more)
        yield Row(
            f"{name}: importance in range, {controller} beside {peer}",
            asked if controller == "settle" else NOT_ASKED,
            f"{statistics.mean(run.covered for run in found):.1%}, CoverageControl"
            f" {statistics.mean(run.covered for run in peers):.1%}; {how}; {rest} of {len(found)} at rest, after"
            f" {steps:,.0f} steps, CoverageControl {statistics.mean(run.steps for run in peers):,.0f}",
            reached if controller == "settle" else None,
        )
        ratios = [own.cost / other.cost for own, other in zip(found, peers, strict=True)]
        yield Row(
            f"{name}: CoverageControl's own cost, {controller} beside it",
            NOT_ASKED,
            f"{statistics.mean(ratios):.2f} times as much; {told([1 - ratio for ratio in ratios])}",
            None,
        )


def told(better: list[float]) -> str:
    """Of how many pairs ours is the better one, and how likely so many or few are by chance."""
    wins = sum(value > 0 for value in better)
    return f"better in {wins} of {len(better)}, p {by_chance(better):.2g}"


def by_chance(better: list[float]) -> float:
    """The two-sided sign test."""
    n, wins = len(better), sum(value > 0 for value in better)
    return min(1.0, 2 * sum(comb(n, k) for k in range(min(wins, n - wins) + 1)) / 2**n)


def is_clear(better: list[float]) -> bool:
    """Whether chance is unlikely."""
    return by_chance(better) < LEAST_SHARE


def problem_of(options: Options, robots: int, features: int, seed: int) -> dict[str, Any]:
    """What both are given."""
    rng = np.random.default_rng(seed)
    gaussians = np.column_stack(
        [rng.uniform(0, SIDE_M, (features, 2)), rng.uniform(*SPREADS_M, features), rng.uniform(*PEAKS, features)]
    )
    return {
        "side_m": SIDE_M,
        "sensor_m": SENSOR_M,
        "speed_m_s": SPEED_M_S,
        "time_step_s": TIME_STEP_S,
        "features": gaussians.tolist(),
        "starts": rng.uniform(1, SIDE_M - 1, (robots, 2)).tolist(),
        "most_steps": MOST_STEPS,
        "map_file": str(options.folder / "peer-voronoi-map.npy"),
    }


def ours(problem: dict[str, Any], field: Floats, controller: Controller, seed: int) -> Ends:
    """Robots of Rota with discs within the peer's square sensors, from the same starts on the same map."""
    like = Fleet(speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=SENSOR_M / 2))
    robots = tuple(
        replace(like.equal_robot(f"robot-{k + 1}"), start=(x, y)) for k, (x, y) in enumerate(problem["starts"])
    )
    asked = Mission(
        name="importance",
        area=MultiPolygon([box(0, 0, SIDE_M, SIDE_M)]),
        fleet=replace(like, robots=robots),
        importance=ImportanceMap(values=field.T, low_m=(0.5, 0.5), step_m=(1, 1)),
        planning=SwarmSettings(controller=controller, time_step_s=TIME_STEP_S, most_steps=MOST_STEPS),
    )
    run = run_mission(asked, seed=seed)
    ends = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    return ends_of(ends, field, run.steps, run.at_rest)


def ends_of(places_m: Floats, field: Floats, steps: int, rests: bool) -> Ends:
    """What robots at places (n, 2) come to on a field of importance (x, y), a value for each square metre.

    The cost is the package's: importance times the squared distance to the nearest robot, summed.
    """
    x, y = np.meshgrid(np.arange(SIDE_M) + 0.5, np.arange(SIDE_M) + 0.5, indexing="ij")
    nearest2 = np.min([(x - px) ** 2 + (y - py) ** 2 for px, py in places_m], axis=0)
    return Ends(
        covered=float(field[nearest2 <= (SENSOR_M / 2) ** 2].sum() / field.sum()),
        cost=float((field * nearest2).sum()),
        steps=steps,
        rests=rests,
    )

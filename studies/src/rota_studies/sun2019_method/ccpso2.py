"""The improved CCPSO2 of Sun et al. 2019 (Section 2.1, Algorithm 1): sensors that cover a zone's cells."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota_studies.sun2019_method import swarm_kernels, update_kernels
from rota_studies.sun2019_method.mission_settings import SensorSettings
from rota_studies.sun2019_method.rule_kernels import MovementLaw, Terrain
from rota_studies.sun2019_method.swarm_kernels import DEPLOYED, At, Particles, Swarms
from rota_studies.sun2019_method.update_kernels import Iteration, Rules, Scratch, VelocityLaw
from rota_studies.sun2019_stages import sight_kernels
from rota_studies.sun2019_stages.zones import CoverTask

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Evolution:
    """What came of a run, and what the context vector was like on the way, first before any iteration.

    positions_m: (k, 2) the sensors deployed in free ground. counts: (iterations + 1, 4) sensors in obstacles, cells
    uncovered, sensors deployed, cells overlapped; cost: (iterations + 1,) their fitness (Eq. 11).
    """

    positions_m: Floats
    counts: Ints
    cost: Floats


def fitness(
    in_obstacles: int, uncovered: int, sensors: int, overlapped: int, weights: tuple[float, float, float, float]
) -> float:
    """Eq. 11: what a deployment costs; weights are lambda 1 to 4."""
    counts = np.array([in_obstacles, uncovered, sensors, overlapped], dtype=np.int64)
    return float(swarm_kernels.fitness(counts, np.array(weights, dtype=np.float64)))


def evolve(
    task: CoverTask, settings: SensorSettings, *, sensors: int, seed: np.random.SeedSequence, threads: int | None = None
) -> Evolution:
    """Cover the task's cells with at most ``sensors`` sensors, as few as the swarms find; some cells may stay bare.

    threads: they share the particles out; None for one a core. The outcome is the same for any number of threads: each
    particle has its own random numbers and reads only what no other particle writes meanwhile.
    """
    rng = np.random.default_rng(seed)
    terrain = Terrain(np.array(task.box_m), task.cells.table, task.ground)
    box = terrain.box
    scratch = [_scratch(task) for _ in range(_threads(threads, settings.particles))]
    swarms = _first_swarms(task, settings, sensors, rng)
    states = rng.integers(1, 2**63, size=(settings.particles, 1), dtype=np.uint64)
    counts = np.zeros((settings.iterations + 1, 4), dtype=np.int64)
    cost = np.zeros(settings.iterations + 1)
    with ThreadPoolExecutor(len(scratch)) as pool:

        def share_work(work: Callable[..., None], *arguments: object) -> None:
            cuts = np.linspace(0, settings.particles, len(scratch) + 1).astype(np.int64)
            list(pool.map(lambda begin, end, own: work(begin, end, own, *arguments), cuts[:-1], cuts[1:], scratch))

        share_work(update_kernels.see_all, swarms.now, terrain)
        swarm_kernels.begin(swarms)
        cost[0], counts[0] = swarm_kernels.fitness(swarms.counts, swarms.weights), swarms.counts
        for t in range(settings.iterations):
            if t == 0 or not cost[t] < cost[t - 1]:
                swarms = _regroup(swarms, settings, box, rng, first=t == 0)
            cost[t + 1] = swarm_kernels.judge(swarms)
            counts[t + 1] = swarms.counts
            if t + 1 == settings.iterations:
                break
            iteration = Iteration(swarms, _rules(task, settings, t), terrain, neighbourhood(t, settings))
            share_work(update_kernels.update, iteration, states)
    return Evolution(positions_m=_deployed_m(swarms.context, box), counts=counts, cost=cost)


def inertia_at(iteration: int, settings: SensorSettings) -> float:
    """Omega(t) of Eq. 2: from A_MAX in iteration 0 evenly down to A_MIN in the last one."""
    share = iteration / max(1, settings.iterations - 1)
    return settings.inertia_max - (settings.inertia_max - settings.inertia_min) * share


def neighbourhood(iteration: int, settings: SensorSettings) -> int:
    """M of Eq. 4, "increases with the number of iterations": from 1 evenly up to half the ring, which is all of it."""
    share = iteration / max(1, settings.iterations - 1)
    return 1 + round(share * max(0, settings.particles // 2 - 1))


def group_starts(sensors: int, size: int) -> Ints:
    """Where each swarm begins among the sensors, and the end: K = n / s swarms of s sensors, the last of the rest."""
    return np.append(np.arange(0, sensors, size), sensors).astype(np.int64)


def _regroup(swarms: Swarms, settings: SensorSettings, box: Floats, rng: np.random.Generator, first: bool) -> Swarms:
    """The same particles in other swarms: at first as many as asked for, later of a size drawn from the set."""
    n = len(swarms.order)
    size = -(-n // settings.swarms) if first else int(rng.choice(settings.group_sizes))
    order = rng.permutation(n)
    if settings.grouping == "near":
        order = swarm_kernels.near_groups(swarms.context.place[0], box, order, size)
    starts = group_starts(n, size)
    count = len(starts) - 1
    return swarms._replace(
        order=order, group_start=starts, best_fitness=np.zeros((settings.particles, count)),
        bare_start=np.zeros(count + 1, dtype=np.int64),
    )  # fmt: skip


def _first_swarms(task: CoverTask, settings: SensorSettings, sensors: int, rng: np.random.Generator) -> Swarms:
    """Particles at random all over the box, half of their sensors deployed."""
    cells = len(task.cells)
    most = sight_kernels.most_in_reach(task.cells.table, task.ground.reach_m)
    now, best, context = (_particles(count, sensors, most) for count in (settings.particles, settings.particles, 1))
    now.place[:] = rng.random(now.place.shape)
    return Swarms(
        now=now, best=best, context=context, velocity=np.zeros(now.place.shape),
        order=np.arange(sensors, dtype=np.int64), group_start=np.array([0, sensors], dtype=np.int64),
        best_fitness=np.zeros((settings.particles, 1)), times=np.zeros(cells, dtype=np.int32),
        counts=np.zeros(4, dtype=np.int64), weights=np.array(settings.weights, dtype=np.float64),
        bare_start=np.zeros(2, dtype=np.int64), bare_item=np.zeros(2 * cells, dtype=np.int64),
    )  # fmt: skip


def _particles(count: int, sensors: int, most: int) -> Particles:
    """Room for ``count`` particles of ``sensors`` sensors, each of which sees at most ``most`` cells."""
    shape = (count, sensors)
    return Particles(
        place=np.zeros((*shape, 3)), seen=np.zeros((*shape, most), dtype=np.int32),
        seen_n=np.zeros(shape, dtype=np.int64), off=np.zeros(shape, dtype=np.int64),
    )  # fmt: skip


def _rules(task: CoverTask, settings: SensorSettings, iteration: int) -> Rules:
    """The settings as the kernels read them in an iteration, which the inertia depends on."""
    reach_m = task.ground.reach_m
    half_diagonal_m = task.cells.lattice.cell_m / np.sqrt(2)
    return Rules(
        rule_probability=float(settings.rule_probability if settings.has_rules else 0.0),
        velocity_probability=float(settings.velocity_probability),
        cauchy_probability=float(settings.cauchy_probability),
        velocity=VelocityLaw(
            inertia=inertia_at(iteration, settings), c1=float(settings.c1), c2=float(settings.c2),
            least=float(settings.velocity_min), most=float(settings.velocity_max),
        ),
        addition=int(settings.addition), movement=int(settings.movement),
        deletion=int(settings.deletion), fusion=int(settings.fusion),
        delete_m=reach_m / 2, fuse_m=settings.fusion_share * reach_m, near_m=settings.addition_share * reach_m,
        move=MovementLaw(
            around_m=settings.movement_around * reach_m, step_m=settings.movement_share * reach_m,
            in_range_m=float(max(0.0, reach_m - half_diagonal_m)),
        ),
        repeats=int(settings.movement_repeats),
        from_best=float(settings.rules_from_best),
    )  # fmt: skip


def _scratch(task: CoverTask) -> Scratch:
    """What one thread writes on while it moves the particles of a task."""
    return Scratch(
        known=np.zeros(1 + len(task.cells.table.corners), dtype=np.int64),
        marks=np.zeros(1 + len(task.cells), dtype=np.int64),
        missing=np.zeros(len(task.cells), dtype=np.int64),
    )


def _threads(threads: int | None, particles: int) -> int:
    """How many threads share the particles out: as many as asked for, or one a core, but one particle each at least."""
    return max(1, min(particles, threads or os.cpu_count() or 1))


def _deployed_m(context: Particles, box: Floats) -> Floats:
    """Where the context's deployed sensors are, (k, 2) metres; those in obstacles see nothing and are left out."""
    keep = (context.place[0, :, At.FLAG] >= DEPLOYED) & (context.off[0] == 0)
    return np.asarray(box[:2] + context.place[0, keep, : At.FLAG] * box[2:])

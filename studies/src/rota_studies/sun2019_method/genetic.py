"""The modified genetic algorithm for the frame (Sun et al. 2019, Sections 2.2 and 4.3, Algorithm 2).

Readings. Algorithm 2 makes four individuals of the fittest one. We read it as done in each of K groups of four: were
all 4 K made of a single one, nothing but four different tours would be left of any population. When the groups are
formed anew is not said; were it in each generation, one tour would take the whole population over in five (ours then
ended 7 % longer than the shortest known, on 96 sensors). Each operator draws positions of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota_studies.sun2019_method.genetic_kernels import Population, evolve

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def genetic_tour(
    distance: Floats, *, generations: int, population: int, regroup_every: int, reversal_tries: int, seed: int
) -> tuple[Ints, Floats]:
    """The shortest closed tour of all generations: its order (n,), and the shortest length until each, (generations,).

    distance: (n, n) symmetric, Eq. 14. generations: 1 or more. population: individuals, a multiple of 4 (the paper's 4
    K). regroup_every: generations, 1 or more. reversal_tries: at most so many stretches, 1 or more, are drawn until the
    reversal of one makes the tour fitter. The fitness is one over the length (Eq. 18). Up to 3 waypoints have a single
    tour.
    """
    counts = {"generations": generations, "regroup_every": regroup_every, "reversal_tries": reversal_tries}
    for name, value in counts.items():
        if value < 1:
            raise ValueError(f"{name}: {value!r} is not allowed; must be 1 or more")
    if population < 4 or population % 4:
        raise ValueError(f"population: {population!r} is not allowed; must be a multiple of 4")
    distance = np.ascontiguousarray(distance, dtype=np.float64)
    n = len(distance)
    if not np.isfinite(distance).all():
        raise ValueError("distance: every waypoint must be reachable from every other; it holds inf or nan")
    rng = np.random.default_rng(seed)
    best = np.arange(n, dtype=np.int32)
    if n <= 3:
        return best.astype(np.int64), np.full(generations, distance[best, np.roll(best, -1)].sum())
    tours = rng.permuted(np.tile(best, (population, 1)), axis=1)
    individuals = Population(tours, np.empty(population), np.empty(population, np.int64))
    best[:] = tours[0]
    history = np.empty(generations)
    lot = rng.integers(1, 2**64, 1, dtype=np.uint64)
    evolve(distance, regroup_every, reversal_tries, individuals, best, history, lot)
    return best.astype(np.int64), history

# mypy: disable-error-code="no-any-return"
"""Compiled modified genetic algorithm of Sun et al. 2019, Algorithm 2: its three operators, and the generations."""

from __future__ import annotations

from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.random_kernels import uniform


class Population(NamedTuple):
    """4 K individuals, in groups of four.

    tours: (4 K, n) int32 waypoints of each individual in its order. length_m: (4 K,) of each closed tour; written by
    ``evolve``. drawn: (4 K,) int64 individuals by group, four in a row of each; written by ``evolve``.
    """

    tours: Any
    length_m: Any
    drawn: Any


@allocation_free
def swap(genes: Any, z1: int, z2: int) -> None:
    """Mutation (Figure 1a): exchange the genes at two positions, which count from 0 here and below."""
    genes[z1], genes[z2] = genes[z2], genes[z1]


@allocation_free
def reverse(genes: Any, z1: int, z2: int) -> None:
    """Reversal (Figure 1b): the genes at z1..z2 in reverse order."""
    while z1 < z2:
        genes[z1], genes[z2] = genes[z2], genes[z1]
        z1 += 1
        z2 -= 1


@allocation_free
def slide(genes: Any, z1: int, z2: int) -> None:
    """Slide (Figure 1c): the genes at z1..z2 one position to the left, the first of them last."""
    first = genes[z1]
    for z in range(z1, z2):
        genes[z] = genes[z + 1]
    genes[z2] = first


@allocation_free
def copy_genes(source: Any, target: Any) -> None:
    """Make target (n,) the same as source (n,)."""
    for z in range(source.shape[0]):
        target[z] = source[z]


@allocation_free
def closed_length(genes: Any, distance: Any) -> float:
    """Length of the closed tour: what Eq. 18 is one over."""
    n = genes.shape[0]
    total = distance[genes[n - 1], genes[0]]
    for z in range(1, n):
        total += distance[genes[z - 1], genes[z]]
    return total


@allocation_free
def reversal_gain(genes: Any, z1: int, z2: int, distance: Any) -> float:
    """By how much the reversal of z1..z2 shortens the closed tour."""
    n = genes.shape[0]
    if z2 - z1 + 2 > n:  # the whole tour the other way round
        return 0.0
    before, after = genes[z1 - 1 if z1 > 0 else n - 1], genes[z2 + 1 if z2 + 1 < n else 0]
    had = distance[before, genes[z1]] + distance[genes[z2], after]
    return had - distance[before, genes[z2]] - distance[genes[z1], after]


@allocation_free
def evolve(
    distance: Any, regroup_every: int, tries: int, population: Population, best: Any, history: Any, rng: Any
) -> None:
    """Run generations on the population, one for each place of history.

    distance: (n, n) metres. best: (n,) a tour to begin with; becomes the shortest tour of all generations. history:
    (generations,) metres, its length until each generation. rng: (1,) state of the random numbers.

    Every ``regroup_every`` generations the individuals are put into groups of four by lot. In each generation the
    fittest of a group stays. Copies of it replace the other three: one is mutated, one is reversed where a reversal
    makes it fitter (at most ``tries`` stretches are drawn), one is slid.
    """
    tours, length, drawn = population.tours, population.length_m, population.drawn
    size, n = tours.shape
    shortest = closed_length(best, distance)
    for k in range(size):
        drawn[k] = k
        length[k] = closed_length(tours[k], distance)
        if length[k] < shortest:
            shortest = length[k]
            copy_genes(tours[k], best)
    for generation in range(history.shape[0]):
        if generation % regroup_every == 0:
            for k in range(size - 1, 0, -1):
                m = int((k + 1) * uniform(rng))
                drawn[k], drawn[m] = drawn[m], drawn[k]
        for group in range(0, size, 4):
            for k in range(1, 4):
                if length[drawn[group + k]] < length[drawn[group]]:
                    drawn[group], drawn[group + k] = drawn[group + k], drawn[group]
            fittest = tours[drawn[group]]
            for k in range(1, 4):
                child = tours[drawn[group + k]]
                copy_genes(fittest, child)
                for _ in range(tries if k == 2 else 1):
                    z1, z2 = int(n * uniform(rng)), int(n * uniform(rng))
                    if z1 > z2:
                        z1, z2 = z2, z1
                    if k == 1:
                        swap(child, z1, z2)
                    elif k == 3:
                        slide(child, z1, z2)
                    elif reversal_gain(child, z1, z2, distance) > 0.0:
                        reverse(child, z1, z2)
                        break
                length[drawn[group + k]] = closed_length(child, distance)
                if length[drawn[group + k]] < shortest:
                    shortest = length[drawn[group + k]]
                    copy_genes(child, best)
        history[generation] = shortest

# mypy: disallow-untyped-decorators=False, disallow-untyped-calls=False
# mypy: disable-error-code="arg-type, assignment, no-any-return"
"""Compiled loops of the improved CCPSO2 (Sun et al. 2019, Section 2.1 and Algorithm 1): judging particles.

Sensors have three coordinates: x and y between 0 and 1 across the zone's box, and the validity flag, deployed from 0.5
on. The particles' other half, how they move, is in ``update_kernels.py``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel

DEPLOYED = 0.5  # the least flag of a sensor that counts


class _At(NamedTuple):
    """A sensor's coordinates."""

    X: int = 0
    Y: int = 1
    FLAG: int = 2


At = _At()


class _Counted(NamedTuple):
    """What Eq. 11 counts."""

    IN_OBSTACLES: int = 0
    UNCOVERED: int = 1
    SENSORS: int = 2
    OVERLAPPED: int = 3


Counted = _Counted()


class Particles(NamedTuple):
    """Where the sensors of the particles are, and what each sees.

    place: (p, n, 3); seen: (p, n, most) the cells that each sensor sees, seen_n: (p, n) how many; off: (p, n) 1 for a
    sensor where none may be, which sees nothing. Undeployed sensors see nothing either.
    """

    place: Any
    seen: Any
    seen_n: Any
    off: Any


class Swarms(NamedTuple):
    """Particles now, at their best (P.y) and the best of all (one particle, the context vector), and their grouping.

    order: (n,) sensors, those of swarm j are order[group_start[j] : group_start[j + 1]]; best_fitness: (p, k) of
    P_j.y_i in the context; times: (m,) how many deployed sensors of the context see each cell; counts: (4,) what
    Eq. 11 counts of the context; weights: (4,) lambda. bare_start (k + 1,), bare_item: see ``list_bare``.
    """

    now: Particles
    best: Particles
    context: Particles
    velocity: Any
    order: Any
    group_start: Any
    best_fitness: Any
    times: Any
    counts: Any
    weights: Any
    bare_start: Any
    bare_item: Any


@allocation_free
def fitness(counts: Any, weights: Any) -> float:
    """Eq. 11."""
    return (
        weights[0] * counts[Counted.IN_OBSTACLES]
        + weights[1] * counts[Counted.UNCOVERED]
        + weights[2] * counts[Counted.SENSORS]
        + weights[3] * counts[Counted.OVERLAPPED]
    )


@allocation_free
def count_in(i: int, d: int, particles: Particles, times: Any, counts: Any, step: int) -> None:
    """Add sensor d of particle i to what is counted (step 1), or take it away (step -1)."""
    if particles.place[i, d, At.FLAG] < DEPLOYED:
        return
    counts[Counted.SENSORS] += step
    if particles.off[i, d]:
        counts[Counted.IN_OBSTACLES] += step
        return
    last = 0 if step > 0 else 1  # the count before, at which a cell begins or ceases to be seen
    change = np.int32(step)
    for k in range(particles.seen_n[i, d]):
        cell = particles.seen[i, d, k]
        before = times[cell]
        times[cell] = before + change
        if before == last:
            counts[Counted.UNCOVERED] -= step
        elif before == last + 1:
            counts[Counted.OVERLAPPED] += step


@allocation_free
def count_group(i: int, first: int, last: int, order: Any, particles: Particles, s: Swarms, step: int) -> None:
    """Add the sensors order[first:last] of particle i to the context's counts, or take them away."""
    for k in range(first, last):
        count_in(i, order[k], particles, s.times, s.counts, step)


@allocation_free
def copy_sensor(i: int, source: Particles, j: int, target: Particles, d: int) -> None:
    """Give sensor d of particle j of the target all that the source's particle i has there."""
    target.place[j, d, At.X] = source.place[i, d, At.X]
    target.place[j, d, At.Y] = source.place[i, d, At.Y]
    target.place[j, d, At.FLAG] = source.place[i, d, At.FLAG]
    target.off[j, d] = source.off[i, d]
    target.seen_n[j, d] = source.seen_n[i, d]
    for k in range(source.seen_n[i, d]):
        target.seen[j, d, k] = source.seen[i, d, k]


@allocation_free
def begin(s: Swarms) -> None:
    """Take the best whole particle as the context vector, and every particle as the best it has been."""
    n, m = s.order.shape[0], s.times.shape[0]
    least, chosen = math.inf, 0
    for i in range(-1, s.now.place.shape[0]):
        s.times[:] = 0
        s.counts[:] = 0
        s.counts[Counted.UNCOVERED] = m
        if i >= 0:
            count_group(i, 0, n, s.order, s.now, s, 1)
            value = fitness(s.counts, s.weights)
            if value < least:
                least, chosen = value, i
            for d in range(n):
                copy_sensor(i, s.now, i, s.best, d)
    for d in range(n):
        copy_sensor(chosen, s.now, 0, s.context, d)
    s.times[:] = 0
    s.counts[:] = 0
    s.counts[Counted.UNCOVERED] = m
    count_group(0, 0, n, s.order, s.context, s, 1)


@allocation_free
def judge(s: Swarms) -> float:
    """Update P_j.y_i, the best of each swarm and the context vector (Eqs. 5 and 6), swarm by swarm.

    Returns the fitness of the context vector.
    """
    for j in range(s.group_start.shape[0] - 1):
        first, last = s.group_start[j], s.group_start[j + 1]
        least, chosen = fitness(s.counts, s.weights), -1
        count_group(0, first, last, s.order, s.context, s, -1)
        for i in range(s.now.place.shape[0]):
            count_group(i, first, last, s.order, s.now, s, 1)
            now = fitness(s.counts, s.weights)
            count_group(i, first, last, s.order, s.now, s, -1)
            count_group(i, first, last, s.order, s.best, s, 1)
            best = fitness(s.counts, s.weights)
            count_group(i, first, last, s.order, s.best, s, -1)
            if now < best:
                for k in range(first, last):
                    copy_sensor(i, s.now, i, s.best, s.order[k])
                best = now
            s.best_fitness[i, j] = best
            if best < least:
                least, chosen = best, i
        if chosen >= 0:
            for k in range(first, last):
                copy_sensor(chosen, s.best, 0, s.context, s.order[k])
        count_group(0, first, last, s.order, s.context, s, 1)
    list_bare(s)
    return fitness(s.counts, s.weights)


@allocation_free
def list_bare(s: Swarms) -> None:
    """List the cells that the context leaves unseen, up to bare_start[0], then for each swarm the cells only it sees.

    Twice as many entries as there are cells are enough: no cell is seen by one swarm alone and by another one, too.
    """
    listed = 0
    for cell in range(s.times.shape[0]):
        if s.times[cell] == 0:
            s.bare_item[listed] = cell
            listed += 1
    seen, seen_n = s.context.seen, s.context.seen_n
    for j in range(s.group_start.shape[0] - 1):
        s.bare_start[j] = listed
        for step in (-1, 1):
            change = np.int32(step)
            for k in range(s.group_start[j], s.group_start[j + 1]):
                d = s.order[k]
                for n in range(seen_n[0, d]):
                    cell = seen[0, d, n]
                    s.times[cell] += change
                    if step < 0 and s.times[cell] == 0:
                        s.bare_item[listed] = cell
                        listed += 1
        s.bare_start[j + 1] = listed


@allocation_free
def best_neighbour(i: int, j: int, reach: int, best_fitness: Any) -> int:
    """Eq. 4: the particle with the least fitness of P_j.y among i and ``reach`` neighbours on either side.

    best_fitness: (p, k) by particle and swarm.
    """
    count = best_fitness.shape[0]
    chosen = i
    for step in range(1, min(reach, count // 2) + 1):
        for way in (-step, step):
            other = (i + way) % count
            if best_fitness[other, j] < best_fitness[chosen, j]:
                chosen = other
    return chosen


@kernel
def near_groups(place: Any, box: Any, seeds: Any, size: int) -> Any:
    """Order (n,) of sensors in which each ``size`` in a row are near each other: a seed and the sensors nearest to it.

    place: (n, 3). box: (4,) metres. seeds: (n,) sensors in the order in which they begin groups, unless a group has
    taken them already.
    """
    n = place.shape[0]
    order = np.empty(n, np.int64)
    left = np.ones(n, np.bool_)
    placed = 0
    for seed in seeds:
        if not left[seed]:
            continue
        for member in range(min(size, n - placed)):
            nearest, chosen = math.inf, seed
            for e in range(n):
                if left[e] and member > 0:
                    dx, dy = (
                        (place[e, At.X] - place[seed, At.X]) * box[2],
                        (place[e, At.Y] - place[seed, At.Y]) * box[3],
                    )
                    if dx * dx + dy * dy < nearest:
                        nearest, chosen = dx * dx + dy * dy, e
            order[placed] = chosen
            left[chosen] = False
            placed += 1
    return order

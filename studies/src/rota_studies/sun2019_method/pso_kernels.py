# mypy: disable-error-code="no-any-return"
"""Compiled particle swarms that cut a closed frame into segments (Sun et al. 2019, Section 4.4, Algorithm 3)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.random_kernels import uniform
from rota_studies.sun2019_stages.partition_kernels import Ring, segment_period_s, segment_time_s


class Rules(NamedTuple):
    """Table 4's constants of the update, Eq. 28's weights, and the time margin T_m."""

    iterations: int
    least_velocity: float
    most_velocity: float
    most_inertia: float
    least_inertia: float
    own_pull: float
    swarm_pull: float
    weight_late: float
    weight_segments: float
    weight_early: float
    margin_s: float


class Cuts(NamedTuple):
    """Where the frame can be cut: share (n + 1,) of the way round at which each sensor lies, 0 and 1 at the first.

    nearby: (bins,) the last sensor at or before each of equally many parts of the way round.
    """

    share: Any
    nearby: Any


class Swarm(NamedTuple):
    """Room for one swarm: x, v, y (particles, dimensions), value of y (particles,), best (dimensions,), ends."""

    x: Any
    v: Any
    y: Any
    value: Any
    best: Any
    ends: Any


@allocation_free
def nearest_sensor(theta: float, cuts: Cuts) -> int:
    """The sensor (0..n, where n is the first one again) nearest to this share of the way round."""
    bins = cuts.nearby.shape[0]
    k = cuts.nearby[min(int(theta * bins), bins - 1)]
    while k + 1 < cuts.share.shape[0] - 1 and cuts.share[k + 1] <= theta:
        k += 1
    return k if theta - cuts.share[k] <= cuts.share[k + 1] - theta else k + 1


@allocation_free
def late_s(first: int, count: int, margin_s: float, ring: Ring) -> float:
    """By how much the segment's time and the margin exceed its period; negative where they do not."""
    return segment_time_s(first, count, ring) + margin_s - segment_period_s(first, count, ring)


@allocation_free
def cost_of(seconds_late: float, rules: Rules) -> float:
    """What one segment adds to Eq. 28; seconds_late: T_a - T_c + T_m, negative for T_err."""
    late, early = max(0.0, seconds_late), max(0.0, -seconds_late)
    return rules.weight_late * late + rules.weight_segments + rules.weight_early * early


@allocation_free
def end_sensors(position: Any, dimensions: int, cuts: Cuts, ends: Any) -> int:
    """Fill ends with the last sensors of the segments in the order of the frame; returns how many segments there are.

    position: (dimensions,) shares of the way round, in any order; the last segment ends at 1. Ends that fall on the
    same sensor are one.
    """
    n = cuts.share.shape[0] - 1
    count = 0
    for d in range(dimensions):
        end = nearest_sensor(position[d], cuts)
        if end == 0 or end == n:
            continue
        at = count
        while at > 0 and ends[at - 1] > end:
            at -= 1
        if at > 0 and ends[at - 1] == end:
            continue
        for k in range(count, at, -1):
            ends[k] = ends[k - 1]
        ends[at] = end
        count += 1
    ends[count] = n
    return count + 1


@allocation_free
def fitness(position: Any, dimensions: int, cuts: Cuts, ring: Ring, rules: Rules, ends: Any) -> float:
    """Eq. 28 of the segments that end at the given shares of the way round; the first begins behind sensor 0."""
    n = cuts.share.shape[0] - 1
    total, before = 0.0, 0
    for k in range(end_sensors(position, dimensions, cuts, ends)):
        first = before + 1 if before + 1 < n else 0
        total += cost_of(late_s(first, ends[k] - before, rules.margin_s, ring), rules)
        before = ends[k]
    return total


@allocation_free
def next_velocity(
    x: float, v: float, y: float, best: float, inertia: float, r1: float, r2: float, rules: Rules
) -> float:
    """Eq. 27: the velocity of one coordinate after the update, within its limits."""
    v = inertia * v + rules.own_pull * r1 * (y - x) + rules.swarm_pull * r2 * (best - x)
    return min(max(v, rules.least_velocity), rules.most_velocity)


@allocation_free
def inertia_at(iteration: int, rules: Rules) -> float:
    """The inertial weight: from the largest in the first iteration (0) evenly down to the smallest in the last."""
    steps = max(1, rules.iterations - 1)
    return rules.most_inertia - (rules.most_inertia - rules.least_inertia) * iteration / steps


@allocation_free
def fly(dimensions: int, cuts: Cuts, ring: Ring, rules: Rules, s: Swarm, history: Any, rng: Any) -> float:
    """Let one swarm fly from a random start to its last iteration; returns the cost of s.best, its best position.

    history: (iterations + 1,) the lowest cost so far, of all swarms that have written there.
    """
    best = math.inf
    for i in range(s.value.shape[0]):
        for d in range(dimensions):
            s.x[i, d] = s.y[i, d] = uniform(rng)
            s.v[i, d] = rules.least_velocity + (rules.most_velocity - rules.least_velocity) * uniform(rng)
        s.value[i] = fitness(s.x[i], dimensions, cuts, ring, rules, s.ends)
        best = keep_best(i, dimensions, best, s)
    history[0] = min(history[0], best)
    for iteration in range(rules.iterations):
        inertia = inertia_at(iteration, rules)
        for i in range(s.value.shape[0]):
            for d in range(dimensions):
                x, r1, r2 = s.x[i, d], uniform(rng), uniform(rng)
                s.v[i, d] = next_velocity(x, s.v[i, d], s.y[i, d], s.best[d], inertia, r1, r2, rules)
                s.x[i, d] = min(max(x + s.v[i, d], 0.0), 1.0)
            value = fitness(s.x[i], dimensions, cuts, ring, rules, s.ends)
            if value < s.value[i]:
                s.value[i] = value
                for d in range(dimensions):
                    s.y[i, d] = s.x[i, d]
        for i in range(s.value.shape[0]):
            best = keep_best(i, dimensions, best, s)
        history[iteration + 1] = min(history[iteration + 1], best)
    return best


@allocation_free
def keep_best(i: int, dimensions: int, best: float, s: Swarm) -> float:
    """Make particle i's best position the swarm's where it is better; returns the cost of the swarm's."""
    if s.value[i] >= best:
        return best
    for d in range(dimensions):
        s.best[d] = s.y[i, d]
    return s.value[i]


@allocation_free
def fly_all(
    dimensions: Any, cuts: Cuts, ring: Ring, rules: Rules, s: Swarm, history: Any, rngs: Any, position: Any
) -> int:  # fmt: skip
    """Let all swarms fly, each with its number of dimensions (swarms,) and its random numbers (swarms, 1).

    position: takes the best swarm's best position. Of equal swarms the first is the best. Returns its number.
    """
    best, winner = math.inf, -1
    for k in range(dimensions.shape[0]):
        value = fly(dimensions[k], cuts, ring, rules, s, history, rngs[k])
        if value < best:
            best, winner = value, k
            for d in range(dimensions[k]):
                position[d] = s.best[d]
    return winner

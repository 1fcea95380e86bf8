# mypy: disallow-untyped-decorators=False, disallow-untyped-calls=False
# mypy: disable-error-code="arg-type, assignment, no-any-return"
"""Compiled loops of the improved CCPSO2 (Sun et al. 2019, Algorithm 1, lines 23 to 47): how particles move."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.random_kernels import uniform
from rota_studies.sun2019_method.rule_kernels import (
    TRIES,
    Group,
    MovementLaw,
    Terrain,
    add_sensor,
    delete_sensor,
    fuse_sensors,
    move_sensor,
)
from rota_studies.sun2019_method.swarm_kernels import (
    DEPLOYED,
    At,
    Particles,
    Swarms,
    best_neighbour,
    copy_sensor,
)
from rota_studies.sun2019_stages.sight_kernels import cells_seen, is_place


class VelocityLaw(NamedTuple):
    """The constants of Eq. 2: inertia Omega(t), pulls c1 and c2, and the limits of a velocity per iteration."""

    inertia: float
    c1: float
    c2: float
    least: float
    most: float


class Rules(NamedTuple):
    """Settings of the update, in metres where they are lengths; flags are 0 or 1."""

    rule_probability: float
    velocity_probability: float
    cauchy_probability: float
    velocity: VelocityLaw
    addition: int
    movement: int
    deletion: int
    fusion: int
    delete_m: float
    fuse_m: float
    near_m: float
    move: MovementLaw
    repeats: int
    from_best: float


class Iteration(NamedTuple):
    """All that one iteration reads; ``reach`` is M of Eq. 4, the neighbours on either side of a particle."""

    swarms: Swarms
    rules: Rules
    terrain: Terrain
    reach: int


class Scratch(NamedTuple):
    """What one thread writes on: see ``cells_seen``; marks (m + 1,) of cells; missing (m,) cells."""

    known: Any
    marks: Any
    missing: Any


@allocation_free
def group_of(j: int, s: Swarms) -> Group:
    """The sensors of swarm j."""
    return Group(s.order, s.group_start[j], s.group_start[j + 1])


@allocation_free
def velocity_now(v: float, x: float, y: float, hat: float, r1: float, r2: float, law: VelocityLaw) -> float:
    """Eq. 2, first line, cut to the law's limits."""
    return min(law.most, max(law.least, law.inertia * v + law.c1 * r1 * (y - x) + law.c2 * r2 * (hat - x)))


@allocation_free
def sample(y: float, near: float, cauchy: bool, draw: float) -> float:
    """Eq. 3: round the particle's best (Cauchy) or the best of its neighbourhood (Gaussian), as wide as they differ."""
    return (y if cauchy else near) + draw * abs(y - near)


@allocation_free
def cauchy_draw(rng: Any) -> float:
    """C(1): a number of the standard Cauchy distribution."""
    return math.tan(math.pi * (uniform(rng) - 0.5))


@allocation_free
def normal_draw(rng: Any) -> float:
    """N(0, 1): a number of the standard normal distribution."""
    return math.sqrt(-2.0 * math.log(1.0 - uniform(rng))) * math.cos(2.0 * math.pi * uniform(rng))


@allocation_free
def see(i: int, d: int, particles: Particles, terrain: Terrain, known: Any) -> None:
    """Find out anew what sensor d of particle i sees; known: see ``cells_seen``."""
    place, box = particles.place, terrain.box
    particles.seen_n[i, d], particles.off[i, d] = 0, 0
    if place[i, d, At.FLAG] < DEPLOYED:
        return
    px, py = box[0] + place[i, d, At.X] * box[2], box[1] + place[i, d, At.Y] * box[3]
    if is_place(px, py, terrain.ground):
        seen = particles.seen[i, d]
        particles.seen_n[i, d] = cells_seen(px, py, terrain.cells, terrain.ground, known, seen)
    else:
        particles.off[i, d] = 1


@allocation_free
def see_all(begin: int, end: int, scratch: Scratch, particles: Particles, terrain: Terrain) -> None:
    """Find out what all sensors of the particles begin..end - 1 see."""
    for i in range(begin, end):
        for d in range(particles.place.shape[1]):
            see(i, d, particles, terrain, scratch.known)


@allocation_free
def list_missing(i: int, j: int, s: Swarms, scratch: Scratch) -> int:
    """List in scratch the cells unseen with particle i of swarm j in the context vector; returns how many there are."""
    marks, missing = scratch.marks, scratch.missing
    marks[0] += 1
    mark = marks[0]
    for k in range(s.group_start[j], s.group_start[j + 1]):
        d = s.order[k]
        for n in range(s.now.seen_n[i, d]):
            marks[1 + s.now.seen[i, d, n]] = mark
    count = 0
    for n in range(s.bare_start[0]):
        if marks[1 + s.bare_item[n]] != mark:
            missing[count] = s.bare_item[n]
            count += 1
    for n in range(s.bare_start[j], s.bare_start[j + 1]):
        if marks[1 + s.bare_item[n]] != mark:
            missing[count] = s.bare_item[n]
            count += 1
    return count


@allocation_free
def cover_missing(i: int, j: int, missing: int, fused: bool, iteration: Iteration, scratch: Scratch, rng: Any) -> None:
    """Let swarm j of particle i see one more of the ``missing`` cells in scratch, drawn by lot.

    Addition (Eq. 7) does it while a sensor of the swarm is undeployed and no two were just ``fused``; else Movement
    (Eq. 8).
    """
    s, rules, terrain = iteration.swarms, iteration.rules, iteration.terrain
    group, p = group_of(j, s), s.now.place[i]
    left = False
    for k in range(group.first, group.last):
        left = left or p[group.order[k], At.FLAG] < DEPLOYED
    adding = left and not fused
    if (adding and not rules.addition) or (not adding and not rules.movement):
        return
    for _ in range(TRIES):
        cell = scratch.missing[int(uniform(rng) * missing)]
        x_m, y_m = terrain.cells.centres[cell, 0], terrain.cells.centres[cell, 1]
        if adding:
            d = add_sensor(p, group, x_m, y_m, rules.near_m, terrain, rng)
        else:
            d = move_sensor(p, group, x_m, y_m, rules.move, terrain.box, rng)
        if d >= 0:
            see(i, d, s.now, terrain, scratch.known)
            return


@allocation_free
def apply_rules(i: int, j: int, iteration: Iteration, scratch: Scratch, rng: Any) -> None:
    """Lines 27 to 35 of Algorithm 1, for swarm j of particle i."""
    s, rules, terrain = iteration.swarms, iteration.rules, iteration.terrain
    group, p = group_of(j, s), s.now.place[i]
    if rules.deletion:
        d = delete_sensor(p, s.context.place[0], group, rules.delete_m, terrain.box)
        if d >= 0:
            see(i, d, s.now, terrain, scratch.known)
    missing = list_missing(i, j, s, scratch)
    if missing > 0:
        cover_missing(i, j, missing, False, iteration, scratch, rng)
    elif rules.fusion:
        both = fuse_sensors(p, group, rules.fuse_m, terrain.box, rng)
        if both >= 0:
            see(i, both // p.shape[0], s.now, terrain, scratch.known)
            see(i, both % p.shape[0], s.now, terrain, scratch.known)
            missing = list_missing(i, j, s, scratch)
            for _ in range(rules.repeats):
                if missing == 0:
                    break
                cover_missing(i, j, missing, True, iteration, scratch, rng)
                missing = list_missing(i, j, s, scratch)


@allocation_free
def follow(i: int, j: int, neighbour: int, by_velocity: bool, iteration: Iteration, scratch: Scratch, rng: Any) -> None:
    """Lines 37 to 43 of Algorithm 1: Eq. 2, with velocities, or Eq. 3, sampling; places stay within the box.

    neighbour: the best particle near particle i, whose best Eq. 3 samples round.
    """
    s, rules = iteration.swarms, iteration.rules
    for k in range(s.group_start[j], s.group_start[j + 1]):
        d = s.order[k]
        moved = False
        for axis in range(3):
            x, y = s.now.place[i, d, axis], s.best.place[i, d, axis]
            if by_velocity:
                v, hat = s.velocity[i, d, axis], s.context.place[0, d, axis]
                v = velocity_now(v, x, y, hat, uniform(rng), uniform(rng), rules.velocity)
                s.velocity[i, d, axis] = v
                x += v
            else:
                cauchy = uniform(rng) < rules.cauchy_probability
                draw = cauchy_draw(rng) if cauchy else normal_draw(rng)
                x = sample(y, s.best.place[neighbour, d, axis], cauchy, draw)
            x = min(1.0, max(0.0, x))
            moved = moved or x != s.now.place[i, d, axis]
            s.now.place[i, d, axis] = x
        if moved:
            see(i, d, s.now, iteration.terrain, scratch.known)


@allocation_free
def update(begin: int, end: int, scratch: Scratch, iteration: Iteration, states: Any) -> None:
    """Move the particles begin..end - 1 of every swarm and find out what they see.

    states: (p, 1) the state of each particle's random numbers. Only what belongs to these particles is written, so that
    threads can share the particles out.
    """
    s, rules = iteration.swarms, iteration.rules
    for i in range(begin, end):
        rng = states[i]
        for j in range(s.group_start.shape[0] - 1):
            neighbour = best_neighbour(i, j, iteration.reach, s.best_fitness)
            if uniform(rng) < rules.rule_probability:
                if uniform(rng) < rules.from_best:
                    for k in range(s.group_start[j], s.group_start[j + 1]):
                        copy_sensor(neighbour, s.best, i, s.now, s.order[k])
                apply_rules(i, j, iteration, scratch, rng)
            else:
                by_velocity = uniform(rng) < rules.velocity_probability
                follow(i, j, neighbour, by_velocity, iteration, scratch, rng)

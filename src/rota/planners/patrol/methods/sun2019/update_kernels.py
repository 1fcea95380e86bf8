# mypy: disallow-untyped-decorators=False, disallow-untyped-calls=False
# mypy: disable-error-code="arg-type, assignment, no-any-return"
"""Compiled loops of the improved CCPSO2 (Sun et al. 2019, Algorithm 1, lines 23 to 47): how particles move."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.ground.sight_kernels import compiled
from rota.planners.patrol.methods.sun2019.sight_kernels import CellTable, Ground, cells_seen, is_place
from rota.planners.patrol.methods.sun2019.swarm_kernels import (
    DEPLOYED,
    FLAG,
    Particles,
    Swarms,
    X,
    Y,
    best_neighbour,
    copy_sensor,
)

TRIES = 8  # at a random place, or a random cell, that suits


class Rules(NamedTuple):
    """Settings of the update, in metres where they are lengths; flags are 0 or 1."""

    rule_probability: float
    velocity_probability: float
    cauchy_probability: float
    velocity_min: float
    velocity_max: float
    c1: float
    c2: float
    addition: int
    movement: int
    deletion: int
    fusion: int
    delete_m: float
    fuse_m: float
    near_m: float
    step_m: float
    around_m: float
    in_range_m: float
    repeats: int
    from_best: float


class Scratch(NamedTuple):
    """What one thread writes on: see ``cells_seen``; marks (m + 1,) of cells; missing (m,) cells."""

    known: Any
    marks: Any
    missing: Any


@compiled
def velocity_now(v: float, x: float, y: float, hat: float, inertia: float, c1: float, c2: float, r1: float, r2: float,
                 low: float, high: float) -> float:  # fmt: skip
    """Eq. 2, first line, cut to low..high."""
    return min(high, max(low, inertia * v + c1 * r1 * (y - x) + c2 * r2 * (hat - x)))


@compiled
def sampled(y: float, near: float, cauchy: bool, draw: float) -> float:
    """Eq. 3: round the particle's best (Cauchy) or the best of its neighbourhood (Gaussian), as wide as they differ."""
    return (y if cauchy else near) + draw * abs(y - near)


@compiled
def cauchy_draw(rng: Any) -> float:
    """C(1): a number of the standard Cauchy distribution."""
    return math.tan(math.pi * (uniform(rng) - 0.5))


@compiled
def normal_draw(rng: Any) -> float:
    """N(0, 1): a number of the standard normal distribution."""
    return math.sqrt(-2.0 * math.log(1.0 - uniform(rng))) * math.cos(2.0 * math.pi * uniform(rng))


@compiled
def apart_m(p: Any, d: int, q: Any, e: int, box: Any) -> float:
    """Distance in metres between sensor d of p (n, 3) and sensor e of q (n, 3)."""
    dx, dy = (p[d, X] - q[e, X]) * box[2], (p[d, Y] - q[e, Y]) * box[3]
    return math.sqrt(dx * dx + dy * dy)


@compiled
def put(p: Any, d: int, x_m: float, y_m: float, box: Any) -> None:
    """Deploy sensor d of p (n, 3) at a place in metres, as far as it lies in the box."""
    p[d, X] = min(1.0, max(0.0, (x_m - box[0]) / box[2]))
    p[d, Y] = min(1.0, max(0.0, (y_m - box[1]) / box[3]))
    p[d, FLAG] = 1.0


@compiled
def see(i: int, d: int, particles: Particles, box: Any, cells: CellTable, ground: Ground, known: Any) -> None:
    """Find out anew what sensor d of particle i sees."""
    place = particles.place
    particles.seen_n[i, d], particles.off[i, d] = 0, 0
    if place[i, d, FLAG] < DEPLOYED:
        return
    px, py = box[0] + place[i, d, X] * box[2], box[1] + place[i, d, Y] * box[3]
    if is_place(px, py, ground):
        particles.seen_n[i, d] = cells_seen(px, py, cells, ground, known, particles.seen[i, d])
    else:
        particles.off[i, d] = 1


@compiled
def see_all(
    begin: int, end: int, scratch: Scratch, particles: Particles, box: Any, cells: CellTable, ground: Ground
) -> None:
    """Find out what all sensors of the particles begin..end see."""
    for i in range(begin, end):
        for d in range(particles.place.shape[1]):
            see(i, d, particles, box, cells, ground, scratch.known)


@compiled
def list_missing(i: int, j: int, s: Swarms, scratch: Scratch) -> int:
    """Cells that nothing sees when particle i of swarm j stands in the context vector; returns how many."""
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


@compiled
def delete_sensor(p: Any, context: Any, first: int, last: int, order: Any, delete_m: float, box: Any) -> int:
    """Eq. 9: withdraw the sensor of order[first:last] nearest to another one of the context, if nearer than r_s.

    Returns the sensor, or -1.
    """
    least, chosen = delete_m, -1
    for k in range(first, last):
        d = order[k]
        if p[d, FLAG] < DEPLOYED:
            continue
        for e in range(context.shape[0]):
            if e != d and context[e, FLAG] >= DEPLOYED:
                far = apart_m(p, d, context, e, box)
                if far < least:
                    least, chosen = far, d
    if chosen >= 0:
        p[chosen, FLAG] = 0.0
    return chosen


@compiled
def fuse_sensors(p: Any, first: int, last: int, order: Any, fuse_m: float, box: Any, rng: Any) -> int:
    """Eq. 10: put a sensor midway between itself and its nearest of order[first:last], if nearer than tau.

    The other one is withdrawn. The first that has such a neighbour, from a random one on. Returns the sensor that moved
    times n plus the one withdrawn, or -1.
    """
    size = last - first
    begin = int(uniform(rng) * size)
    for step in range(size):
        d = order[first + (begin + step) % size]
        if p[d, FLAG] < DEPLOYED:
            continue
        least, chosen = fuse_m, -1
        for k in range(first, last):
            e = order[k]
            if e != d and p[e, FLAG] >= DEPLOYED:
                far = apart_m(p, d, p, e, box)
                if far < least:
                    least, chosen = far, e
        if chosen >= 0:
            p[d, X], p[d, Y] = 0.5 * (p[d, X] + p[chosen, X]), 0.5 * (p[d, Y] + p[chosen, Y])
            p[chosen, FLAG] = 0.0
            return d * p.shape[0] + chosen
    return -1


@compiled
def add_sensor(
    p: Any, first: int, last: int, order: Any, x_m: float, y_m: float, near_m: float, box: Any, ground: Ground, rng: Any
) -> int:
    """Eq. 7: deploy a random sensor of order[first:last] near a cell's centre; returns it, or -1: all are deployed."""
    size = last - first
    begin = int(uniform(rng) * size)
    for step in range(size):
        d = order[first + (begin + step) % size]
        if p[d, FLAG] >= DEPLOYED:
            continue
        for _ in range(TRIES):
            angle, far = 2.0 * math.pi * uniform(rng), near_m * math.sqrt(uniform(rng))
            put(p, d, x_m + far * math.cos(angle), y_m + far * math.sin(angle), box)
            if is_place(box[0] + p[d, X] * box[2], box[1] + p[d, Y] * box[3], ground):
                break
        return d
    return -1


@compiled
def move_sensor(
    p: Any,
    first: int,
    last: int,
    order: Any,
    x_m: float,
    y_m: float,
    around_m: float,
    step_m: float,
    in_range_m: float,
    box: Any,
    rng: Any,
) -> int:
    """Eq. 8: move the nearest sensor of order[first:last] a short way towards a cell's centre.

    Returns it, or -1 when none is deployed within around_m. The way is at most step_m, no more than takes it to within
    in_range_m and a bit, and any if it is so near that something else must hide the cell.
    """
    least, chosen = around_m, -1
    for k in range(first, last):
        d = order[k]
        if p[d, FLAG] >= DEPLOYED:
            dx, dy = x_m - box[0] - p[d, X] * box[2], y_m - box[1] - p[d, Y] * box[3]
            far = math.sqrt(dx * dx + dy * dy)
            if far < least:
                least, chosen = far, d
    if chosen >= 0 and least > 0.0:
        need = least - in_range_m
        way = step_m * uniform(rng) if need <= 0.0 else min(step_m, need * (1.0 + 0.3 * uniform(rng)))
        share = min(1.0, way / least)
        here_x, here_y = box[0] + p[chosen, X] * box[2], box[1] + p[chosen, Y] * box[3]
        put(p, chosen, here_x + share * (x_m - here_x), here_y + share * (y_m - here_y), box)
    return chosen


@compiled
def mend(
    i: int, j: int, missing: int, fused: bool, s: Swarms, rules: Rules, box: Any, cells: CellTable, ground: Ground,
    scratch: Scratch, rng: Any,
) -> None:  # fmt: skip
    """Addition, or Movement when all sensors are deployed or two were just fused, for one of the ``missing`` cells."""
    first, last, p = s.group_start[j], s.group_start[j + 1], s.now.place[i]
    left = False
    for k in range(first, last):
        left = left or p[s.order[k], FLAG] < DEPLOYED
    adding = left and not fused
    if (adding and not rules.addition) or (not adding and not rules.movement):
        return
    for _ in range(TRIES):
        cell = scratch.missing[int(uniform(rng) * missing)]
        x_m, y_m = cells.centres[cell, 0], cells.centres[cell, 1]
        if adding:
            d = add_sensor(p, first, last, s.order, x_m, y_m, rules.near_m, box, ground, rng)
        else:
            d = move_sensor(p, first, last, s.order, x_m, y_m, rules.around_m, rules.step_m, rules.in_range_m, box, rng)
        if d >= 0:
            see(i, d, s.now, box, cells, ground, scratch.known)
            return


@compiled
def apply_rules(
    i: int, j: int, s: Swarms, rules: Rules, box: Any, cells: CellTable, ground: Ground, scratch: Scratch, rng: Any
) -> None:
    """Lines 27 to 35 of Algorithm 1."""
    first, last, p = s.group_start[j], s.group_start[j + 1], s.now.place[i]
    if rules.deletion:
        d = delete_sensor(p, s.context.place[0], first, last, s.order, rules.delete_m, box)
        if d >= 0:
            see(i, d, s.now, box, cells, ground, scratch.known)
    missing = list_missing(i, j, s, scratch)
    if missing > 0:
        mend(i, j, missing, False, s, rules, box, cells, ground, scratch, rng)
    elif rules.fusion:
        both = fuse_sensors(p, first, last, s.order, rules.fuse_m, box, rng)
        if both >= 0:
            see(i, both // p.shape[0], s.now, box, cells, ground, scratch.known)
            see(i, both % p.shape[0], s.now, box, cells, ground, scratch.known)
            missing = list_missing(i, j, s, scratch)
            for _ in range(rules.repeats):
                if missing == 0:
                    break
                mend(i, j, missing, True, s, rules, box, cells, ground, scratch, rng)
                missing = list_missing(i, j, s, scratch)


@compiled
def follow(
    i: int, j: int, neighbour: int, by_velocity: bool, inertia: float, s: Swarms, rules: Rules, box: Any,
    cells: CellTable, ground: Ground, scratch: Scratch, rng: Any,
) -> None:  # fmt: skip
    """Lines 37 to 43 of Algorithm 1: Eq. 2, with velocities, or Eq. 3, sampling; places stay within the box."""
    for k in range(s.group_start[j], s.group_start[j + 1]):
        d = s.order[k]
        moved = False
        for axis in range(3):
            x, y = s.now.place[i, d, axis], s.best.place[i, d, axis]
            if by_velocity:
                s.velocity[i, d, axis] = velocity_now(
                    s.velocity[i, d, axis], x, y, s.context.place[0, d, axis], inertia, rules.c1, rules.c2,
                    uniform(rng), uniform(rng), rules.velocity_min, rules.velocity_max,
                )  # fmt: skip
                x += s.velocity[i, d, axis]
            else:
                cauchy = uniform(rng) < rules.cauchy_probability
                draw = cauchy_draw(rng) if cauchy else normal_draw(rng)
                x = sampled(y, s.best.place[neighbour, d, axis], cauchy, draw)
            x = min(1.0, max(0.0, x))
            moved = moved or x != s.now.place[i, d, axis]
            s.now.place[i, d, axis] = x
        if moved:
            see(i, d, s.now, box, cells, ground, scratch.known)


@compiled
def update(
    begin: int, end: int, scratch: Scratch, reach: int, inertia: float, s: Swarms, rules: Rules, box: Any,
    cells: CellTable, ground: Ground, states: Any,
) -> None:  # fmt: skip
    """Move the particles begin..end of every swarm and find out what they see; states: (p, 1) of their random numbers.

    Nothing but what belongs to these particles is written, so that threads can share the particles out.
    """
    for i in range(begin, end):
        rng = states[i]
        for j in range(s.group_start.shape[0] - 1):
            neighbour = best_neighbour(i, j, reach, s.best_fitness)
            if uniform(rng) < rules.rule_probability:
                if uniform(rng) < rules.from_best:
                    for k in range(s.group_start[j], s.group_start[j + 1]):
                        copy_sensor(neighbour, s.best, i, s.now, s.order[k])
                apply_rules(i, j, s, rules, box, cells, ground, scratch, rng)
            else:
                by_velocity = uniform(rng) < rules.velocity_probability
                follow(i, j, neighbour, by_velocity, inertia, s, rules, box, cells, ground, scratch, rng)

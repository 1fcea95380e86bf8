# mypy: disallow-untyped-decorators=False, disallow-untyped-calls=False
# mypy: disable-error-code="arg-type, assignment, no-any-return"
"""Compiled rules that help the swarms of Sun et al. 2019 (Section 4.2): Addition, Movement, Deletion and Fusion."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.random_kernels import uniform
from rota_studies.sun2019_method.swarm_kernels import DEPLOYED, At
from rota_studies.sun2019_stages.sight_kernels import CellTable, Ground, is_place

TRIES = 8  # at a random place, or a random cell, that suits


class MovementLaw(NamedTuple):
    """The lengths of Eq. 8 in metres.

    around_m: how near a sensor must be to be moved. step_m: the longest way of one move. in_range_m: the distance from
    which on a sensor may see the cell.
    """

    around_m: float
    step_m: float
    in_range_m: float


class Terrain(NamedTuple):
    """Where sensors are deployed and what they may see.

    box: (4,) x, y, width and height in metres; a sensor's coordinates are shares of it.
    """

    box: Any
    cells: CellTable
    ground: Ground


class Group(NamedTuple):
    """The sensors order[first:last] of a swarm; order: (n,) sensors."""

    order: Any
    first: int
    last: int


@allocation_free
def apart_m(p: Any, d: int, q: Any, e: int, box: Any) -> float:
    """Distance in metres between sensor d of p (n, 3) and sensor e of q (n, 3)."""
    dx, dy = (p[d, At.X] - q[e, At.X]) * box[2], (p[d, At.Y] - q[e, At.Y]) * box[3]
    return math.sqrt(dx * dx + dy * dy)


@allocation_free
def put(p: Any, d: int, x_m: float, y_m: float, box: Any) -> None:
    """Deploy sensor d of p (n, 3) at the place (x_m, y_m), or at the nearest place of the box."""
    p[d, At.X] = min(1.0, max(0.0, (x_m - box[0]) / box[2]))
    p[d, At.Y] = min(1.0, max(0.0, (y_m - box[1]) / box[3]))
    p[d, At.FLAG] = 1.0


@allocation_free
def delete_sensor(p: Any, context: Any, group: Group, delete_m: float, box: Any) -> int:
    """Eq. 9: withdraw the group's sensor nearest to another one of the context, if nearer than delete_m.

    p, context: (n, 3) sensors. box: (4,) metres. Returns the sensor, or -1.
    """
    least, chosen = delete_m, -1
    for k in range(group.first, group.last):
        d = group.order[k]
        if p[d, At.FLAG] < DEPLOYED:
            continue
        for e in range(context.shape[0]):
            if e != d and context[e, At.FLAG] >= DEPLOYED:
                far = apart_m(p, d, context, e, box)
                if far < least:
                    least, chosen = far, d
    if chosen >= 0:
        p[chosen, At.FLAG] = 0.0
    return chosen


@allocation_free
def fuse_sensors(p: Any, group: Group, fuse_m: float, box: Any, rng: Any) -> int:
    """Eq. 10: put a sensor midway between itself and its nearest of the group, if nearer than tau (fuse_m).

    The nearest one is withdrawn. The sensor is the first that has such a neighbour, from a random one on. p: (n, 3)
    sensors. box: (4,) metres. Returns the sensor that moved times n plus the one withdrawn, or -1.
    """
    size = group.last - group.first
    begin = int(uniform(rng) * size)
    for step in range(size):
        d = group.order[group.first + (begin + step) % size]
        if p[d, At.FLAG] < DEPLOYED:
            continue
        least, chosen = fuse_m, -1
        for k in range(group.first, group.last):
            e = group.order[k]
            if e != d and p[e, At.FLAG] >= DEPLOYED:
                far = apart_m(p, d, p, e, box)
                if far < least:
                    least, chosen = far, e
        if chosen >= 0:
            p[d, At.X], p[d, At.Y] = (
                0.5 * (p[d, At.X] + p[chosen, At.X]),
                0.5 * (p[d, At.Y] + p[chosen, At.Y]),
            )
            p[chosen, At.FLAG] = 0.0
            return d * p.shape[0] + chosen
    return -1


@allocation_free
def add_sensor(p: Any, group: Group, x_m: float, y_m: float, near_m: float, terrain: Terrain, rng: Any) -> int:
    """Eq. 7: deploy a random sensor of the group within near_m of a cell's centre (x_m, y_m).

    p: (n, 3) sensors. Returns the sensor, or -1 when all are deployed.
    """
    size, box = group.last - group.first, terrain.box
    begin = int(uniform(rng) * size)
    for step in range(size):
        d = group.order[group.first + (begin + step) % size]
        if p[d, At.FLAG] >= DEPLOYED:
            continue
        for _ in range(TRIES):
            angle, far = 2.0 * math.pi * uniform(rng), near_m * math.sqrt(uniform(rng))
            put(p, d, x_m + far * math.cos(angle), y_m + far * math.sin(angle), box)
            if is_place(box[0] + p[d, At.X] * box[2], box[1] + p[d, At.Y] * box[3], terrain.ground):
                break
        return d
    return -1


@allocation_free
def move_sensor(p: Any, group: Group, x_m: float, y_m: float, law: MovementLaw, box: Any, rng: Any) -> int:
    """Eq. 8: move the group's nearest sensor a short way towards a cell's centre (x_m, y_m).

    The way is at most step_m. A sensor farther than in_range_m goes as far as it takes to be within, and up to 30 %
    farther. For a nearer sensor something else must hide the cell, so that the way is any length. p: (n, 3) sensors.
    box: (4,) metres. Returns the sensor, or -1 when none is deployed within around_m.
    """
    least, chosen = law.around_m, -1
    for k in range(group.first, group.last):
        d = group.order[k]
        if p[d, At.FLAG] >= DEPLOYED:
            dx, dy = x_m - box[0] - p[d, At.X] * box[2], y_m - box[1] - p[d, At.Y] * box[3]
            far = math.sqrt(dx * dx + dy * dy)
            if far < least:
                least, chosen = far, d
    if chosen >= 0 and least > 0.0:
        need = least - law.in_range_m
        way = law.step_m * uniform(rng) if need <= 0.0 else min(law.step_m, need * (1.0 + 0.3 * uniform(rng)))
        share = min(1.0, way / least)
        from_x, from_y = box[0] + p[chosen, At.X] * box[2], box[1] + p[chosen, At.Y] * box[3]
        put(p, chosen, from_x + share * (x_m - from_x), from_y + share * (y_m - from_y), box)
    return chosen

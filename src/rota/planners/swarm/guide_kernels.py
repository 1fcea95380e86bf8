# mypy: disable-error-code="no-any-return"
"""Compiled steering of robots that a swarm sends somewhere, and of all others clear of chargers."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.kernels import cell_of

AHEAD = 0.3  # cosine of the direction from which on a body is in the way
SIDESTEP_WITHIN = 1.8  # of two bodies' radii, and a step of each: so near they are passed, each on its right


@allocation_free
def sidestep(i: int, ux: float, uy: float, snapshot: Any) -> tuple[float, float]:
    """The direction (ux, uy) of robot i, turned to the right of what bodies are ahead and near.

    Two that come head-on pass each other so; the filter alone would let them stand face to face.
    """
    robots, kinds, grid, time_step_s = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule.time_step_s
    kind, x, y, most = robots.kind[i], robots.x[i], robots.y[i], 0.0
    stride, body, speed = grid.columns + 2, kinds.body_m[robots.kind[i]], kinds.speed_m_s[kind]
    below = cell_of(x, y, grid) - stride
    for row in range(3):
        c = below + row * stride
        for j in range(grid.start[c - 1], grid.start[c + 2]):
            other = kinds.body_m[robots.kind[j]]
            if j == i or other < 0.0:
                continue
            dx, dy = robots.x[j] - x, robots.y[j] - y
            distance = math.sqrt(dx * dx + dy * dy)
            bodies = body + other
            within = SIDESTEP_WITHIN * bodies + (speed + kinds.speed_m_s[robots.kind[j]]) * time_step_s
            if 0.0 < distance < within and ux * dx + uy * dy > AHEAD * distance:
                most = max(most, min((within - distance) / (within - bodies), 1.0))
    return ux + most * uy, uy - most * ux


@allocation_free
def clear_of_pads(
    x: float, y: float, vx: float, vy: float, speed: float, name: int, time_step_s: float, guide: Any
) -> tuple[float, float]:
    """The velocity (vx, vy) of a robot at (x, y) without what leads into the disc round a charger; out of it for one

    within. Robots that are sent elsewhere go round it.
    """
    own, tx, ty = guide.may_enter[name], guide.targets_m[name, 0], guide.targets_m[name, 1]
    for q in range(guide.pads_m.shape[0]):
        if q == own:
            continue
        dx, dy = guide.pads_m[q, 0] - x, guide.pads_m[q, 1] - y
        distance = math.sqrt(dx * dx + dy * dy)
        bound = max((distance - guide.keep_m) / time_step_s, -speed)
        if bound >= speed:
            continue
        ex, ey = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
        along = vx * ex + vy * ey
        if along > bound:
            vx, vy = vx + (bound - along) * ex, vy + (bound - along) * ey
            aim2 = (tx - guide.pads_m[q, 0]) ** 2 + (ty - guide.pads_m[q, 1]) ** 2
            if aim2 > guide.keep_m * guide.keep_m:  # never of nan
                side = 1.0 if vx * ey - vy * ex >= 0.0 else -1.0
                rest = side * math.sqrt(max(speed * speed - bound * bound, 0.0))
                vx, vy = bound * ex + rest * ey, bound * ey - rest * ex
    length = math.sqrt(vx * vx + vy * vy)
    return (vx * speed / length, vy * speed / length) if length > speed else (vx, vy)


@allocation_free
def steer(begin: int, end: int, snapshot: Any, guide: Any, decisions: Any) -> None:
    """Replace what robots begin..end - 1 of a ``Snapshot`` have decided by what the guide asks of them.

    guide: targets_m (n, 2) by number in the fleet, nan: the robot goes as it has decided; may_enter (n,) the charger
    that each may come to, or -1; pads_m (m, 2) the chargers, which all others keep off by keep_m.
    """
    robots, kinds, time_step_s = snapshot.robots, snapshot.kinds, snapshot.rule.time_step_s
    for i in range(begin, end):
        name, speed = robots.name[i], kinds.speed_m_s[robots.kind[i]]
        if speed <= 0.0:
            continue
        x, y, vx, vy = robots.x[i], robots.y[i], decisions.vx[i], decisions.vy[i]
        dx, dy = guide.targets_m[name, 0] - x, guide.targets_m[name, 1] - y
        if not math.isnan(dx):
            distance, step_m = math.sqrt(dx * dx + dy * dy), speed * time_step_s
            if distance <= step_m:
                vx, vy = dx / time_step_s, dy / time_step_s
            else:
                ux, uy = sidestep(i, dx / distance, dy / distance, snapshot)
                length = math.sqrt(ux * ux + uy * uy)
                vx, vy = speed * ux / length, speed * uy / length
        vx, vy = clear_of_pads(x, y, vx, vy, speed, name, time_step_s, guide)
        decisions.vx[i], decisions.vy[i] = vx, vy

"""Compiled decision of the controller that comes to rest: overlaps push as springs do, and motion goes on a while."""

from __future__ import annotations

import math
from typing import Any

from rota.planners.swarm.baseline_kernels import MANY_CAUSES, sum_of_overlaps, towards
from rota.planners.swarm.kernels import compiled

STIFFNESS = 0.3  # share of each overlap that a robot takes away in a step; measured: with more, swarms tremble
MOMENTUM = 0.92  # share of the last step that is made again
# friction, as shares of the sensor's radius in a step; measured: swarms rest in half the steps and cover as much
KINETIC, STATIC = 2e-5, 1e-4
SLOW = 4e-4  # below this step friction grows, up to the static one


@compiled
def rubbed(dx: float, dy: float, last_m: float, sensor_m: float) -> tuple[float, float]:
    """What friction leaves of a step (dx, dy) after one of ``last_m``: nothing of a step that is shorter than it."""
    slowness = max(0.0, 1.0 - last_m / (SLOW * sensor_m))
    friction_m = sensor_m * (KINETIC + (STATIC - KINETIC) * slowness)
    length = math.sqrt(dx * dx + dy * dy)
    left = 1.0 - friction_m / length if length > friction_m else 0.0
    return left * dx, left * dy


@compiled
def decide_settle(
    begin: int, end: int, step: int, robots: Any, kinds: Any, grid: Any, moving: Any, rule: Any,
    new_vx: Any, new_vy: Any, nearest2: Any, near: Any, outline: Any, spare: Any,
) -> None:  # fmt: skip
    """Virtual forces with momentum (Polyak's heavy ball): a step is a share of the overlaps and of the step before.

    The overlap of two discs is a potential that every robot sees of its own and that is flat where nothing overlaps,
    hence rest; momentum takes the slow, long waves through a swarm that forces alone need thousands of steps for, and
    carries it past the poorer arrangements in which they get stuck.

    Rows of discs that overlap by millimetres buckle so slowly that they would move for thousands of steps, for no
    ground worth it; dry friction, greater the slower a robot is, lets such rows stand and ends each motion in finite
    time.
    """
    for i in range(begin, end):
        fx, fy, causes = sum_of_overlaps(i, robots, kinds, grid, rule.neighbours, nearest2, near)
        gain = STIFFNESS * MANY_CAUSES / max(MANY_CAUSES, causes)
        again, speed = MOMENTUM * rule.time_step_s, kinds.speed_m_s[robots.kind[i]]
        dx, dy = gain * fx + again * robots.vx[i], gain * fy + again * robots.vy[i]
        last_m = math.sqrt(robots.vx[i] * robots.vx[i] + robots.vy[i] * robots.vy[i]) * rule.time_step_s
        dx, dy = rubbed(dx, dy, last_m, kinds.sensor_m[robots.kind[i]])
        new_vx[i], new_vy[i] = towards(dx, dy, speed, rule.time_step_s)

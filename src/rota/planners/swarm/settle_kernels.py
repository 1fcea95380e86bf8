"""Compiled decision of the controller that comes to rest: overlaps push as springs do, and motion goes on a while."""

from __future__ import annotations

from typing import Any

from rota.planners.swarm.baseline_kernels import MANY_CAUSES, sum_of_overlaps, towards
from rota.planners.swarm.kernels import compiled

STIFFNESS = 0.3  # share of each overlap that a robot takes away in a step; measured: with more, swarms tremble
MOMENTUM = 0.92  # share of the last step that is made again


@compiled
def decide_settle(
    begin: int, end: int, step: int, robots: Any, kinds: Any, grid: Any, moving: Any, rule: Any,
    new_vx: Any, new_vy: Any, nearest2: Any, near: Any, outline: Any, spare: Any,
) -> None:  # fmt: skip
    """Virtual forces with momentum (Polyak's heavy ball): a step is a share of the overlaps and of the step before.

    The overlap of two discs is a potential that every robot sees of its own and that is flat where nothing overlaps,
    hence rest; momentum takes the slow, long waves through a swarm that forces alone need thousands of steps for, and
    carries it past the poorer arrangements in which they get stuck.
    """
    for i in range(begin, end):
        fx, fy, causes = sum_of_overlaps(i, robots, kinds, grid, rule.neighbours, nearest2, near)
        gain = STIFFNESS * MANY_CAUSES / max(MANY_CAUSES, causes)
        again, speed = MOMENTUM * rule.time_step_s, kinds.speed_m_s[robots.kind[i]]
        dx, dy = gain * fx + again * robots.vx[i], gain * fy + again * robots.vy[i]
        new_vx[i], new_vy[i] = towards(dx, dy, speed, rule.time_step_s)

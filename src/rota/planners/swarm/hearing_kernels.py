# mypy: disable-error-code="no-any-return"
"""Compiled decisions of robots that know others from messages: late ones, some of which are lost.

Every robot tells its place and velocity at every step. What it told at step s reaches another one ``delay`` steps
later, or never; lost messages are drawn for each pair and step from the seed, and of ``MOST_LOST_IN_ROW`` + 1 in a row
one arrives. A robot heeds the last message it has of each other one, as old as it is, and its own place as it is.

Where the last filter watches and news may be late, no robot gains more than ``GAIN`` of its top speed from one step to
the next. All know that: one that told of standing still cannot have gone far since. So heaps open, in which nobody
could stir as long as everybody may be anywhere within steps at full speed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.planners.swarm.baseline_kernels import decide_virtual_force, decide_voronoi
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.kernels import cell_of, compiled
from rota.planners.swarm.news_kernels import add_load
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal, sample_key
from rota.planners.swarm.settle_kernels import decide_settle

MOST_LOST_IN_ROW = 8
GAIN = 0.15  # of the top speed, from one step to the next
OWN, RECIPROCAL, VORONOI, VIRTUAL_FORCE, SETTLE = -1, 0, 1, 2, 3
NUMBER_OF = {
    decide_reciprocal: RECIPROCAL,
    decide_voronoi: VORONOI,
    decide_virtual_force: VIRTUAL_FORCE,
    decide_settle: SETTLE,
}


@compiled
def is_lost(seed: int, listener: int, teller: int, step: int, lost: float) -> bool:
    """Whether what one robot told another at a step never arrives."""
    key = sample_key(seed ^ (listener + 1) * 0x5851F42D, teller, step)
    return bool(np.float64(key >> np.uint64(11)) * (1.0 / 9007199254740992.0) < lost)


@compiled
def age_of(seed: int, listener: int, teller: int, step: int, delay: int, lost: float) -> int:
    """How many steps ago what a robot knows of another one was told."""
    age = delay
    if lost > 0.0:
        while age < delay + MOST_LOST_IN_ROW and is_lost(seed, listener, teller, step - age, lost):
            age += 1
    return age


@compiled
def gone_m(age: int, told_m: float, most_m: float) -> float:
    """How far a robot may have gone in so many steps since it told of a step of told_m; no step is above most_m."""
    gone = 0.0
    for k in range(1, age + 1):
        gone += min(most_m, told_m + k * GAIN * most_m)
    return gone


@compiled
def no_faster(vx: float, vy: float, speed: float) -> tuple[float, float]:
    """The velocity, made as short as the speed where it is longer: the filter allows every share of what it allows."""
    length = math.sqrt(vx * vx + vy * vy)
    return (vx * speed / length, vy * speed / length) if length > speed else (vx, vy)


@compiled
def most_round(grid: Any) -> int:
    """The most robots in any cell and those beside it."""
    most, stride = 0, grid.columns + 2
    for j in range(1, grid.rows + 1):
        for i in range(1, grid.columns + 1):
            c, count = j * stride + i, 0
            for row in range(-1, 2):
                count += grid.start[c + row * stride + 2] - grid.start[c + row * stride - 1]
            most = max(most, count)
    return most


@compiled
def look_round(
    i: int, step: int, robots: Any, grid: Any, rule: Any, hearing: Any, past: Any, step_m: Any, view: Any, start: Any,
    spread_m: Any,
) -> None:  # fmt: skip
    """Write robot i and what it knows of those round about into ``view``, as if they stood in its cell alone.

    past: places and velocities told, (steps, 4, n), that of step s at s modulo the steps. step_m: (n,) the longest step
    of each robot. spread_m: how far each in the view may have gone since. start: of the grid that goes with the view.
    """
    view.x[0], view.y[0], view.vx[0], view.vy[0] = robots.x[i], robots.y[i], robots.vx[i], robots.vy[i]
    view.kind[0], view.name[0] = robots.kind[i], robots.name[i]
    spread_m[0] = 0.0
    found, stride, listener = 1, grid.columns + 2, robots.name[i]
    c = cell_of(robots.x[i], robots.y[i], grid)
    for row in range(-1, 2):
        for j in range(grid.start[c + row * stride - 1], grid.start[c + row * stride + 2]):
            if j == i:
                continue
            teller = robots.name[j]
            age = age_of(rule.seed, listener, teller, step, hearing.delay_steps, hearing.lost)
            told = past[(step - age) % past.shape[0]]
            view.x[found], view.y[found] = told[0, teller], told[1, teller]
            view.vx[found], view.vy[found] = told[2, teller], told[3, teller]
            view.kind[found], view.name[found] = robots.kind[j], teller
            told_m = math.sqrt(told[2, teller] ** 2 + told[3, teller] ** 2) * rule.time_step_s
            spread_m[found] = gone_m(age, told_m, step_m[teller])
            found += 1
    start[c - stride - 1], start[c - stride + 2] = 0, 0
    start[c - 1], start[c + 2] = 0, found
    start[c + stride - 1], start[c + stride + 2] = found, found


@compiled
def load_with_told(step: int, robots: Any, kinds: Any, rule: Any, hearing: Any, past: Any, roads: Any) -> None:
    """Load the places with robots' discs as far as messages tell; those that keep the places all listen as one."""
    listener = robots.x.shape[0]
    roads.load[:] = 0.0
    for i in range(robots.x.shape[0]):
        sensor = kinds.sensor_m[robots.kind[i]]
        if sensor > 0.0:
            teller = robots.name[i]
            age = age_of(rule.seed, listener, teller, step, hearing.delay_steps, hearing.lost)
            told = past[(step - age) % past.shape[0]]
            add_load(told[0, teller], told[1, teller], sensor, 1.0, roads)


@compiled
def decide_heard(
    begin: int, end: int, step: int, controller: int, safe: bool, robots: Any, kinds: Any, grid: Any, moving: Any,
    rule: Any, hearing: Any, past: Any, step_m: Any, widest_m: float, new_vx: Any, new_vy: Any, near: Any,
    outline: Any, spare: Any, view: Any, view_grid: Any, spread_m: Any, out: Any,
) -> None:  # fmt: skip
    """New velocities of the robots begin..end - 1 from what each of them has heard, filtered where ``safe``.

    widest_m: the largest body, the longest step of any robot and the farthest that one may have gone unheard.
    controller OWN: what stands in new_vx and new_vy is filtered. view, view_grid, spread_m, out (3, 1): room.
    """
    vx, vy, nearest2 = out[0], out[1], out[2]
    for i in range(begin, end):
        look_round(i, step, robots, grid, rule, hearing, past, step_m, view, view_grid.start, spread_m)
        vx[0], vy[0], nearest2[0] = new_vx[i], new_vy[i], 0.0
        if controller == RECIPROCAL:
            decide_reciprocal(
                0, 1, step, view, kinds, view_grid, moving, rule, vx, vy, nearest2, near, outline, spare
            )  # fmt: skip
        elif controller == VORONOI:
            decide_voronoi(
                0, 1, step, view, kinds, view_grid, moving, rule, vx, vy, nearest2, near, outline, spare
            )  # fmt: skip
        elif controller == VIRTUAL_FORCE:
            decide_virtual_force(
                0, 1, step, view, kinds, view_grid, moving, rule, vx, vy, nearest2, near, outline, spare
            )  # fmt: skip
        elif controller == SETTLE:
            decide_settle(0, 1, step, view, kinds, view_grid, moving, rule, vx, vy, nearest2, near, outline, spare)
        if safe:
            filter_velocities(
                0, 1, view, kinds, view_grid, moving, rule.time_step_s, widest_m, spread_m, vx, vy, nearest2, outline,
                spare,
            )  # fmt: skip
            if hearing.delay_steps > 0 or hearing.lost > 0.0:
                speed = math.sqrt(robots.vx[i] * robots.vx[i] + robots.vy[i] * robots.vy[i])
                vx[0], vy[0] = no_faster(vx[0], vy[0], speed + GAIN * kinds.speed_m_s[robots.kind[i]])
        new_vx[i], new_vy[i] = vx[0], vy[0]

# mypy: disable-error-code="no-any-return"
"""Compiled measures of a swarm in one step: what is in range of anybody, and how near bodies and walls come."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats
from rota.planners.swarm.kernels import cell_of, to_wall


class Pixels(NamedTuple):
    """Pixels of side ``pixel_m`` (rows, columns): 1 where a pixel is free, else 0, and the mark that each got last.

    worth: the importance of each, or (0, 0) where all are worth as much. (x0, y0): the centre of the first pixel, in
    metres.
    """

    free: NDArray[np.uint8]
    worth: Floats
    marks: NDArray[np.int32]
    x0: float
    y0: float
    pixel_m: float


@allocation_free
def mark_new(robots: Any, kinds: Any, squares: Any, pixels: Any, mark: int) -> tuple[int, float]:
    """Mark the free pixels whose centres are in range of any robot; returns how many there are, and their worth.

    squares: (n,) in the order of the fleet, whose footprints are squares of that half side, not discs of that radius.
    pixels: ``Pixels``, whose marks become ``mark``, a number that none of them was marked with before.
    """
    free, worth, marks, x0, y0, pixel_m = pixels
    rows, columns = free.shape
    count, total, differs = 0, 0.0, worth.shape[0] > 0
    for k in range(robots.x.shape[0]):
        x, y, sensor = robots.x[k], robots.y[k], kinds.sensor_m[robots.kind[k]]
        low = max(math.ceil((y - sensor - y0) / pixel_m), 0)
        high = min(math.floor((y + sensor - y0) / pixel_m), rows - 1)
        for j in range(low, high + 1):
            dy = y0 + j * pixel_m - y
            half = sensor if squares[robots.name[k]] else math.sqrt(max(sensor * sensor - dy * dy, 0.0))
            left = max(math.ceil((x - half - x0) / pixel_m), 0)
            right = min(math.floor((x + half - x0) / pixel_m), columns - 1)
            for i in range(left, right + 1):
                if marks[j, i] != mark and free[j, i] != 0:
                    marks[j, i] = mark
                    count += 1
                    total += worth[j, i] if differs else 0.0
    return count, total


@allocation_free
def least_gaps(robots: Any, kinds: Any, grid: Any) -> tuple[float, float]:
    """Least distances in metres between the rims of two bodies, and of a body and a wall, as far as near cells show.

    Below 0 for what overlaps; inf where nothing is near.
    """
    between, beside = math.inf, math.inf
    stride = grid.columns + 2
    for i in range(robots.x.shape[0]):
        x, y, body = robots.x[i], robots.y[i], kinds.body_m[robots.kind[i]]
        c = cell_of(x, y, grid)
        for row in range(3):
            first = c + (row - 1) * stride
            for j in range(grid.start[first - 1], grid.start[first + 2]):
                if j > i:
                    dx, dy = robots.x[j] - x, robots.y[j] - y
                    gap = math.sqrt(dx * dx + dy * dy) - body - kinds.body_m[robots.kind[j]]
                    between = min(between, gap)
        for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
            dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
            beside = min(beside, math.sqrt(dx * dx + dy * dy) - body)
    return between, beside


@allocation_free
def count_turns_back(robots: Any, before_vx: Any, before_vy: Any, least_m_s: float) -> int:
    """How many robots move against their velocity of the step before.

    before_vx, before_vy: (n,) by number in the fleet; they take the velocities of now. A robot slower than least_m_s,
    before or now, is at rest.
    """
    count = 0
    for k in range(robots.x.shape[0]):
        vx, vy, name = robots.vx[k], robots.vy[k], robots.name[k]
        ux, uy = before_vx[name], before_vy[name]
        moves = min(vx * vx + vy * vy, ux * ux + uy * uy) > least_m_s * least_m_s
        if moves and vx * ux + vy * uy < 0.0:
            count += 1
        before_vx[name], before_vy[name] = vx, vy
    return count

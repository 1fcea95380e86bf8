"""How far a point sees in each direction: most looks need no wall one by one. Arrays are as in ``kernels.py``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.planners.patrol.ground.sight_kernels import DEPTH_SECTORS, sectors_from_x
from rota.planners.patrol.tolerances import ON_LINE_M, TIE


def depths_near_walls(xy: Any, wall_start: Any, wall_item: Any, walls: Any) -> tuple[Any, Any]:
    """The depths of the points that have walls, and the row (n,) of each point there; 0 for one that has none."""
    walled = np.flatnonzero(np.diff(wall_start))
    row = np.zeros(len(xy), dtype=np.int32)
    row[walled] = np.arange(len(walled))
    return depths(xy[walled], wall_start[np.append(walled, len(xy))], wall_item, walls), row


@kernel(error_model="numpy")
def depths(xy: Any, wall_start: Any, wall_item: Any, walls: Any) -> Any:
    """(n, 2, DEPTH_SECTORS) float32 squared metres: up to there nothing is hidden, and beyond there everything is.

    Of each point with walls, in each sector of directions round it: 0 and inf where that is not known. All is hidden
    behind a wall that spans the whole sector. Round a point that lies on a wall nothing is known to be clear.
    """
    n = xy.shape[0]
    depth2 = np.empty((n, 2, DEPTH_SECTORS), dtype=np.float32)
    clear, blocked = np.empty(DEPTH_SECTORS), np.empty(DEPTH_SECTORS)
    borders = _borders()
    slack = 1e-5  # share of a depth given away: depths are kept with 24 bits
    for i in range(n):
        clear[:], blocked[:] = math.inf, math.inf
        x, y = xy[i]
        for j in range(wall_start[i], wall_start[i + 1]):
            w = walls[wall_item[j]]
            _shadow(w[0] - x, w[1] - y, w[2] - x, w[3] - y, borders, clear, blocked)
        for k in range(DEPTH_SECTORS):
            depth2[i, 0, k] = ((1 - slack) * clear[k]) ** 2
            depth2[i, 1, k] = ((1 + slack) * blocked[k]) ** 2
    return depth2


@kernel
def _borders() -> Any:
    """(DEPTH_SECTORS, 2) unit vectors towards which the sectors begin."""
    borders = np.empty((DEPTH_SECTORS, 2))
    for k in range(DEPTH_SECTORS):
        quarter, along = divmod(4.0 * k / DEPTH_SECTORS, 1.0)
        long = math.sqrt((1.0 - along) ** 2 + along**2)
        bx, by = (1.0 - along) / long, along / long
        for _ in range(int(quarter)):
            bx, by = -by, bx
        borders[k, 0], borders[k, 1] = bx, by
    return borders


@allocation_free
def _shadow(ux: float, uy: float, vx: float, vy: float, borders: Any, clear: Any, blocked: Any) -> None:
    """Let one wall, from u to v as seen from the point, bring down the depths of the sectors that it reaches into."""
    turn = ux * vy - uy * vx
    wx, wy = vx - ux, vy - uy
    square = wx * wx + wy * wy
    if turn * turn <= ON_LINE_M * ON_LINE_M * square:
        if ux * vx + uy * vy < 0:  # the point lies on it; a wall seen from its end hides nothing
            clear[:] = 0.0
        return
    if turn < 0:
        ux, uy, vx, vy, wx, wy, turn = vx, vy, ux, uy, -wx, -wy, -turn
    first, last = math.floor(sectors_from_x(ux, uy) - TIE), math.floor(sectors_from_x(vx, vy) + TIE)
    count = (last - first) % DEPTH_SECTORS + 1
    ends = math.sqrt(ux * ux + uy * uy), math.sqrt(vx * vx + vy * vy)
    inside = ux * wx + uy * wy < 0 < vx * wx + vy * wy
    foot = int(sectors_from_x(wy, -wx)) % DEPTH_SECTORS  # the sector of the nearest place of its line
    for step in range(count):
        k = (first + step) % DEPTH_SECTORS
        bx, by = borders[k]
        ex, ey = borders[(k + 1) % DEPTH_SECTORS]
        begins = ends[0] if step == 0 else turn / (bx * wy - by * wx)
        ends_at = ends[1] if step == count - 1 else turn / (ex * wy - ey * wx)
        near = turn / math.sqrt(square) if inside and foot == k else min(begins, ends_at)
        clear[k] = min(clear[k], max(0.0, near - 2 * ON_LINE_M))
        if 0 < step < count - 1:
            blocked[k] = min(blocked[k], max(begins, ends_at))

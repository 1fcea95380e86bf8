# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled questions to a grid of border edges: point in space, segment in space, sight from point to point.

Edges are rows x0, y0, x1, y1 in metres with the space (or the obstacle, for walls of sight) on the left. Everything is
exact up to TOUCH_M: what comes that close to a border touches it, and touching is allowed everywhere.
"""

from __future__ import annotations

from math import hypot, inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import allocation_free, kernel, noinline

TOUCH_M = 1e-9
LEAST_M2 = 1e-300  # the square of the length of an edge: corners so near that it rounds to 0 are one place

OUTSIDE, INSIDE, BORDER = 0, 1, 2


@by_reference
class EdgeGrid(NamedTuple):
    """Edges sorted into square cells; made by ``rota.geometry.line_of_sight.edge_grid``.

    The edges near cell c = j * nx + i are items[start[c] : start[c + 1]], those whose heights meet row j the same with
    c = nx * ny + j. clear: 0 for a cell with an edge near; otherwise the steps (the diagonal counts one) to the nearest
    such cell, positive inside and negative outside.
    """

    x0: float
    y0: float
    cell_m: float
    nx: int
    ny: int
    start: Any
    items: Any
    edges: Any
    clear: Any


@allocation_free
def _edge_meets_box(edge, left, low, right, high):
    """Whether an edge (4,) has a point in the closed box."""
    if max(edge[0], edge[2]) < left or min(edge[0], edge[2]) > right:
        return False
    if max(edge[1], edge[3]) < low or min(edge[1], edge[3]) > high:
        return False
    dx, dy = edge[2] - edge[0], edge[3] - edge[1]
    side = dx * (0.5 * (low + high) - edge[1]) - dy * (0.5 * (left + right) - edge[0])
    return abs(side) <= 0.5 * (abs(dx) * (high - low) + abs(dy) * (right - left))


@kernel
def cells_of_edges(edges, x0, y0, cell_m, nx, ny, margin_m):
    """Start and items of the cells that each edge comes within margin_m of, row by row."""
    start = np.zeros(nx * ny + 1, np.int64)
    items, place = np.empty(0, np.int64), start
    for filling in range(2):
        for k in range(len(edges)):
            edge = edges[k]
            i0 = max(int((min(edge[0], edge[2]) - margin_m - x0) / cell_m), 0)
            i1 = min(int((max(edge[0], edge[2]) + margin_m - x0) / cell_m), nx - 1)
            j0 = max(int((min(edge[1], edge[3]) - margin_m - y0) / cell_m), 0)
            j1 = min(int((max(edge[1], edge[3]) + margin_m - y0) / cell_m), ny - 1)
            for j in range(j0, j1 + 1):
                low = y0 + j * cell_m - margin_m
                for i in range(i0, i1 + 1):
                    left = x0 + i * cell_m - margin_m
                    width = cell_m + 2.0 * margin_m
                    if _edge_meets_box(edge, left, low, left + width, low + width):
                        if filling:
                            items[place[j * nx + i]] = k
                            place[j * nx + i] += 1
                        else:
                            start[j * nx + i + 1] += 1
        if not filling:
            for c in range(nx * ny):
                start[c + 1] += start[c]
            items, place = np.empty(start[-1], np.int64), start.copy()
    return start, items


@kernel
def rows_of_edges(edges, y0, cell_m, ny, margin_m):
    """Start and items of the rows of cells whose heights each edge comes within margin_m of."""
    first, last = np.empty(len(edges), np.int64), np.empty(len(edges), np.int64)
    start = np.zeros(ny + 1, np.int64)
    for k in range(len(edges)):
        first[k] = max(int((min(edges[k, 1], edges[k, 3]) - margin_m - y0) / cell_m), 0)
        last[k] = min(int((max(edges[k, 1], edges[k, 3]) + margin_m - y0) / cell_m), ny - 1)
        for j in range(first[k], last[k] + 1):
            start[j + 1] += 1
    for j in range(ny):
        start[j + 1] += start[j]
    items, place = np.empty(start[-1], np.int64), start.copy()
    for k in range(len(edges)):
        for j in range(first[k], last[k] + 1):
            items[place[j]] = k
            place[j] += 1
    return start, items


@allocation_free
def _is_left_of_odd_edges(px, py, edges, items, begin, end):
    """Crossing parity of the ray from the point to the right, over edges items[begin:end]."""
    odd = False
    for n in range(begin, end):
        k = items[n]
        ey0, ey1 = edges[k, 1], edges[k, 3]
        if (ey0 <= py) != (ey1 <= py):
            side = (edges[k, 2] - edges[k, 0]) * (py - ey0) - (ey1 - ey0) * (px - edges[k, 0])
            if (side > 0.0) == (ey1 > ey0):
                odd = not odd
    return odd


@kernel
def clearances(edges, x0, y0, cell_m, nx, ny, start, items):
    """``clear`` of an EdgeGrid: chessboard distances in two sweeps, their signs by crossing parity."""
    clear = np.full((ny + 2, nx + 2), nx + ny, np.int64)
    for j in range(ny):
        for i in range(nx):
            if start[j * nx + i + 1] > start[j * nx + i]:
                clear[j + 1, i + 1] = 0
    for j in range(1, ny + 1):
        for i in range(1, nx + 1):
            near = min(clear[j - 1, i - 1], clear[j - 1, i], clear[j - 1, i + 1], clear[j, i - 1])
            clear[j, i] = min(clear[j, i], near + 1)
    for j in range(ny, 0, -1):
        for i in range(nx, 0, -1):
            near = min(clear[j + 1, i + 1], clear[j + 1, i], clear[j + 1, i - 1], clear[j, i + 1])
            clear[j, i] = min(clear[j, i], near + 1)
    signed = np.zeros(nx * ny, np.int64)
    for j in range(ny):
        row, inside = nx * ny + j, False
        for i in range(nx):
            steps = clear[j + 1, i + 1]
            if steps > 0 and (i == 0 or clear[j + 1, i] == 0):
                x, y = x0 + (i + 0.5) * cell_m, y0 + (j + 0.5) * cell_m
                inside = _is_left_of_odd_edges(x, y, edges, items, start[row], start[row + 1])
            signed[j * nx + i] = steps if inside else -steps
    return signed


@allocation_free
def _place(px, py, grid, touch_m):
    """INSIDE, OUTSIDE, or BORDER for a point within touch_m of an edge."""
    u, v = (px - grid.x0) / grid.cell_m, (py - grid.y0) / grid.cell_m
    if not (u >= 0.0 and v >= 0.0 and u < grid.nx and v < grid.ny):
        return OUTSIDE
    j = int(v)
    c = j * grid.nx + int(u)
    if grid.clear[c] != 0:
        return INSIDE if grid.clear[c] > 0 else OUTSIDE
    edges = grid.edges
    for n in range(grid.start[c], grid.start[c + 1]):
        k = grid.items[n]
        wx, wy = edges[k, 2] - edges[k, 0], edges[k, 3] - edges[k, 1]
        ax, ay = px - edges[k, 0], py - edges[k, 1]
        s = min(max((ax * wx + ay * wy) / max(wx * wx + wy * wy, LEAST_M2), 0.0), 1.0)
        if (ax - s * wx) ** 2 + (ay - s * wy) ** 2 <= touch_m * touch_m:
            return BORDER
    row = grid.nx * grid.ny + j
    odd = _is_left_of_odd_edges(px, py, edges, grid.items, grid.start[row], grid.start[row + 1])
    return INSIDE if odd else OUTSIDE


@noinline
def point_in_space(px, py, grid):
    """Whether the point lies in the closed space."""
    return _place(px, py, grid, TOUCH_M) != OUTSIDE


@allocation_free
def _contact(ax, ay, bx, by, ux, uy, edges, k):
    """0: apart, 1: within TOUCH_M of each other, 2: properly crossing; (ux, uy) is the unit vector from a to b."""
    ex0, ey0, ex1, ey1 = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
    d0 = ux * (ey0 - ay) - uy * (ex0 - ax)
    d1 = ux * (ey1 - ay) - uy * (ex1 - ax)
    if (d0 > TOUCH_M and d1 > TOUCH_M) or (d0 < -TOUCH_M and d1 < -TOUCH_M):
        return 0
    wx, wy = ex1 - ex0, ey1 - ey0
    touch = TOUCH_M * sqrt(wx * wx + wy * wy)
    ea = wx * (ay - ey0) - wy * (ax - ex0)
    eb = wx * (by - ey0) - wy * (bx - ex0)
    if (ea > touch and eb > touch) or (ea < -touch and eb < -touch):
        return 0
    if abs(d0) <= TOUCH_M or abs(d1) <= TOUCH_M or abs(ea) <= touch or abs(eb) <= touch:
        return 1
    return 2


@allocation_free
def _clip_to_grid(ax, ay, dx, dy, grid):
    """First and last parameter of a + t d, t in 0..1, in the grid; the first is greater when there is none."""
    wide, high = grid.nx * grid.cell_m, grid.ny * grid.cell_m
    if (
        min(ax, ax + dx) >= grid.x0
        and min(ay, ay + dy) >= grid.y0
        and max(ax, ax + dx) <= grid.x0 + wide
        and max(ay, ay + dy) <= grid.y0 + high
    ):
        return 0.0, 1.0
    first, last = 0.0, 1.0
    for a, d, low, size in ((ax, dx, grid.x0, wide), (ay, dy, grid.y0, high)):
        if d == 0.0:
            if a < low or a > low + size:
                return 1.0, 0.0
        else:
            t0, t1 = (low - a) / d, (low + size - a) / d
            first, last = max(first, min(t0, t1)), min(last, max(t0, t1))
    return first, last


@allocation_free
def contacts_of(ax, ay, bx, by, grid, touches):
    """How many touches of edges lie on the segment; -1 - k when it properly crosses edge k, the first one found.

    touches: row by row takes the two parameters at which an edge's ends lie on the segment; empty: not asked for.
    """
    dx, dy = bx - ax, by - ay
    length = sqrt(dx * dx + dy * dy)
    t, last = _clip_to_grid(ax, ay, dx, dy, grid)
    count = 0
    if t > last:
        return count
    i = min(max(int((ax + t * dx - grid.x0) / grid.cell_m), 0), grid.nx - 1)
    j = min(max(int((ay + t * dy - grid.y0) / grid.cell_m), 0), grid.ny - 1)
    while True:
        c = j * grid.nx + i
        for n in range(grid.start[c], grid.start[c + 1]):
            k = grid.items[n]
            contact = _contact(ax, ay, bx, by, dx / length, dy / length, grid.edges, k)
            if contact == 2:
                return -1 - k
            if contact == 1:
                if len(touches):
                    for e in range(2):
                        ex, ey = grid.edges[k, 2 * e] - ax, grid.edges[k, 2 * e + 1] - ay
                        on_line = abs(dx * ey - dy * ex) <= TOUCH_M * length
                        s = (dx * ex + dy * ey) / (length * length)
                        touches[count, e] = min(max(s, 0.0), 1.0) if on_line else 0.0
                count += 1
        clear = abs(grid.clear[c])
        if clear > 1:
            # no edge within clear - 1 cells: jump, and find the cell again
            t += 0.999 * (clear - 1) * grid.cell_m / length
            i = min(max(int((ax + t * dx - grid.x0) / grid.cell_m), 0), grid.nx - 1)
            j = min(max(int((ay + t * dy - grid.y0) / grid.cell_m), 0), grid.ny - 1)
        else:
            tx = (grid.x0 + (i + (dx > 0.0)) * grid.cell_m - ax) / dx if dx != 0.0 else inf
            ty = (grid.y0 + (j + (dy > 0.0)) * grid.cell_m - ay) / dy if dy != 0.0 else inf
            t = max(t, min(tx, ty))
            if tx < ty:
                i += 1 if dx > 0.0 else -1
            else:
                j += 1 if dy > 0.0 else -1
        if t > last or i < 0 or j < 0 or i >= grid.nx or j >= grid.ny:
            return count


@kernel
def meets_between_touches(ax, ay, bx, by, grid, count, what):
    """Whether a stretch of the segment between two touches lies in what (INSIDE or OUTSIDE)."""
    rows = np.zeros((count + 1, 2))
    contacts_of(ax, ay, bx, by, grid, rows)
    rows[count] = 1.0
    touches = rows.ravel()
    for n in range(1, len(touches)):
        value, m = touches[n], n
        while m > 0 and touches[m - 1] > value:
            touches[m] = touches[m - 1]
            m -= 1
        touches[m] = value
    shortest = 4.0 * TOUCH_M / hypot(bx - ax, by - ay)
    before = 0.0
    for n in range(len(touches)):
        if touches[n] - before > shortest:
            t = 0.5 * (before + touches[n])
            if _place(ax + t * (bx - ax), ay + t * (by - ay), grid, 2.0 * TOUCH_M) == what:
                return True
        before = touches[n]
    return False


@kernel(noinline=True)
def segment_is_free(ax, ay, bx, by, grid):
    """Whether the segment stays in the closed space; both ends must lie in it."""
    if (ax - bx) ** 2 + (ay - by) ** 2 <= TOUCH_M * TOUCH_M:
        return True
    count = contacts_of(ax, ay, bx, by, grid, grid.edges[:0])
    if count <= 0:
        return count == 0
    return not meets_between_touches(ax, ay, bx, by, grid, count, np.int64(OUTSIDE))


@kernel
def point_sees_point(ax, ay, bx, by, grid):
    """Whether the segment meets no inside of an obstacle, its ends included; grid: of walls of sight."""
    if _place(ax, ay, grid, TOUCH_M) == INSIDE or _place(bx, by, grid, TOUCH_M) == INSIDE:
        return False
    if (ax - bx) ** 2 + (ay - by) ** 2 <= TOUCH_M * TOUCH_M:
        return True
    count = contacts_of(ax, ay, bx, by, grid, grid.edges[:0])
    if count <= 0:
        return count == 0
    return not meets_between_touches(ax, ay, bx, by, grid, count, np.int64(INSIDE))


@kernel
def points_in_space(points, grid):
    """point_in_space for each row."""
    inside = np.empty(len(points), np.bool_)
    for k in range(len(points)):
        inside[k] = point_in_space(points[k, 0], points[k, 1], grid)
    return inside


@kernel
def free_segments(a, b, grid):
    """segment_is_free for each pair of rows."""
    free = np.empty(len(a), np.bool_)
    for k in range(len(a)):
        free[k] = segment_is_free(a[k, 0], a[k, 1], b[k, 0], b[k, 1], grid)
    return free


@kernel
def seen_points(a, b, grid):
    """point_sees_point for each pair of rows."""
    seen = np.empty(len(a), np.bool_)
    for k in range(len(a)):
        seen[k] = point_sees_point(a[k, 0], a[k, 1], b[k, 0], b[k, 1], grid)
    return seen

"""Compiled loops of the geometry: edges in a grid, what crosses them, and shortest paths over corners.

The grid holds the border edges of a region. Cells that no edge touches know whether they are inside, so that most
questions end in the first cell. Everything here is exact up to ``TOLERANCE_M``: touching is not crossing.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

TOLERANCE_M = 1e-9
MOST_TOUCHES = 64
OUTSIDE, INSIDE, MIXED = 0, 1, 2


class EdgeGrid(NamedTuple):
    """Edges (k, 4) sorted into square cells; ``kind`` says of each cell whether it is outside, inside or holds edges."""

    frame: NDArray[np.float64]  # x0, y0, cell size in metres
    size: NDArray[np.int64]  # columns, rows
    start: NDArray[np.int64]
    items: NDArray[np.int64]
    kind: NDArray[np.int64]
    edges: NDArray[np.float64]


@njit(cache=True)
def edge_touches_cell(edges: Any, e: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether an edge comes into a (slightly grown) box: separating axes."""
    ax, ay, bx, by = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
    if max(ax, bx) < x0 or min(ax, bx) > x1 or max(ay, by) < y0 or min(ay, by) > y1:
        return False
    mx, my = (x0 + x1) / 2 - ax, (y0 + y1) / 2 - ay
    dx, dy = bx - ax, by - ay
    return abs(dx * my - dy * mx) <= (abs(dx) * (y1 - y0) + abs(dy) * (x1 - x0)) / 2


@njit(cache=True)
def fill_grid(frame: Any, size: Any, edges: Any, start: Any, items: Any, counting: bool) -> None:
    """Count the edges of each cell into start[cell + 1], or enter them at start[cell] (which then moves on)."""
    cell = frame[2]
    grown = 1e-6 * cell + 4 * TOLERANCE_M
    for e in range(edges.shape[0]):
        c0 = int((min(edges[e, 0], edges[e, 2]) - grown - frame[0]) / cell)
        c1 = int((max(edges[e, 0], edges[e, 2]) + grown - frame[0]) / cell)
        r0 = int((min(edges[e, 1], edges[e, 3]) - grown - frame[1]) / cell)
        r1 = int((max(edges[e, 1], edges[e, 3]) + grown - frame[1]) / cell)
        for r in range(max(0, r0), min(size[1] - 1, r1) + 1):
            for c in range(max(0, c0), min(size[0] - 1, c1) + 1):
                x, y = frame[0] + c * cell, frame[1] + r * cell
                if edge_touches_cell(edges, e, x - grown, y - grown, x + cell + grown, y + cell + grown):
                    at = r * size[0] + c
                    if counting:
                        start[at + 1] += 1
                    else:
                        items[start[at]] = e
                        start[at] += 1


@njit(cache=True)
def label_cells(grid: EdgeGrid) -> None:
    """Set ``kind`` of every cell: crossing parity from the left border, which lies outside, along the middle of each row."""
    for r in range(grid.size[1]):
        y = grid.frame[1] + (r + 0.5) * grid.frame[2]
        inside = False
        for c in range(grid.size[0]):
            at = r * grid.size[0] + c
            if grid.start[at + 1] == grid.start[at]:
                grid.kind[at] = INSIDE if inside else OUTSIDE
                continue
            grid.kind[at] = MIXED
            for j in range(grid.start[at], grid.start[at + 1]):
                if crosses_row(grid, grid.items[j], y, c):
                    inside = not inside


@njit(cache=True)
def crossing_x(edges: Any, e: int, y: float) -> float:
    """Where the horizontal line at y crosses edge e, nan when it does not (the upper end does not belong to the edge)."""
    y0, y1 = edges[e, 1], edges[e, 3]
    if (y0 <= y) == (y1 <= y):
        return math.nan
    return edges[e, 0] + (y - y0) / (y1 - y0) * (edges[e, 2] - edges[e, 0])


@njit(cache=True)
def crosses_row(grid: EdgeGrid, e: int, y: float, column: int) -> bool:
    """Whether edge e crosses the horizontal line at y within this column (each crossing belongs to one column)."""
    x = crossing_x(grid.edges, e, y)
    if math.isnan(x):
        return False
    at = int((x - grid.frame[0]) / grid.frame[2])
    return min(max(at, 0), grid.size[0] - 1) == column


@njit(cache=True)
def point_in_space(px: float, py: float, grid: EdgeGrid) -> bool:
    """Whether the point lies in the region that the edges enclose, its border included."""
    cell = grid.frame[2]
    c, r = int(math.floor((px - grid.frame[0]) / cell)), int(math.floor((py - grid.frame[1]) / cell))
    if c < 0 or r < 0 or c >= grid.size[0] or r >= grid.size[1]:
        return False
    at = r * grid.size[0] + c
    if grid.kind[at] != MIXED:
        return bool(grid.kind[at] == INSIDE)
    for j in range(grid.start[at], grid.start[at + 1]):
        if distance_to_edge(px, py, grid.edges, grid.items[j]) <= TOLERANCE_M:
            return True
    crossings = 0
    column = c
    while True:
        at = r * grid.size[0] + column
        if grid.kind[at] != MIXED:
            return (crossings % 2 == 1) != (grid.kind[at] == INSIDE)
        for j in range(grid.start[at], grid.start[at + 1]):
            e = grid.items[j]
            if crosses_row(grid, e, py, column) and crossing_x(grid.edges, e, py) > px:
                crossings += 1
        column += 1
        if column == grid.size[0]:
            return crossings % 2 == 1


@njit(cache=True)
def distance_to_edge(px: float, py: float, edges: Any, e: int) -> float:
    """Distance from a point to an edge."""
    ax, ay = edges[e, 0], edges[e, 1]
    dx, dy = edges[e, 2] - ax, edges[e, 3] - ay
    long = dx * dx + dy * dy
    t = 0.0 if long == 0 else min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / long))
    return math.hypot(px - ax - t * dx, py - ay - t * dy)


@njit(cache=True)
def meet(ax: float, ay: float, bx: float, by: float, long: float, edges: Any, e: int, touches: Any, found: int) -> int:
    """Crossing of the segment a-b with edge e: -1 proper; else the new number of touches (where a-b may change sides)."""
    cx, cy, dx, dy = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
    ux, uy = (bx - ax) / long, (by - ay) / long
    side_c, side_d = ux * (cy - ay) - uy * (cx - ax), ux * (dy - ay) - uy * (dx - ax)
    tol = TOLERANCE_M
    if (side_c > tol and side_d > tol) or (side_c < -tol and side_d < -tol):
        return found
    edge = math.hypot(dx - cx, dy - cy)
    if edge == 0:
        return found
    vx, vy = (dx - cx) / edge, (dy - cy) / edge
    side_a, side_b = vx * (ay - cy) - vy * (ax - cx), vx * (by - cy) - vy * (bx - cx)
    if (side_a > tol and side_b > tol) or (side_a < -tol and side_b < -tol):
        return found
    if abs(side_c) > tol and abs(side_d) > tol and abs(side_a) > tol and abs(side_b) > tol:
        return -1
    for k in range(2):
        px, py, side = (cx, cy, side_c) if k == 0 else (dx, dy, side_d)
        along = ux * (px - ax) + uy * (py - ay)
        if abs(side) <= tol and -tol <= along <= long + tol and found < MOST_TOUCHES:
            touches[found] = min(1.0, max(0.0, along / long))
            found += 1
    for k in range(2):
        px, py, side = (ax, ay, side_a) if k == 0 else (bx, by, side_b)
        along = vx * (px - cx) + vy * (py - cy)
        if abs(side) <= tol and -tol <= along <= edge + tol and found < MOST_TOUCHES:
            touches[found] = float(k)
            found += 1
    return found


@njit(cache=True)
def segment_is_free(ax: float, ay: float, bx: float, by: float, grid: EdgeGrid) -> bool:
    """Whether the segment between two points of the region stays in it; running along the border is allowed."""
    long = math.hypot(bx - ax, by - ay)
    if long <= TOLERANCE_M:
        return True
    cell = grid.frame[2]
    fx, fy = (ax - grid.frame[0]) / cell, (ay - grid.frame[1]) / cell
    gx, gy = (bx - grid.frame[0]) / cell, (by - grid.frame[1]) / cell
    c, r = int(math.floor(fx)), int(math.floor(fy))
    last_c, last_r = int(math.floor(gx)), int(math.floor(gy))
    step_c, step_r = (1 if gx > fx else -1), (1 if gy > fy else -1)
    per_c = math.inf if gx == fx else 1 / abs(gx - fx)
    per_r = math.inf if gy == fy else 1 / abs(gy - fy)
    next_c = math.inf if gx == fx else ((c + (step_c > 0)) - fx) * step_c * per_c
    next_r = math.inf if gy == fy else ((r + (step_r > 0)) - fy) * step_r * per_r
    touches = np.empty(MOST_TOUCHES)
    found = 0
    for _ in range(abs(last_c - c) + abs(last_r - r) + 1):
        if c < 0 or r < 0 or c >= grid.size[0] or r >= grid.size[1]:
            return False
        at = r * grid.size[0] + c
        if grid.kind[at] == OUTSIDE:
            return False
        for j in range(grid.start[at], grid.start[at + 1]):
            found = meet(ax, ay, bx, by, long, grid.edges, grid.items[j], touches, found)
            if found < 0 or found == MOST_TOUCHES:
                return False
        if next_c < next_r:
            c += step_c
            next_c += per_c
        else:
            r += step_r
            next_r += per_r
    if found == 0:
        return True
    # between two touches the segment is wholly in or wholly out: look at the middle of each stretch
    stops = np.sort(touches[:found])
    before = 0.0
    for k in range(found + 1):
        t = stops[k] if k < found else 1.0
        if (t - before) * long > 2 * TOLERANCE_M:
            middle = (before + t) / 2
            if not point_in_space(ax + middle * (bx - ax), ay + middle * (by - ay), grid):
                return False
        before = max(before, t)
    return True


@njit(cache=True)
def many_segments_free(a: Any, b: Any, grid: EdgeGrid) -> Any:
    """``segment_is_free`` for rows of a and b (n, 2)."""
    out = np.empty(a.shape[0], dtype=np.bool_)
    for i in range(a.shape[0]):
        out[i] = segment_is_free(a[i, 0], a[i, 1], b[i, 0], b[i, 1], grid)
    return out


@njit(cache=True)
def many_points_inside(p: Any, grid: EdgeGrid) -> Any:
    """``point_in_space`` for rows of p (n, 2)."""
    out = np.empty(p.shape[0], dtype=np.bool_)
    for i in range(p.shape[0]):
        out[i] = point_in_space(p[i, 0], p[i, 1], grid)
    return out


@njit(cache=True)
def tangent(px: float, py: float, corner: int, corners: Any) -> bool:
    """Whether the line from p through a corner (x, y, before, after) leaves both its edges on one side."""
    cx, cy = corners[corner, 0], corners[corner, 1]
    dx, dy = cx - px, cy - py
    one = dx * (corners[corner, 3] - cy) - dy * (corners[corner, 2] - cx)
    two = dx * (corners[corner, 5] - cy) - dy * (corners[corner, 4] - cx)
    slack = TOLERANCE_M * math.hypot(dx, dy)
    return not ((one > slack and two < -slack) or (one < -slack and two > slack))


@njit(cache=True)
def see_corners(p: Any, corners: Any, grid: EdgeGrid) -> Any:
    """Distance (n, c) from each point to each corner that it sees along a tangent, inf where it does not."""
    out = np.full((p.shape[0], corners.shape[0]), np.inf)
    for i in range(p.shape[0]):
        for j in range(corners.shape[0]):
            x, y = corners[j, 0], corners[j, 1]
            if tangent(p[i, 0], p[i, 1], j, corners) and segment_is_free(p[i, 0], p[i, 1], x, y, grid):
                out[i, j] = math.hypot(x - p[i, 0], y - p[i, 1])
    return out


@njit(cache=True)
def bitangents(corners: Any, grid: EdgeGrid) -> Any:
    """Lengths (c, c) of the edges between corners that a shortest path may use, 0 where there is none."""
    n = corners.shape[0]
    out = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            ax, ay, bx, by = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
            if tangent(ax, ay, j, corners) and tangent(bx, by, i, corners) and segment_is_free(ax, ay, bx, by, grid):
                out[i, j] = out[j, i] = math.hypot(bx - ax, by - ay)
    return out


@njit(cache=True)
def through_corners(from_a: Any, between: Any, from_b: Any) -> Any:
    """Shortest a - corner - ... - corner - b: lengths (n, m) from the corner distances (n, c), (c, c) and (m, c)."""
    n, m, c = from_a.shape[0], from_b.shape[0], between.shape[0]
    out = np.full((n, m), np.inf)
    reach = np.empty(c)
    for i in range(n):
        reach[:] = np.inf
        for j in range(c):
            if from_a[i, j] < np.inf:
                for k in range(c):
                    reach[k] = min(reach[k], from_a[i, j] + between[j, k])
        for q in range(m):
            best = np.inf
            for k in range(c):
                if from_b[q, k] < np.inf:
                    best = min(best, reach[k] + from_b[q, k])
            out[i, q] = best
    return out

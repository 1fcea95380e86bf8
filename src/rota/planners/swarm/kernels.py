# mypy: disable-error-code="no-any-return"
"""Compiled loops that all controllers share: robots sorted by the cells of a grid, and each one's nearest neighbours.

A robot's state lies in arrays in the order of the grid's cells, row by row, and is kept in that order from step to
step: what stands side by side in the plane stands side by side in memory. ``name`` is the robot's number in the
fleet; results depend on it where distances tie and nowhere else, never on the order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free


@allocation_free
def cell_of(x: float, y: float, grid: Any) -> int:
    """Number of the cell with a place; places off the grid belong to the cell at its rim."""
    i = int((x - grid.x0) / grid.cell_m)
    j = int((y - grid.y0) / grid.cell_m)
    i = min(max(i, 0), grid.columns - 1)
    j = min(max(j, 0), grid.rows - 1)
    return (j + 1) * (grid.columns + 2) + i + 1


@allocation_free
def move(begin: int, end: int, robots: Any, decided: Any, time_step_s: float) -> float:
    """Write where the robots begin..end - 1 are after one time step into ``decided``, which has their new velocities.

    They keep their order. Returns the longest way of any of them, squared.
    """
    farthest2 = 0.0
    for k in range(begin, end):
        dx, dy = decided.vx[k] * time_step_s, decided.vy[k] * time_step_s
        decided.x[k], decided.y[k] = robots.x[k] + dx, robots.y[k] + dy
        farthest2 = max(farthest2, dx * dx + dy * dy)
    return farthest2


@allocation_free
def move_and_sort(robots: Any, moved: Any, grid: Any, cell: Any, time_step_s: float) -> float:
    """Move each robot for one time step, and write all in the order of their new cells.

    robots: the state before; moved: the state afterwards. cell: (n,) room. grid.start is
    filled anew. Returns the longest way of any robot, squared.
    """
    n, start = robots.x.shape[0], grid.start
    for c in range(start.shape[0]):
        start[c] = 0
    farthest2 = 0.0
    for k in range(n):
        dx, dy = robots.vx[k] * time_step_s, robots.vy[k] * time_step_s
        c = cell_of(robots.x[k] + dx, robots.y[k] + dy, grid)
        cell[k] = c
        start[c + 1] += 1
        farthest2 = max(farthest2, dx * dx + dy * dy)
    for c in range(1, start.shape[0]):
        start[c] += start[c - 1]
    for k in range(n):
        place = start[cell[k]]
        start[cell[k]] = place + 1
        moved.x[place] = robots.x[k] + robots.vx[k] * time_step_s
        moved.y[place] = robots.y[k] + robots.vy[k] * time_step_s
        moved.vx[place] = robots.vx[k]
        moved.vy[place] = robots.vy[k]
        moved.kind[place] = robots.kind[k]
        moved.name[place] = robots.name[k]
    for c in range(start.shape[0] - 1, 0, -1):  # each start has gone on to its cell's end
        start[c] = start[c - 1]
    start[0] = 0
    return farthest2


@allocation_free
def comes_before(distance2: float, name: int, k: int, near: Any, names: Any) -> bool:
    """Whether a robot comes before the k-th neighbour: it is nearer, or as near with a smaller number in the fleet."""
    if distance2 != near.distance2[k]:
        return distance2 < near.distance2[k]
    return name < names[near.robot[k]]


@allocation_free
def find_neighbours(i: int, most: int, robots: Any, grid: Any, range_m: float, near: Any) -> tuple[int, float]:
    """Fill ``near`` with the ``most`` nearest robots within range_m of robot i, nearest first.

    range_m: no more than a cell's side. Returns how many there are, and the squared distance in square metres of the
    nearest robot in the cells round about (inf: none).
    """
    x, y = robots.x[i], robots.y[i]
    range2 = range_m * range_m
    count, nearest2, stride = 0, np.inf, grid.columns + 2
    below = cell_of(x, y, grid) - stride
    for row in range(3):
        c = below + row * stride
        for j in range(grid.start[c - 1], grid.start[c + 2]):
            dx, dy = robots.x[j] - x, robots.y[j] - y
            distance2 = dx * dx + dy * dy
            if j == i or (distance2 > range2 and distance2 >= nearest2):
                continue
            nearest2 = min(nearest2, distance2)
            if distance2 > range2 or robots.kind[j] >= robots.member_kinds:
                continue
            if count == most:
                if most == 0 or not comes_before(distance2, robots.name[j], most - 1, near, robots.name):
                    continue
                k = most - 1
            else:
                k = count
                count += 1
            while k > 0 and comes_before(distance2, robots.name[j], k - 1, near, robots.name):
                near.robot[k] = near.robot[k - 1]
                near.distance2[k] = near.distance2[k - 1]
                k -= 1
            near.robot[k] = j
            near.distance2[k] = distance2
    return count, nearest2


@allocation_free
def to_wall(x: float, y: float, wall: Any) -> tuple[float, float]:
    """The vector from (x, y) to the nearest point of a segment."""
    ax, ay = wall[0] - x, wall[1] - y
    dx, dy = wall[2] - wall[0], wall[3] - wall[1]
    length2 = dx * dx + dy * dy
    if length2 <= 0.0:
        return ax, ay
    along = min(max(-(ax * dx + ay * dy) / length2, 0.0), 1.0)
    return ax + along * dx, ay + along * dy


@allocation_free
def walls_of_cells(grid: Any, within_m: float, filling: bool) -> int:
    """List, cell by cell, the walls within within_m of any place of the cell; without ``filling`` only count them.

    Counting writes the number for cell c to wall_start[c + 1]. Filling needs the sums of these there, and moves each to
    its cell's end. Returns how many entries there are.
    """
    total, reach = 0, within_m + 0.7072 * grid.cell_m
    for w in range(grid.walls.shape[0]):
        wall = grid.walls[w]
        i0 = int((min(wall[0], wall[2]) - within_m - grid.x0) / grid.cell_m) - 1
        i1 = int((max(wall[0], wall[2]) + within_m - grid.x0) / grid.cell_m) + 1
        j0 = int((min(wall[1], wall[3]) - within_m - grid.y0) / grid.cell_m) - 1
        j1 = int((max(wall[1], wall[3]) + within_m - grid.y0) / grid.cell_m) + 1
        for j in range(max(j0, 0), min(j1, grid.rows - 1) + 1):
            for i in range(max(i0, 0), min(i1, grid.columns - 1) + 1):
                dx, dy = to_wall(grid.x0 + (i + 0.5) * grid.cell_m, grid.y0 + (j + 0.5) * grid.cell_m, wall)
                if dx * dx + dy * dy > reach * reach:
                    continue
                c = (j + 1) * (grid.columns + 2) + i + 1
                if filling:
                    grid.wall_item[grid.wall_start[c]] = w
                    grid.wall_start[c] += 1
                else:
                    grid.wall_start[c + 1] += 1
                total += 1
    return total

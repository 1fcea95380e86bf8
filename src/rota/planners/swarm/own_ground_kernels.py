# mypy: disable-error-code="no-any-return"
"""Compiled shares of the ground in a robot's range that it has to itself."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.importance_kernels import importance_in_disc, matters
from rota.planners.swarm.kernels import cell_of, to_wall
from rota.planners.swarm.velocity_set_kernels import cut, is_cut, square_round

WALL_FADE = 0.1  # of the sensor's radius, over which a wall in range comes to count in full


@allocation_free
def area_in_disc(outline: Any, corners: int, radius: float) -> float:
    """Area of a convex polygon that holds the origin, as far as it lies in the disc of a radius round the origin."""
    twice, r2 = 0.0, radius * radius
    px, py = outline.x[corners - 1], outline.y[corners - 1]
    for k in range(corners):
        qx, qy = outline.x[k], outline.y[k]
        dx, dy = qx - px, qy - py
        a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - r2
        root, t0, t1 = b * b - a * c, 0.0, 0.0
        if a > 0.0 and root > 0.0:
            root = math.sqrt(root)
            t0, t1 = min(max((-b - root) / a, 0.0), 1.0), min(max((-b + root) / a, 0.0), 1.0)
        # the side from t0 to t1 lies in the disc: a sector up to it, a triangle over it, a sector after it
        ux, uy, wx, wy = px + t0 * dx, py + t0 * dy, px + t1 * dx, py + t1 * dy
        twice += ux * wy - uy * wx
        twice += r2 * math.atan2(px * uy - py * ux, px * ux + py * uy) if t0 > 0.0 else 0.0
        twice += r2 * math.atan2(wx * qy - wy * qx, wx * qx + wy * qy) if t1 < 1.0 else 0.0
        px, py = qx, qy
    return 0.5 * twice


@allocation_free
def worth_in_disc(x: float, y: float, outline: Any, corners: int, radius: float, grid: Any) -> float:
    """Area of a convex polygon's part in the disc of a radius, both round (x, y); its importance where that differs."""
    if matters(grid):
        return importance_in_disc(x, y, outline, corners, radius, grid.importance)[0]
    return area_in_disc(outline, corners, radius)


@allocation_free
def own_share(i: int, neighbours: int, robots: Any, kinds: Any, grid: Any, room: Any) -> tuple[float, float, float]:
    """The share of its disc's ground that robot i has to itself, by the power diagram, and how much walls are in range.

    Both are 0..1. The third is what there is in the disc, in square metres or their importance; shares are of that. A
    wall leaves the ground on this side of its nearest point, as in ``decide_voronoi``. What walls change sets in
    gradually: a robot that a wall pushed out of its range at once would come back, for ever. room.near: ``neighbours``
    robots, by ``find_neighbours``.
    """
    near, outline, spare = room
    x, y, sensor = robots.x[i], robots.y[i], kinds.sensor_m[robots.kind[i]]
    corners, walled = square_round(sensor, outline), 0.0
    c = cell_of(x, y, grid)
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
        distance = math.sqrt(dx * dx + dy * dy)
        if distance >= sensor:
            continue
        walled = max(walled, min((sensor - distance) / (WALL_FADE * sensor), 1.0))
        if distance > 1e-12 and is_cut(outline, corners, dx / distance, dy / distance, distance):
            corners = cut(outline, corners, dx / distance, dy / distance, distance, spare)
            outline, spare = spare, outline
    whole = worth_in_disc(x, y, outline, corners, sensor, grid) if corners > 0 else 0.0
    if whole <= 0.0:
        return 1.0, walled, 0.0
    for k in range(neighbours):
        j = near.robot[k]
        distance, other = math.sqrt(near.distance2[k]), kinds.sensor_m[robots.kind[j]]
        if distance <= 1e-9:
            continue
        ex, ey = (robots.x[j] - x) / distance, (robots.y[j] - y) / distance
        bound = 0.5 * (distance + (sensor * sensor - other * other) / distance)
        if bound <= 0.0:
            return 0.0, walled, whole
        if is_cut(outline, corners, ex, ey, bound):
            corners = cut(outline, corners, ex, ey, bound, spare)
            outline, spare = spare, outline
            if corners == 0:
                return 0.0, walled, whole
    return worth_in_disc(x, y, outline, corners, sensor, grid) / whole, walled, whole

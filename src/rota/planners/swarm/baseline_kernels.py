"""Compiled decisions of the methods that Chen et al. 2018 compare with: range-limited Voronoi cells, virtual forces."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.importance_kernels import importance_in_disc, matters
from rota.planners.swarm.kernels import cell_of, find_neighbours, to_wall
from rota.planners.swarm.velocity_set_kernels import centroid_in_disc, cut, is_cut, square_round

SAME_PLACE_M2 = 1e-24
OVER_RELAXATION = 1.6  # of the way to the centroid; below 2 Lloyd's method still converges, and faster
# share of each overlap that a robot takes away in a step: the largest by which no run of 25 robots, with an obstacle or
# without one, turns back in 1 % of its steps (docs/chen2018.md, Figure 18)
STIFFNESS = 0.25
FULL_SHARE_CAUSES = 8.0  # with more overlaps than that the share is less, since it would overshoot


@allocation_free
def towards(dx: float, dy: float, speed: float, time_s: float) -> tuple[float, float]:
    """The velocity (vx, vy) in m/s that leads by (dx, dy) metres in time_s, or as far as the speed allows."""
    length = math.sqrt(dx * dx + dy * dy)
    scale = 1.0 / time_s if length <= speed * time_s else speed / length
    return dx * scale, dy * scale


@allocation_free
def centroid_of_worth(x: float, y: float, outline: Any, corners: int, sensor: float, grid: Any) -> tuple[float, float]:
    """The centroid of a polygon's part in the disc round (x, y), from there; of its importance where that differs."""
    if not matters(grid):
        _, cx, cy = centroid_in_disc(outline, corners, sensor)
        return cx, cy
    whole, mx, my = importance_in_disc(x, y, outline, corners, sensor, grid.importance)
    return (mx / whole, my / whole) if whole > 0.0 else (0.0, 0.0)


@allocation_free
def decide_voronoi(begin: int, end: int, snapshot: Any, decisions: Any, room: Any) -> None:
    """Decide by Lloyd's step, over-relaxed: a robot makes for the centroid of its Voronoi cell in its sensor's disc.

    Where ground differs in importance, it is the centroid of that (Cortes et al. 2004, Section III). The
    ``rule.neighbours`` nearest robots bound a cell, and so do the nearest points of walls in sensor range. Where
    sensors differ, cells are those of the power diagram: the border runs where both discs have the same power. Decides
    for the robots begin..end - 1 of a ``Snapshot``, into ``Decisions``. room: of one thread.
    """
    robots, kinds, grid, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule
    near, outline, spare = room
    for i in range(begin, end):
        kind = robots.kind[i]
        x, y, sensor = robots.x[i], robots.y[i], kinds.sensor_m[kind]
        range_m = kinds.neighbour_range_m[kind]
        neighbours, decisions.nearest2[i] = find_neighbours(i, rule.neighbours, robots, grid, range_m, near)
        corners = square_round(sensor, outline)
        for k in range(neighbours):
            if corners == 0 or near.distance2[k] < SAME_PLACE_M2:
                continue
            j = near.robot[k]
            distance, other = math.sqrt(near.distance2[k]), kinds.sensor_m[robots.kind[j]]
            ex, ey = (robots.x[j] - x) / distance, (robots.y[j] - y) / distance
            bound = 0.5 * (distance + (sensor * sensor - other * other) / distance)
            if is_cut(outline, corners, ex, ey, bound):
                corners = cut(outline, corners, ex, ey, bound, spare)
                outline, spare = spare, outline
        c = cell_of(x, y, grid)
        for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
            dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
            distance = math.sqrt(dx * dx + dy * dy)
            if corners == 0 or distance <= 1e-12 or distance >= sensor:
                continue
            if is_cut(outline, corners, dx / distance, dy / distance, distance):
                corners = cut(outline, corners, dx / distance, dy / distance, distance, spare)
                outline, spare = spare, outline
        decisions.vx[i], decisions.vy[i] = 0.0, 0.0
        if corners > 0:
            cx, cy = centroid_of_worth(x, y, outline, corners, sensor, grid)
            cx, cy = OVER_RELAXATION * cx, OVER_RELAXATION * cy
            decisions.vx[i], decisions.vy[i] = towards(cx, cy, kinds.speed_m_s[kind], rule.time_step_s)


@allocation_free
def overlaps_with_robots(
    i: int, neighbours: int, last_m: float, robots: Any, kinds: Any, near: Any
) -> tuple[float, float, float]:
    """The sum of the overlaps of robot i's sensor with its neighbours' sensors, and how many overlap.

    The sum is a vector in metres; each overlap points away from its neighbour. near: the neighbours, by
    ``find_neighbours``. last_m: sensors reach no farther than that, where it is the last neighbour's distance. So
    nothing jumps where another robot becomes the last one that counts: such jumps drove crowds to and fro for ever.
    """
    x, y, sensor = robots.x[i], robots.y[i], kinds.sensor_m[robots.kind[i]]
    fx, fy, causes = 0.0, 0.0, 0.0
    for k in range(neighbours):
        j = near.robot[k]
        distance = math.sqrt(near.distance2[k])
        overlap = min(sensor + kinds.sensor_m[robots.kind[j]], last_m) - distance
        if overlap > 0.0 and distance > 0.0:
            fx -= overlap * (robots.x[j] - x) / distance
            fy -= overlap * (robots.y[j] - y) / distance
            causes += 1.0
    return fx, fy, causes


@allocation_free
def sum_of_overlaps(
    i: int, most: int, robots: Any, kinds: Any, grid: Any, nearest2: Any, near: Any
) -> tuple[float, float, float]:
    """The sum of the overlaps of robot i's sensor with other sensors and walls, and the number of causes.

    The sum is a vector in metres; each overlap points away from its cause. A wall in sensor range counts twice, since
    it does not give way itself. Of robots the ``most`` nearest count. nearest2: (n,) takes the squared distance of the
    nearest.
    """
    kind = robots.kind[i]
    x, y, sensor = robots.x[i], robots.y[i], kinds.sensor_m[kind]
    neighbours, nearest2[i] = find_neighbours(i, most, robots, grid, kinds.neighbour_range_m[kind], near)
    fx, fy, causes = overlaps_with_robots(i, neighbours, math.inf, robots, kinds, near)
    c = cell_of(x, y, grid)
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
        distance = math.sqrt(dx * dx + dy * dy)
        if distance < sensor and distance > 0.0:
            fx -= 2.0 * (sensor - distance) * dx / distance
            fy -= 2.0 * (sensor - distance) * dy / distance
            causes += 2.0
    return fx, fy, causes


def virtual_force(stiffness: float) -> Any:
    """A compiled controller by virtual forces that take away the share ``stiffness`` of each overlap in a step.

    Robots whose sensors overlap push each other, and walls in sensor range push, each by the overlap. The share shrinks
    where very many push.
    """

    @allocation_free
    def decide_virtual_force(begin: int, end: int, snapshot: Any, decisions: Any, room: Any) -> None:
        """New velocities of the robots begin..end - 1 of a ``Snapshot``, into ``Decisions``; room: of one thread."""
        robots, kinds, grid, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule
        for i in range(begin, end):
            fx, fy, causes = sum_of_overlaps(i, rule.neighbours, robots, kinds, grid, decisions.nearest2, room.near)
            gain = stiffness * FULL_SHARE_CAUSES / max(FULL_SHARE_CAUSES, causes)
            speed = kinds.speed_m_s[robots.kind[i]]
            decisions.vx[i], decisions.vy[i] = towards(gain * fx, gain * fy, speed, rule.time_step_s)

    return decide_virtual_force


decide_virtual_force = virtual_force(STIFFNESS)

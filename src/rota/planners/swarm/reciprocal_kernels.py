# mypy: disable-error-code="no-any-return"
"""Compiled decision of the reciprocal controller: Chen et al., Sensors 18(6):1864, 2018, Eqs. 1-15, Algorithms 1-2."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.kernels import cell_of, find_neighbours, to_wall
from rota.planners.swarm.velocity_set_kernels import centroid_in_disc, cut, is_cut, square_round

SAME_PLACE_M2 = 1e-24
INCREMENT = np.uint64(0x9E3779B97F4A7C15)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


@allocation_free
def mix(state: Any) -> Any:
    """A number in which every bit depends on every bit of the state (the finaliser of splitmix64)."""
    state = (state ^ (state >> np.uint64(30))) * FIRST
    state = (state ^ (state >> np.uint64(27))) * SECOND
    return state ^ (state >> np.uint64(31))


@allocation_free
def sample_key(seed: int, name: int, step: int) -> Any:
    """Where the random numbers of one robot in one step begin."""
    key = mix(np.uint64(seed) + INCREMENT)
    key = mix(key ^ (np.uint64(name) * INCREMENT + INCREMENT))
    return mix(key ^ (np.uint64(step) * INCREMENT + INCREMENT))


@allocation_free
def sampled_mean(key: Any, samples: int, speed: float, outline: Any, corners: int) -> tuple[bool, float, float]:
    """Algorithm 1: the mean of random velocities of the square round the disc that lie in the set; False: of none.

    A point lies in a convex polygon when it lies to the left of all its sides.
    """
    inside, sum_x, sum_y = 0, 0.0, 0.0
    scale = 2.0 * speed / 4294967296.0
    for k in range(samples):
        bits = mix(key + np.uint64(k + 1) * INCREMENT)
        x = scale * (np.float64(bits >> np.uint64(32)) + 0.5) - speed
        y = scale * (np.float64(bits & np.uint64(0xFFFFFFFF)) + 0.5) - speed
        if x * x + y * y > speed * speed:
            continue
        ok = corners > 2
        px, py = outline.x[corners - 1], outline.y[corners - 1]
        for c in range(corners):
            qx, qy = outline.x[c], outline.y[c]
            if (qx - px) * (y - py) - (qy - py) * (x - px) < 0.0:
                ok = False
                break
            px, py = qx, qy
        if ok:
            inside += 1
            sum_x += x
            sum_y += y
    if inside == 0:
        return False, 0.0, 0.0
    return True, sum_x / inside, sum_y / inside


@allocation_free
def half_plane(
    dx: float, dy: float, distance: float, own: Any, other: Any, share: float, rule: Any
) -> tuple[float, float, float]:
    """The velocities that do not weaken the coverage towards (dx, dy): Eqs. 2, 6-8, 14, 15, as e and b of v . e <= b.

    own, other: velocities (vx, vy) in m/s. share: of the smallest change u of the relative velocity that the robot
    makes itself (a half with a robot, 1 with a wall, alpha with what moves and does not give way).
    """
    vx, vy = own
    ex, ey = dx / distance, dy / distance
    rx, ry = vx - other[0], vy - other[1]
    if not rule.circle:  # the tangent line: u leads along e on to the line through the origin, from either side
        return ex, ey, vx * ex + vy * ey - share * (rx * ex + ry * ey)
    radius = distance / rule.horizon_s
    qx, qy = rx - radius * ex, ry - radius * ey
    away = math.sqrt(qx * qx + qy * qy)
    if away > 0.0:
        nx, ny = qx / away, qy / away
    else:
        nx, ny = -ex, -ey
    u = radius - away
    return -nx, -ny, -((vx + share * u * nx) * nx + (vy + share * u * ny) * ny)


@allocation_free
def decide_reciprocal(begin: int, end: int, snapshot: Any, decisions: Any, room: Any) -> None:
    """New velocities of the robots begin..end - 1 from one ``Snapshot`` into ``Decisions`` (Eqs. 9 and 10).

    room: of one thread. An empty set gives velocity 0 (Algorithm 2).
    """
    robots, kinds, grid, moving, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.moving, snapshot.rule
    near, outline, spare = room
    for i in range(begin, end):
        kind = robots.kind[i]
        x, y, vx, vy = robots.x[i], robots.y[i], robots.vx[i], robots.vy[i]
        speed = kinds.speed_m_s[kind]
        range_m = kinds.neighbour_range_m[kind]
        neighbours, decisions.nearest2[i] = find_neighbours(i, rule.neighbours, robots, grid, range_m, near)
        corners = square_round(speed, outline)
        for k in range(neighbours):
            if corners == 0 or near.distance2[k] < SAME_PLACE_M2:
                continue
            j = near.robot[k]
            dx, dy, other = robots.x[j] - x, robots.y[j] - y, (robots.vx[j], robots.vy[j])
            ex, ey, bound = half_plane(dx, dy, math.sqrt(near.distance2[k]), (vx, vy), other, 0.5, rule)
            if is_cut(outline, corners, ex, ey, bound):
                corners = cut(outline, corners, ex, ey, bound, spare)
                outline, spare = spare, outline
        c = cell_of(x, y, grid)
        range_m = kinds.wall_range_m[kind]
        for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
            dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
            distance2 = dx * dx + dy * dy
            if corners == 0 or distance2 < SAME_PLACE_M2 or distance2 >= range_m * range_m:
                continue
            ex, ey, bound = half_plane(dx, dy, math.sqrt(distance2), (vx, vy), (0.0, 0.0), 1.0, rule)
            if is_cut(outline, corners, ex, ey, bound):
                corners = cut(outline, corners, ex, ey, bound, spare)
                outline, spare = spare, outline
        for m in range(moving.x.shape[0]):
            dx, dy = moving.x[m] - x, moving.y[m] - y
            distance = math.sqrt(dx * dx + dy * dy)
            if corners == 0 or distance <= 1e-12 or distance - moving.radius_m[m] >= range_m:
                continue
            ex, ey, bound = half_plane(dx, dy, distance, (vx, vy), (moving.vx[m], moving.vy[m]), rule.alpha, rule)
            if is_cut(outline, corners, ex, ey, bound):
                corners = cut(outline, corners, ex, ey, bound, spare)
                outline, spare = spare, outline
        ok = corners > 0
        if ok and rule.samples > 0:
            key = sample_key(rule.seed, robots.name[i], snapshot.step)
            ok, cx, cy = sampled_mean(key, rule.samples, speed, outline, corners)
        elif ok:
            ok, cx, cy = centroid_in_disc(outline, corners, speed)
        decisions.vx[i] = cx if ok else 0.0
        decisions.vy[i] = cy if ok else 0.0

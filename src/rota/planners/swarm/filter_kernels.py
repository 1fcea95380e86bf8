# mypy: disable-error-code="no-any-return"
"""Compiled last filter: the velocity nearest to the one wished for with which no body can touch another or a wall.

For every robot B within r_A + r_B + (v_A + v_B) dt, e the unit vector towards it: v . e <= (distance - r_A - r_B) /
(2 dt); for every wall, n towards its nearest point: v . n <= (distance - r_A) / dt. Each of two robots takes at most
half of what lies between them, so they stay apart at every moment of the step, whatever the other does. Velocity 0 is
always allowed.

A robot that is known from an old message only may have gone s = age v_B dt since: it is somewhere in the disc of
radius s round the place told. Let d be the distance to that place and D >= d - s the true one, u the true direction. If
v . u <= (d - s - r_A - r_B) / (2 dt) for every u that leads into the disc, then v . u <= (D - r_A - r_B) / (2 dt) for
the true one; the other robot, with its own old message and its own bound below D, does the same against -u, so along u
the two together take no more than lies between them. For s < d the directions are a cone of half-angle p = asin(s / d)
round e. Each u in it at an angle 0 <= a <= p from e is (sin(p - a) e + sin(a) e_p) / sin(p), e_p the edge of the cone,
and the two factors add up to cos(a - p / 2) / cos(p / 2) <= 1 / cos(p / 2): three half-planes, towards e and both
edges, with the bound times cos(p / 2), imply all the others. For s >= d the other robot may be on any side: only
velocity 0 is left, which all bounds, being 0 or more, always allow. Robots with d - s - r_A - r_B beyond the sum of
both longest steps cannot meet in this one.
"""

from __future__ import annotations

import math
from typing import Any

from rota.planners.swarm.kernels import cell_of, compiled, to_wall
from rota.planners.swarm.velocity_set_kernels import cut, is_cut, nearest_in, square_round

ROUNDING_M = 1e-9  # kept between bodies, so that rounding of places never makes them touch


@compiled
def room(gap_m: float, time_s: float) -> float:
    """Greatest speed towards what is gap_m away; 0 for what touches already."""
    return max(gap_m - ROUNDING_M, 0.0) / time_s


@compiled
def scaled(vx: float, vy: float, ex: float, ey: float, bound: float) -> float:
    """Largest share of a velocity, up to 1, that keeps v . e <= bound; bound >= 0."""
    towards = vx * ex + vy * ey
    return bound / towards if towards > bound else 1.0


@compiled
def cone(distance: float, spread_m: float) -> tuple[float, float, float]:
    """Cosine and sine of half the angle of the disc of radius spread_m < distance, and the cosine of half of that."""
    sine = spread_m / distance
    cosine = math.sqrt(1.0 - sine * sine)
    return cosine, sine, math.sqrt(0.5 + 0.5 * cosine)


@compiled
def wall_normal(dx: float, dy: float, distance: float, wall: Any) -> tuple[float, float]:
    """Unit vector towards a wall's nearest point; across the wall for a robot that stands on it."""
    if distance > 1e-12:
        return dx / distance, dy / distance
    ax, ay = wall[2] - wall[0], wall[3] - wall[1]
    length = math.sqrt(ax * ax + ay * ay)
    return (ay / length, -ax / length) if length > 0.0 else (0.0, 0.0)


@compiled
def filter_velocities(
    begin: int, end: int, robots: Any, kinds: Any, grid: Any, moving: Any, time_step_s: float, widest_m: float,
    spread_m: Any, new_vx: Any, new_vy: Any, nearest2: Any, outline: Any, spare: Any,
) -> None:  # fmt: skip
    """Replace the velocities of robots begin..end - 1 by the nearest safe ones.

    nearest2: (n,) squared distance of the nearest robot, so that most robots need no second look. widest_m: the largest
    body plus the longest step of any robot. spread_m: how far each robot may have gone from its place, (n,), or (0,)
    where places are exact. Discs that move are kept clear of as far as they leave a choice.
    """
    for i in range(begin, end):
        vx, vy = new_vx[i], new_vy[i]
        if vx == 0.0 and vy == 0.0:
            continue
        kind, x, y = robots.kind[i], robots.x[i], robots.y[i]
        body, step_m = kinds.body_m[kind], kinds.speed_m_s[kind] * time_step_s
        c = cell_of(x, y, grid)
        reach = body + step_m + widest_m
        crowded = nearest2[i] <= reach * reach
        if not crowded and grid.wall_start[c] == grid.wall_start[c + 1] and moving.x.shape[0] == 0:
            continue
        # first the nearest velocity that all half-planes allow, which glides along what is in the way; the polygon
        # has room for many of them. Then the share of it that really all allow, which rounding cannot harm
        corners = square_round(2.0 * kinds.speed_m_s[kind], outline)
        stride = grid.columns + 2
        for pass_number in range(2):
            share = 1.0
            if crowded:
                for row in range(3):
                    first = c + (row - 1) * stride
                    for j in range(grid.start[first - 1], grid.start[first + 2]):
                        dx, dy = robots.x[j] - x, robots.y[j] - y
                        distance = math.sqrt(dx * dx + dy * dy)
                        bodies = body + kinds.body_m[robots.kind[j]]
                        unsure_m = spread_m[j] if spread_m.shape[0] > 0 else 0.0
                        within = bodies + unsure_m + step_m + kinds.speed_m_s[robots.kind[j]] * time_step_s
                        if j == i or distance > within:
                            continue
                        bound = room(distance - unsure_m - bodies, 2.0 * time_step_s)
                        ex, ey = (dx / distance, dy / distance) if distance > 0.0 else (0.0, 0.0)
                        if unsure_m > 0.0:
                            if unsure_m >= distance:
                                share, corners = 0.0, 0
                                continue
                            along, across, narrower = cone(distance, unsure_m)
                            bound *= narrower
                            for side in (-across, across):
                                ax, ay = along * ex - side * ey, along * ey + side * ex
                                share = min(share, scaled(vx, vy, ax, ay, bound))
                                if pass_number == 0 and corners > 0 and is_cut(outline, corners, ax, ay, bound):
                                    corners = cut(outline, corners, ax, ay, bound, spare)
                                    outline, spare = spare, outline
                        share = min(share, scaled(vx, vy, ex, ey, bound))
                        if pass_number == 0 and corners > 0 and is_cut(outline, corners, ex, ey, bound):
                            corners = cut(outline, corners, ex, ey, bound, spare)
                            outline, spare = spare, outline
            for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
                wall = grid.walls[grid.wall_item[item]]
                dx, dy = to_wall(x, y, wall)
                distance = math.sqrt(dx * dx + dy * dy)
                if distance > body + step_m:
                    continue
                bound = room(distance - body, time_step_s)
                ex, ey = wall_normal(dx, dy, distance, wall)
                share = min(share, scaled(vx, vy, ex, ey, bound))
                if distance <= 1e-12:
                    share = min(share, scaled(vx, vy, -ex, -ey, bound))
                if pass_number == 0 and is_cut(outline, corners, ex, ey, bound):
                    corners = cut(outline, corners, ex, ey, bound, spare)
                    outline, spare = spare, outline
            for m in range(moving.x.shape[0]):
                dx, dy = moving.x[m] - x, moving.y[m] - y
                distance = math.sqrt(dx * dx + dy * dy)
                gap = distance - body - moving.radius_m[m]
                ex, ey = (dx / distance, dy / distance) if distance > 0.0 else (0.0, 0.0)
                approach = moving.vx[m] * ex + moving.vy[m] * ey
                bound = max((gap - ROUNDING_M) / time_step_s + approach, 0.0)
                share = min(share, scaled(vx, vy, ex, ey, bound))
                if pass_number == 0 and is_cut(outline, corners, ex, ey, bound):
                    corners = cut(outline, corners, ex, ey, bound, spare)
                    outline, spare = spare, outline
            if pass_number == 1:
                vx, vy = share * vx, share * vy
            elif share >= 1.0:
                break
            elif corners > 0:
                vx, vy = nearest_in(outline, corners, vx, vy)
            else:
                vx, vy = 0.0, 0.0
        new_vx[i], new_vy[i] = vx, vy

# mypy: disable-error-code="no-any-return"
"""Compiled last filter: a velocity near the one wished for with which no body can touch another or a wall.

Bounds. For every robot B within r_A + r_B + (v_A + v_B) dt, e the unit vector towards it: v . e <= (distance - r_A -
r_B) / (2 dt); for every wall, n towards its nearest point: v . n <= (distance - r_A) / dt. Robots and walls farther
away are out of reach of this step. A bound is 0 for what touches already, and never below: the velocities that are
allowed are a convex set K that holds 0, and any share s v, 0 <= s <= 1, of one of them is one of them.

Claim. Let bodies be apart, or touch, and speeds wished for be at most v_max. Then at every moment of the step

1. every robot drives at v_max or less: the result is never longer than the wish;
2. every body is clear of every wall: the wall lies in the half-plane p . n >= distance, since n leads to its nearest
   point and a segment is convex, and t seconds after the step's beginning, t <= dt, the robot has gone no more than
   t v . n <= distance - r_A towards it;
3. every two bodies are clear of each other, whatever the other robot does within its own bounds: along e the two come
   nearer by no more than half of the gap each.

The proof does not lean on the search for the nearest velocity. What the search finds, and the wish, are two candidates
c; the largest share s is taken with s c . e <= b for all half-planes, which the compiled code compares one by one, and
of the two results the one nearer to the wish. A candidate longer than the wish is not taken. So rounding may cost a
robot some way, and never safety.

The search. If the wish w is not in K, the point v of K nearest to it lies on the line of a half-plane that w violates:
w - v is a sum of the e of lines through v, with factors >= 0, so w . e > b = v . e for one of them. On each such line K
leaves an interval, and the nearest point of the interval is a candidate. With b = 0 the line runs through the origin,
which all the others allow, so that the interval holds 0 in floating point too; its nearest point is then no longer than
the wish. Where bodies touch exactly, in lattices and in rows along walls, all bounds are 0.

Rounding. A gap of g metres counts as g - 1e-9, and as 0 below that. Distances and directions of places no farther than
1e6 m from the origin err by less than 1e-9 m, so bodies that are 1e-9 m apart stay apart. For bodies that touch, v . e
may exceed 0 by ROUNDING |w|, without which a robot could not glide along what it touches: bodies may come nearer by
ROUNDING of a step's way, 1e-15 m for 0.5 m, and by what places round in every step anyway.

Discs that move and do not give way are dodged beforehand: the wish is changed (``dodge_kernels``), and the claim holds
of what is left of it. Where a disc would be met by that, the robot takes the way out that keeps farthest off, as far
as all half-planes allow (``fled``). That no disc is met is not claimed.

Old news. A robot that is known from an old message only may have gone up to s since, no more than age v_B dt and less
where it told of going slowly (``delayed_news_kernels.gone_m``): it is somewhere in the disc of radius s round the place
told. Let d be the distance to that place and D >= d - s the true one, u the true direction.
If v . u <= (d - s - r_A - r_B) / (2 dt) for every u that leads into the disc, then v . u <= (D - r_A - r_B) / (2 dt)
for the true one; the other robot, with its own old message and its own bound below D, does the same against -u, so
along u the two together take no more than lies between them. For s < d the directions are a cone of half-angle p =
asin(s / d) round e. Each u in it at an angle 0 <= a <= p from e is (sin(p - a) e + sin(a) e_p) / sin(p), e_p the edge
of the cone, and the two factors add up to cos(a - p / 2) / cos(p / 2) <= 1 / cos(p / 2): three half-planes, towards e
and both edges, with the bound times cos(p / 2), imply all the others. For s >= d the other robot may be on any side:
only velocity 0 is left.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats
from rota.planners.swarm.dodge_kernels import CLEAR_M, clearance_m, dodge
from rota.planners.swarm.kernels import cell_of, to_wall

ROUNDING_M = 1e-9  # kept between bodies, so that rounding of places never makes them touch
WAYS_OUT, AHEAD_STEPS = 32, 2.0  # that a robot looks for when a disc would be met, and for how many steps
ROUNDING = 2e-15  # share of a velocity by which a half-plane may be exceeded: what rounding leaves of a point on a line


class HalfPlanes(NamedTuple):
    """Room for half-planes v . e <= bound: (m,) x and y of the unit vectors e, and the bounds in m/s."""

    x: Floats
    y: Floats
    bound: Floats


@allocation_free
def greatest_speed(gap_m: float, time_s: float) -> float:
    """Greatest speed in m/s towards something gap_m away; 0 where it touches already."""
    return max(gap_m - ROUNDING_M, 0.0) / time_s


@allocation_free
def cone(distance: float, spread_m: float) -> tuple[float, float, float]:
    """Cosine and sine of half the angle of the disc of radius spread_m < distance, and the cosine of half of that."""
    sine = spread_m / distance
    cosine = math.sqrt(1.0 - sine * sine)
    return cosine, sine, math.sqrt(0.5 + 0.5 * cosine)


@allocation_free
def wall_normal(dx: float, dy: float, distance: float, wall: Any) -> tuple[float, float]:
    """Unit vector towards a wall's nearest point, (dx, dy) away; across the wall for a robot that stands on it."""
    if distance > 1e-12:
        return dx / distance, dy / distance
    ax, ay = wall[2] - wall[0], wall[3] - wall[1]
    length = math.sqrt(ax * ax + ay * ay)
    return (ay / length, -ax / length) if length > 0.0 else (0.0, 0.0)


@allocation_free
def add_half_plane(ex: float, ey: float, bound: float, count: int, longest: float, planes: Any) -> tuple[int, float]:
    """Note the half-plane v . e <= bound; returns how many there are, and the greatest length safe without more.

    No velocity longer than ``longest`` is asked for, so that a greater bound says nothing. Without room the loosest
    half-plane goes, and its bound becomes the greatest length: shorter velocities do not reach it.
    """
    if bound >= longest or (ex == 0.0 and ey == 0.0):
        return count, longest
    k, bounds = count, planes.bound
    if count == bounds.shape[0]:
        k = 0
        for other in range(1, count):
            if bounds[other] > bounds[k]:
                k = other
        if bounds[k] <= bound:
            return count, bound
        longest = bounds[k]
    planes.x[k], planes.y[k], bounds[k] = ex, ey, bound
    return max(count, k + 1), longest


@allocation_free
def bound_by_robots(i: int, c: int, snapshot: Any, spread_m: Any, longest: float, planes: Any) -> tuple[int, float]:
    """Note the half-planes of the robots round robot i, which is in cell c; returns their number, the greatest length.

    Both are as ``add_half_plane`` returns them. spread_m: as ``filter_velocities`` takes it.
    """
    robots, kinds, grid, time_step_s = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule.time_step_s
    kind, x, y, count = robots.kind[i], robots.x[i], robots.y[i], 0
    body, step_m = kinds.body_m[kind], kinds.speed_m_s[kind] * time_step_s
    stride = grid.columns + 2
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
            if unsure_m > 0.0 and unsure_m >= distance:
                return 0, 0.0
            bound = greatest_speed(distance - unsure_m - bodies, 2.0 * time_step_s)
            ex, ey = (dx / distance, dy / distance) if distance > 0.0 else (0.0, 0.0)
            if unsure_m > 0.0:
                along, across, narrower = cone(distance, unsure_m)
                bound *= narrower
                for side in (-across, across):
                    ax, ay = along * ex - side * ey, along * ey + side * ex
                    count, longest = add_half_plane(ax, ay, bound, count, longest, planes)
            count, longest = add_half_plane(ex, ey, bound, count, longest, planes)
    return count, longest


@allocation_free
def bound_by_walls(i: int, c: int, snapshot: Any, count: int, longest: float, planes: Any) -> tuple[int, float]:
    """Add the half-planes of walls near cell c; a robot that stands on a wall may only go along it."""
    robots, kinds, grid, time_step_s = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule.time_step_s
    kind, x, y = robots.kind[i], robots.x[i], robots.y[i]
    body, step_m = kinds.body_m[kind], kinds.speed_m_s[kind] * time_step_s
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        wall = grid.walls[grid.wall_item[item]]
        dx, dy = to_wall(x, y, wall)
        distance = math.sqrt(dx * dx + dy * dy)
        if distance > body + step_m:
            continue
        bound = greatest_speed(distance - body, time_step_s)
        ex, ey = wall_normal(dx, dy, distance, wall)
        count, longest = add_half_plane(ex, ey, bound, count, longest, planes)
        if distance <= 1e-12:
            count, longest = add_half_plane(-ex, -ey, bound, count, longest, planes)
    return count, longest


@allocation_free
def bound_by_moving(i: int, snapshot: Any, count: int, longest: float, planes: Any) -> tuple[int, float]:
    """Add the half-planes of discs that move; the bound is 0 where a disc comes nearer than the robot can make way."""
    moving, time_step_s = snapshot.moving, snapshot.rule.time_step_s
    x, y, body = snapshot.robots.x[i], snapshot.robots.y[i], snapshot.kinds.body_m[snapshot.robots.kind[i]]
    for m in range(moving.x.shape[0]):
        dx, dy = moving.x[m] - x, moving.y[m] - y
        distance = math.sqrt(dx * dx + dy * dy)
        gap = distance - body - moving.radius_m[m]
        ex, ey = (dx / distance, dy / distance) if distance > 0.0 else (0.0, 0.0)
        approach = moving.vx[m] * ex + moving.vy[m] * ey
        bound = max((gap - ROUNDING_M) / time_step_s + approach, 0.0)
        count, longest = add_half_plane(ex, ey, bound, count, longest, planes)
    return count, longest


@allocation_free
def share_within(vx: float, vy: float, slack: float, count: int, planes: Any) -> float:
    """Largest share of a velocity, up to 1, that all half-planes allow, each with that slack."""
    share = 1.0
    for k in range(count):
        towards = vx * planes.x[k] + vy * planes.y[k]
        if towards > planes.bound[k] + slack:
            share = min(share, planes.bound[k] / towards)
    return share


@allocation_free
def nearest_on_lines(wx: float, wy: float, count: int, planes: Any) -> tuple[float, float]:
    """The point nearest to the wish on the lines it lies beyond, of all points that the other half-planes leave.

    (0, 0) where rounding leaves nothing of any line.
    """
    best2, bx, by = math.inf, 0.0, 0.0
    for k in range(count):
        ex, ey, bound = planes.x[k], planes.y[k], planes.bound[k]
        beyond = wx * ex + wy * ey - bound
        if beyond <= 0.0 or beyond * beyond >= best2:
            continue
        low, high = -math.inf, math.inf  # of the places b e + t (-e_y, e_x) on the line
        for other in range(count):
            along = planes.y[other] * ex - planes.x[other] * ey
            left = planes.bound[other] - bound * (planes.x[other] * ex + planes.y[other] * ey)
            if along > ROUNDING:
                high = min(high, left / along)
            elif along < -ROUNDING:
                low = max(low, left / along)
            elif left < -ROUNDING * bound:  # parallel, and the line lies beyond; its own does not
                high = -math.inf
        if low > high:
            continue
        wished = wy * ex - wx * ey
        t = min(max(wished, low), high)
        distance2 = beyond * beyond + (t - wished) * (t - wished)
        if distance2 < best2:
            best2, bx, by = distance2, bound * ex - t * ey, bound * ey + t * ex
    return bx, by


@allocation_free
def nearest_allowed(wx: float, wy: float, longest: float, count: int, planes: Any) -> tuple[float, float]:
    """The velocity in all half-planes that is nearest to the wish, no longer than ``longest`` and than the wish.

    Bounds are 0 or more. Whatever the search finds, the result is never longer than the wish, and it lies in all
    half-planes but for rounding; see above.
    """
    slack = ROUNDING * math.sqrt(wx * wx + wy * wy)
    share = share_within(wx, wy, slack, count, planes)
    rx, ry = share * wx, share * wy
    if share < 1.0:
        vx, vy = nearest_on_lines(wx, wy, count, planes)
        share = share_within(vx, vy, slack, count, planes)
        vx, vy = share * vx, share * vy
        nearer = (vx - wx) ** 2 + (vy - wy) ** 2 < (rx - wx) ** 2 + (ry - wy) ** 2
        if nearer and vx * vx + vy * vy <= wx * wx + wy * wy:
            rx, ry = vx, vy
    length = math.sqrt(rx * rx + ry * ry)
    if length > longest:
        rx, ry = rx * (longest / length), ry * (longest / length)
    return rx, ry


@allocation_free
def flee(i: int, c: int, vx: float, vy: float, snapshot: Any, spread_m: Any, planes: Any) -> tuple[float, float]:
    """The velocity (vx, vy) or, where a disc would be met by it, the safe one that keeps farthest off.

    Of ``WAYS_OUT`` directions each is tried at top speed, shortened as the half-planes of robots and walls ask. c: the
    cell that robot i is in. spread_m: as ``filter_velocities`` takes it.
    """
    robots, kinds, moving, time_step_s = snapshot.robots, snapshot.kinds, snapshot.moving, snapshot.rule.time_step_s
    x, y, body, ahead_s = robots.x[i], robots.y[i], kinds.body_m[robots.kind[i]], AHEAD_STEPS * time_step_s
    best_m = clearance_m(x, y, vx, vy, body, moving, ahead_s)
    if best_m >= CLEAR_M:
        return vx, vy
    bx, by, speed = vx, vy, kinds.speed_m_s[robots.kind[i]]
    count, longest = bound_by_robots(i, c, snapshot, spread_m, speed, planes)
    count, longest = bound_by_walls(i, c, snapshot, count, longest, planes)
    for k in range(WAYS_OUT):
        angle = 2.0 * math.pi * k / WAYS_OUT
        ux, uy = longest * math.cos(angle), longest * math.sin(angle)
        share = share_within(ux, uy, 0.0, count, planes)
        gap_m = clearance_m(x, y, share * ux, share * uy, body, moving, ahead_s)
        if gap_m > best_m:
            best_m, bx, by = gap_m, share * ux, share * uy
    return bx, by


@allocation_free
def filter_velocities(
    begin: int, end: int, snapshot: Any, widest_m: float, spread_m: Any, decisions: Any, room: Any
) -> None:
    """Replace the velocities decided for the robots begin..end - 1 of a ``Snapshot`` by the nearest safe ones.

    widest_m: the largest body plus the longest step of any robot. spread_m: how far each robot may have gone from its
    place, (n,) metres, or (0,) where places are exact. Discs that move are dodged, and kept clear of as far as they
    leave a choice. room: of one thread.
    """
    robots, kinds, grid, moving = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.moving
    time_step_s = snapshot.rule.time_step_s
    planes = HalfPlanes(room.outline.x, room.outline.y, room.spare.x)
    for i in range(begin, end):
        vx, vy = decisions.vx[i], decisions.vy[i]
        kind, x, y = robots.kind[i], robots.x[i], robots.y[i]
        body, speed = kinds.body_m[kind], kinds.speed_m_s[kind]
        if moving.x.shape[0] > 0:
            vx, vy = dodge(x, y, vx, vy, body, speed, moving, time_step_s)
            decisions.vx[i], decisions.vy[i] = vx, vy
        if vx == 0.0 and vy == 0.0:
            continue
        c = cell_of(x, y, grid)
        reach = body + speed * time_step_s + widest_m
        crowded = decisions.nearest2[i] <= reach * reach
        if not crowded and grid.wall_start[c] == grid.wall_start[c + 1] and moving.x.shape[0] == 0:
            continue
        count, longest = 0, math.sqrt(vx * vx + vy * vy)
        if crowded:
            count, longest = bound_by_robots(i, c, snapshot, spread_m, longest, planes)
        count, longest = bound_by_walls(i, c, snapshot, count, longest, planes)
        count, longest = bound_by_moving(i, snapshot, count, longest, planes)
        if longest == 0.0:
            decisions.vx[i], decisions.vy[i] = 0.0, 0.0
        elif count > 0:
            decisions.vx[i], decisions.vy[i] = nearest_allowed(vx, vy, longest, count, planes)
        if moving.x.shape[0] > 0:
            decisions.vx[i], decisions.vy[i] = flee(i, c, decisions.vx[i], decisions.vy[i], snapshot, spread_m, planes)

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop that asks whether a place can be seen from anywhere on some ground."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from rota.check.tiling_kernels import cell_along

SOME_DIRECTIONS = 64
MANY_NEAR, SECTORS = 8, 128  # with more walls and sides near a point, those that walls hide are left out first


@njit(cache=True)
def _first_hit(segments, index, x, y, cx, cy):
    """Distance along the ray from (x, y) in the unit direction (cx, cy) to the first of the segments; inf for none."""
    nearest = math.inf
    for k in index:
        ax, ay = segments[k, 0] - x, segments[k, 1] - y
        bx, by = segments[k, 2] - x, segments[k, 3] - y
        a, b = cx * ay - cy * ax, cx * by - cy * bx
        if (a > 1e-12 and b > 1e-12) or (a < -1e-12 and b < -1e-12):
            continue
        u = 0.0 if a == b else min(1.0, max(0.0, a / (a - b)))
        along = cx * (ax + u * (bx - ax)) + cy * (ay + u * (by - ay))
        if a == b:
            along = min(along, cx * bx + cy * by)
        if 1e-12 < along < nearest:
            nearest = along
    return nearest


@njit(cache=True)
def _directions(x, y, walls, near_walls, ground, near_ground, crossings, near_crossings, square):
    """Angles between which neither the first wall nor the first side of the ground changes, ascending, with middles."""
    # two for each wall, three for each side of the ground, one for each crossing, and eight: all that is written below
    angles = np.empty(2 * len(near_walls) + 3 * len(near_ground) + len(near_crossings) + 8)
    n = 0
    for k in near_walls:
        for end in range(2):
            angles[n] = math.atan2(walls[k, 2 * end + 1] - y, walls[k, 2 * end] - x)
            n += 1
    for k in near_ground:
        for end in range(2):
            angles[n] = math.atan2(ground[k, 2 * end + 1] - y, ground[k, 2 * end] - x)
            n += 1
        dx, dy = ground[k, 2] - ground[k, 0], ground[k, 3] - ground[k, 1]
        length2 = dx * dx + dy * dy
        u = ((x - ground[k, 0]) * dx + (y - ground[k, 1]) * dy) / length2 if length2 > 0 else 0.0
        if 0 < u < 1 and not square:
            angles[n] = math.atan2(ground[k, 1] + u * dy - y, ground[k, 0] + u * dx - x)
            n += 1
    for k in near_crossings:
        angles[n] = math.atan2(crossings[k, 1] - y, crossings[k, 0] - x)
        n += 1
    for k in range(8):
        angles[n] = (k - 3) * math.pi / 4
        n += 1
    angles = np.sort(angles[:n])
    middles = np.empty(n)
    for k in range(n - 1):
        middles[k] = 0.5 * (angles[k] + angles[k + 1])
    middles[n - 1] = 0.5 * (angles[n - 1] + angles[0]) + math.pi
    return np.append(angles, middles)


@njit(cache=True)
def _span(segment, x, y):
    """Nearest and farthest distance of a segment, where it begins as one turns left, and the angle that it spans.

    The angle is below pi, and pi where rounding leaves it unclear on which side of it (x, y) lies.
    """
    ux, uy, vx, vy = segment[0] - x, segment[1] - y, segment[2] - x, segment[3] - y
    wx, wy = vx - ux, vy - uy
    length2 = wx * wx + wy * wy
    along = min(1.0, max(0.0, -(ux * wx + uy * wy) / length2)) if length2 > 0.0 else 0.0
    near, far = math.hypot(ux + along * wx, uy + along * wy), max(math.hypot(ux, uy), math.hypot(vx, vy))
    one, other = math.atan2(uy, ux), math.atan2(vy, vx)
    turn = (other - one) % (2 * math.pi)
    begin = one if turn <= math.pi else other
    turn = min(turn, 2 * math.pi - turn)
    return near, far, begin + math.pi, math.pi if near < 1e-6 or turn > math.pi - 1e-6 else turn


@njit(cache=True)
def _blocked_at(x, y, walls, near_walls):
    """For each sector of directions the distance beyond which nothing is seen, since one wall spans all of it.

    Such a wall is hit by each ray in the sector, no farther away than its farther end.
    """
    width = 2 * math.pi / SECTORS
    blocked_at = np.full(SECTORS, math.inf)
    for k in near_walls:
        _, far, begin, turn = _span(walls[k], x, y)
        if turn == math.pi:
            continue
        for n in range(math.ceil((begin + 1e-9) / width), math.floor((begin + turn - 1e-9) / width)):
            blocked_at[n % SECTORS] = min(blocked_at[n % SECTORS], far)
    return blocked_at


@njit(cache=True)
def _not_beyond(x, y, blocked_at, segments, near):
    """The segments without those that lie beyond what is seen in every sector they reach into: none is hit first."""
    width = 2 * math.pi / SECTORS
    kept = np.empty_like(near)
    count = 0
    for k in near:
        nearest, _, begin, turn = _span(segments[k], x, y)
        hidden = turn < math.pi
        if hidden:
            for n in range(math.floor((begin - 1e-9) / width), math.floor((begin + turn + 1e-9) / width) + 1):
                if blocked_at[n % SECTORS] >= nearest - 1e-6:
                    hidden = False
                    break
        if not hidden:
            kept[count] = k
            count += 1
    return kept[:count]


@njit(cache=True)
def _sees_along(angles, x, y, reach_m, square, walls, near_walls, ground, near_ground):
    """Whether (x, y) sees some of the ground in reach in one of the directions."""
    for angle in angles:
        cx, cy = math.cos(angle), math.sin(angle)
        far = reach_m / max(abs(cx), abs(cy)) if square else reach_m
        hit = _first_hit(ground, near_ground, x, y, cx, cy)
        # ground that ends at a wall: from the wall itself one sees past it, as sight lines may touch walls
        if hit <= far and hit <= _first_hit(walls, near_walls, x, y, cx, cy) + 1e-9:
            return True
    return False


@njit(cache=True, nogil=True)
def sees_ground(
    points, reach_m, square, grid, shape,
    walls, wall_offsets, wall_index, ground, ground_offsets, ground_index, crossings, cross_offsets, cross_index,
):  # fmt: skip
    """Whether each point (outside of the ground) sees some of the ground in reach, past walls that it may touch.

    The first wall and the first side of the ground change only at their corners and where they cross; the distance to
    a side is smallest at a corner or a foot (for a square: at a diagonal or an axis). So those directions and the
    middles between them decide.
    """
    found = np.zeros(len(points), np.bool_)
    for p in range(len(points)):
        x, y = points[p, 0], points[p, 1]
        cell = cell_along(x - grid[0], grid[2], shape[0]) * shape[1] + cell_along(y - grid[1], grid[2], shape[1])
        near_ground = ground_index[ground_offsets[cell] : ground_offsets[cell + 1]]
        if len(near_ground) == 0:
            continue
        near_walls = wall_index[wall_offsets[cell] : wall_offsets[cell + 1]]
        if len(near_walls) + len(near_ground) > MANY_NEAR:
            blocked_at = _blocked_at(x, y, walls, near_walls)
            near_ground = _not_beyond(x, y, blocked_at, ground, near_ground)
            if len(near_ground) == 0:
                continue
            near_walls = _not_beyond(x, y, blocked_at, walls, near_walls)
        near_crossings = cross_index[cross_offsets[cell] : cross_offsets[cell + 1]]
        # in most places one of a few directions, whichever they are, shows that ground is seen
        some = (np.arange(SOME_DIRECTIONS) + 0.5) * (2 * math.pi / SOME_DIRECTIONS)
        found[p] = _sees_along(some, x, y, reach_m, square, walls, near_walls, ground, near_ground)
        if not found[p]:
            every = _directions(x, y, walls, near_walls, ground, near_ground, crossings, near_crossings, square)
            found[p] = _sees_along(every, x, y, reach_m, square, walls, near_walls, ground, near_ground)
    return found

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop that asks whether a place can be seen from anywhere on some ground."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.check.arrays import Floats, Ints
from rota.check.tiling_kernels import cell_of, in_cell
from rota.check.tolerances import EDGE_RAD, FLAT_RAD, GRID_MARGIN_M, RAY_M, SLACK_M
from rota.compiled.kernel import kernel

SOME_DIRECTIONS = 64
MANY_NEAR, SECTORS = 8, 128  # with more walls and sides near a point, those that walls hide are left out first


class Nearby(NamedTuple):
    """Segments (n, 4) x0, y0, x1, y1 in metres, and the indices (m,) of those that are near a point."""

    segments_m: Floats
    items: Ints


@kernel
def _first_hit(nearby, x, y, cx, cy):
    """Distance along the ray from (x, y) in the unit direction (cx, cy) to the first of the segments; inf for none."""
    segments = nearby.segments_m
    nearest = math.inf
    for k in nearby.items:
        ax, ay = segments[k, 0] - x, segments[k, 1] - y
        bx, by = segments[k, 2] - x, segments[k, 3] - y
        a, b = cx * ay - cy * ax, cx * by - cy * bx
        if (a > RAY_M and b > RAY_M) or (a < -RAY_M and b < -RAY_M):
            continue
        u = 0.0 if a == b else min(1.0, max(0.0, a / (a - b)))
        along = cx * (ax + u * (bx - ax)) + cy * (ay + u * (by - ay))
        if a == b:
            along = min(along, cx * bx + cy * by)
        if RAY_M < along < nearest:
            nearest = along
    return nearest


@kernel
def _directions(x, y, walls, ground, crossings, square):
    """Angles (n,) in radians: where the first wall or the first side of the ground may change, and the middles between.

    (x, y): the place that looks, in metres. The changes come first, ascending; then the middles in the same order.
    """
    # two for each wall, three for each side of the ground, one for each crossing, and eight: all that is written below
    angles = np.empty(2 * len(walls.items) + 3 * len(ground.items) + len(crossings.items) + 8)
    n = 0
    for k in walls.items:
        for end in range(2):
            angles[n] = math.atan2(walls.segments_m[k, 2 * end + 1] - y, walls.segments_m[k, 2 * end] - x)
            n += 1
    for k in ground.items:
        side = ground.segments_m[k]
        for end in range(2):
            angles[n] = math.atan2(side[2 * end + 1] - y, side[2 * end] - x)
            n += 1
        dx, dy = side[2] - side[0], side[3] - side[1]
        length2 = dx * dx + dy * dy
        u = ((x - side[0]) * dx + (y - side[1]) * dy) / length2 if length2 > 0 else 0.0
        if 0 < u < 1 and not square:
            angles[n] = math.atan2(side[1] + u * dy - y, side[0] + u * dx - x)
            n += 1
    for k in crossings.items:
        angles[n] = math.atan2(crossings.segments_m[k, 1] - y, crossings.segments_m[k, 0] - x)
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


@kernel
def _span(segment, x, y):
    """Nearest and farthest distance of a segment (4,) in metres, the angle at which it begins, and the angle it spans.

    It begins at its right end as seen from (x, y). The spanned angle is below pi radians; it is pi where rounding
    leaves it unclear on which side of the segment (x, y) lies.
    """
    ux, uy, vx, vy = segment[0] - x, segment[1] - y, segment[2] - x, segment[3] - y
    wx, wy = vx - ux, vy - uy
    length2 = wx * wx + wy * wy
    along = min(1.0, max(0.0, -(ux * wx + uy * wy) / length2)) if length2 > 0.0 else 0.0
    near, far = math.hypot(ux + along * wx, uy + along * wy), max(math.hypot(ux, uy), math.hypot(vx, vy))
    first_rad, second_rad = math.atan2(uy, ux), math.atan2(vy, vx)
    turn = (second_rad - first_rad) % (2 * math.pi)
    begin = first_rad if turn <= math.pi else second_rad
    turn = min(turn, 2 * math.pi - turn)
    return near, far, begin + math.pi, math.pi if near < GRID_MARGIN_M or turn > math.pi - FLAT_RAD else turn


@kernel
def _blocked_at(x, y, walls):
    """(SECTORS,) metres beyond which nothing is seen in each sector of directions, since a single wall spans all of it.

    Each ray in the sector hits such a wall no farther away than its farther end.
    """
    width = 2 * math.pi / SECTORS
    blocked_at = np.full(SECTORS, math.inf)
    for k in walls.items:
        _, far, begin, turn = _span(walls.segments_m[k], x, y)
        if turn == math.pi:
            continue
        for n in range(math.ceil((begin + EDGE_RAD) / width), math.floor((begin + turn - EDGE_RAD) / width)):
            blocked_at[n % SECTORS] = min(blocked_at[n % SECTORS], far)
    return blocked_at


@kernel
def _not_beyond(x, y, blocked_at, nearby):
    """The segments of ``nearby`` that a ray may hit first.

    A segment is left out where something nearer blocks every sector that it reaches into. blocked_at: (SECTORS,)
    metres.
    """
    width = 2 * math.pi / SECTORS
    kept = np.empty_like(nearby.items)
    count = 0
    for k in nearby.items:
        nearest, _, begin, turn = _span(nearby.segments_m[k], x, y)
        hidden = turn < math.pi
        if hidden:
            for n in range(math.floor((begin - EDGE_RAD) / width), math.floor((begin + turn + EDGE_RAD) / width) + 1):
                if blocked_at[n % SECTORS] >= nearest - GRID_MARGIN_M:
                    hidden = False
                    break
        if not hidden:
            kept[count] = k
            count += 1
    return Nearby(nearby.segments_m, kept[:count])


@kernel
def _sees_along(angles, x, y, reach_m, square, walls, ground):
    """Whether (x, y) sees ground within reach_m in any of the directions, angles (n,) in radians."""
    for angle in angles:
        cx, cy = math.cos(angle), math.sin(angle)
        far = reach_m / max(abs(cx), abs(cy)) if square else reach_m
        hit = _first_hit(ground, x, y, cx, cy)
        # ground that ends at a wall: from the wall itself one sees past it, as sight lines may touch walls
        if hit <= far and hit <= _first_hit(walls, x, y, cx, cy) + SLACK_M:
            return True
    return False


@kernel(nogil=True)
def sees_ground(points, reach_m, square, grid, walls, ground, crossings):
    """Whether each point (n, 2), outside of the ground, sees some of the ground within reach_m: (n,) bool.

    Sight lines may touch walls. walls: ``Binned`` sides of what blocks sight; ground: those of the ground; crossings:
    where the two cross, as segments of no length.

    The first wall and the first side of the ground change only at their corners and where they cross. The distance to a
    side is smallest at a corner or a foot, for a square at a diagonal or an axis. So those directions and the middles
    between them decide.
    """
    seen = np.zeros(len(points), np.bool_)
    for p in range(len(points)):
        x, y = points[p, 0], points[p, 1]
        cell = cell_of(x, y, grid)
        near_ground = Nearby(ground.segments_m, in_cell(ground, cell))
        if len(near_ground.items) == 0:
            continue
        near_walls = Nearby(walls.segments_m, in_cell(walls, cell))
        if len(near_walls.items) + len(near_ground.items) > MANY_NEAR:
            blocked_at = _blocked_at(x, y, near_walls)
            near_ground = _not_beyond(x, y, blocked_at, near_ground)
            if len(near_ground.items) == 0:
                continue
            near_walls = _not_beyond(x, y, blocked_at, near_walls)
        # in most places one of a few directions, whichever they are, shows that ground is seen
        first_directions = (np.arange(SOME_DIRECTIONS) + 0.5) * (2 * math.pi / SOME_DIRECTIONS)
        seen[p] = _sees_along(first_directions, x, y, reach_m, square, near_walls, near_ground)
        if not seen[p]:
            near_crossings = Nearby(crossings.segments_m, in_cell(crossings, cell))
            all_directions = _directions(x, y, near_walls, near_ground, near_crossings, square)
            seen[p] = _sees_along(all_directions, x, y, reach_m, square, near_walls, near_ground)
    return seen

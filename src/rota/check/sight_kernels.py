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
MANY_AROUND, NEAR_SHARES = 64, (0.05, 0.2)  # with more, those within these shares of the reach are looked at first
TOGETHER = 16  # neighbours of one border that are looked at all at once first
CLOSE_M = 0.01  # a ray may hit a segment nearer than this although it passes by its end


class Nearby(NamedTuple):
    """Segments (n, 4) x0, y0, x1, y1 in metres, and the indices (m,) of those that are near a point."""

    segments_m: Floats
    items: Ints


class BySector(NamedTuple):
    """Segments (n, 4), and the indices of those that a ray in sector s of directions may hit.

    They are items[offsets[s] : offsets[s + 1]]; offsets: (SECTORS + 1,).
    """

    segments_m: Floats
    offsets: Ints
    items: Ints


@kernel
def _first_hit(by_sector, sector, x, y, cx, cy):
    """Distance along the ray from (x, y) in the unit direction (cx, cy) to the first of the segments; inf for none.

    sector: which the direction is in.
    """
    segments = by_sector.segments_m
    nearest = math.inf
    for at in range(by_sector.offsets[sector], by_sector.offsets[sector + 1]):
        k = by_sector.items[at]
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
def _directions(x, y, walls, ground, crossings, square, ground_of):
    """Angles (n,) in radians: where the first wall or the first side of the ground may change, and the middles between.

    (x, y): the place that looks, in metres. Only those in sectors where ``ground_of``, a ``BySector``, has any ground.
    The changes come first, ascending, with the ends of these sectors among them; then the middles in the same order.
    """
    width = 2 * math.pi / SECTORS
    # two for each wall, three for each side of the ground, one for each crossing, eight, and two for each sector: all
    # that is written below
    most = 2 * len(walls.items) + 3 * len(ground.items) + len(crossings.items) + 8 + 2 * SECTORS
    angles = np.empty(most)
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
    kept = 0
    for i in range(n):
        sector = _sector_of(angles[i])
        if ground_of.offsets[sector] < ground_of.offsets[sector + 1]:
            angles[kept] = angles[i]
            kept += 1
    for sector in range(SECTORS):
        if ground_of.offsets[sector] < ground_of.offsets[sector + 1]:
            angles[kept], angles[kept + 1] = sector * width - math.pi, (sector + 1) * width - math.pi
            kept += 2
    angles = np.sort(angles[:kept])
    return np.append(angles, 0.5 * (angles[:-1] + angles[1:]))


@kernel
def _sector_of(angle):
    """The number of the sector of a direction, counted as ``_span`` counts angles."""
    return math.floor((angle + math.pi) / (2 * math.pi / SECTORS)) % SECTORS


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
def _reach_by_sector(x, y, walls):
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
def _reaches_out(nearest_m, begin, turn, blocked_at):
    """Whether what is so near and spans those angles, counted as ``_span`` does, reaches into a sector not blocked."""
    width = 2 * math.pi / SECTORS
    first = math.floor((begin - EDGE_RAD) / width)
    for n in range(first, min(first + SECTORS - 1, math.floor((begin + turn + EDGE_RAD) / width)) + 1):
        if blocked_at[n % SECTORS] >= nearest_m - GRID_MARGIN_M:
            return True
    return False


@kernel
def _some_reach_out(x, y, segments, some, blocked_at):
    """False when none of some segments, indices (m,), reaches into a sector that is not blocked before it.

    They are looked at all at once, as the circle round them.
    """
    x0, y0, x1, y1 = math.inf, math.inf, -math.inf, -math.inf
    for k in some:
        x0, x1 = min(x0, segments[k, 0], segments[k, 2]), max(x1, segments[k, 0], segments[k, 2])
        y0, y1 = min(y0, segments[k, 1], segments[k, 3]), max(y1, segments[k, 1], segments[k, 3])
    dx, dy, radius = 0.5 * (x0 + x1) - x, 0.5 * (y0 + y1) - y, 0.5 * math.hypot(x1 - x0, y1 - y0) + GRID_MARGIN_M
    away = math.hypot(dx, dy)
    if away < 2 * radius:
        return True
    half = math.asin(radius / away)
    return _reaches_out(away - radius, math.atan2(dy, dx) - half + math.pi, 2 * half, blocked_at)


@kernel
def _not_beyond(x, y, blocked_at, nearby):
    """The segments of ``nearby`` that a ray may hit first.

    A segment is left out where something nearer blocks every sector that it reaches into. blocked_at: (SECTORS,)
    metres.
    """
    kept = np.empty_like(nearby.items)
    count = 0
    for first in range(0, len(nearby.items), TOGETHER):
        some = nearby.items[first : first + TOGETHER]
        if not _some_reach_out(x, y, nearby.segments_m, some, blocked_at):
            continue
        for k in some:
            nearest, _, begin, turn = _span(nearby.segments_m[k], x, y)
            if turn == math.pi or _reaches_out(nearest, begin, turn, blocked_at):
                kept[count] = k
                count += 1
    return Nearby(nearby.segments_m, kept[:count])


@kernel
def _by_sector(x, y, nearby, blocked_at):
    """The ``BySector`` of some segments for rays from (x, y): a ray hits none that it leaves out first.

    blocked_at: (SECTORS,) metres beyond which nothing in a sector is seen.
    """
    width = 2 * math.pi / SECTORS
    count = len(nearby.items)
    firsts, lasts, nears = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count)
    offsets = np.zeros(SECTORS + 2, np.int64)  # one place ahead while they are counted
    for i in range(count):
        nearest, _, begin, turn = _span(nearby.segments_m[nearby.items[i]], x, y)
        firsts[i], lasts[i], nears[i] = 0, SECTORS - 1, nearest - GRID_MARGIN_M
        if turn < math.pi and nearest > CLOSE_M:
            firsts[i] = math.floor((begin - EDGE_RAD) / width)
            lasts[i] = min(firsts[i] + SECTORS - 1, math.floor((begin + turn + EDGE_RAD) / width))
        for n in range(firsts[i], lasts[i] + 1):
            if blocked_at[n % SECTORS] >= nears[i]:
                offsets[n % SECTORS + 2] += 1
    for n in range(2, SECTORS + 2):
        offsets[n] += offsets[n - 1]
    items = np.empty(offsets[SECTORS + 1], np.int64)
    for i in range(count):
        for n in range(firsts[i], lasts[i] + 1):
            if blocked_at[n % SECTORS] >= nears[i]:
                items[offsets[n % SECTORS + 1]] = nearby.items[i]
                offsets[n % SECTORS + 1] += 1
    return BySector(nearby.segments_m, offsets[: SECTORS + 1], items)


@kernel
def _sees_along(angles, x, y, reach_m, square, walls, ground):
    """Whether (x, y) sees ground within reach_m in any of the directions, angles (n,) in radians.

    walls, ground: ``BySector``.
    """
    for angle in angles:
        sector = _sector_of(angle)
        if ground.offsets[sector] == ground.offsets[sector + 1]:
            continue
        cx, cy = math.cos(angle), math.sin(angle)
        far = reach_m / max(abs(cx), abs(cy)) if square else reach_m
        hit = _first_hit(ground, sector, x, y, cx, cy)
        # ground that ends at a wall: from the wall itself one sees past it, as sight lines may touch walls
        if hit <= far and hit <= _first_hit(walls, sector, x, y, cx, cy) + SLACK_M:
            return True
    return False


@kernel
def _within(nearby, x, y, far_m):
    """The segments of ``nearby`` whose boxes come within ``far_m`` of (x, y): all that come so near, and some more."""
    segments = nearby.segments_m
    kept = np.empty_like(nearby.items)
    count = 0
    for k in nearby.items:
        x0, x1, y0, y1 = segments[k, 0], segments[k, 2], segments[k, 1], segments[k, 3]
        if min(x0, x1) - x > far_m or x - max(x0, x1) > far_m or min(y0, y1) - y > far_m or y - max(y0, y1) > far_m:
            continue
        kept[count] = k
        count += 1
    return Nearby(segments, kept[:count])


@kernel
def _sees_some(x, y, reach_m, square, walls, ground, crossings, all_m):
    """1 when (x, y) sees ground within reach_m, 0 when it does not, -1 when that is to be asked with more at hand.

    walls, ground: ``Nearby``, which hold all that comes within ``all_m`` of (x, y); crossings: all that matter.
    """
    blocked_at = np.full(SECTORS, math.inf)
    if len(walls.items) + len(ground.items) > MANY_NEAR:
        blocked_at = _reach_by_sector(x, y, walls)
        ground = _not_beyond(x, y, blocked_at, ground)
        walls = _not_beyond(x, y, blocked_at, walls)
        if blocked_at.max() + GRID_MARGIN_M < all_m:
            all_m = math.inf  # walls that are known hide whatever is not
    walls_of, ground_of = _by_sector(x, y, walls, blocked_at), _by_sector(x, y, ground, blocked_at)
    # in most places one of a few directions, whichever they are, shows that ground is seen
    some = (np.arange(SOME_DIRECTIONS) + 0.5) * (2 * math.pi / SOME_DIRECTIONS)
    if _sees_along(some, x, y, min(reach_m, all_m), square and reach_m <= all_m, walls_of, ground_of):
        return 1
    if all_m < math.inf:
        return -1
    if len(ground.items) == 0:
        return 0
    every = _directions(x, y, walls, ground, crossings, square, ground_of)
    return 1 if _sees_along(every, x, y, reach_m, square, walls_of, ground_of) else 0


@kernel
def sees_ground(points, reach_m, square, grid, walls, ground, crossings):
    """Whether each point (n, 2), outside of the ground, sees some of the ground within reach_m: (n,) bool.

    Sight lines may touch walls. walls: ``Binned`` sides of what blocks sight; ground: those of the ground; crossings:
    where the two cross, as segments of no length.

    The first wall and the first side of the ground change only at their corners and where they cross. The distance to a
    side is smallest at a corner or a foot, for a square at a diagonal or an axis. So those directions and the middles
    between them decide. What is near mostly settles it: the farther walls and sides are looked at only where it does
    not.
    """
    seen = np.zeros(len(points), np.bool_)
    for p in range(len(points)):
        x, y = points[p, 0], points[p, 1]
        cell = cell_of(x, y, grid)
        all_ground = Nearby(ground.segments_m, in_cell(ground, cell))
        if len(all_ground.items) == 0:
            continue
        # what is out of reach decides nothing, and must not: rays at its ends would only try how rounding falls out
        far_m = reach_m * (math.sqrt(2.0) if square else 1.0) + GRID_MARGIN_M
        all_ground = _within(all_ground, x, y, far_m)
        all_walls = _within(Nearby(walls.segments_m, in_cell(walls, cell)), x, y, far_m)
        all_crossings = Nearby(crossings.segments_m, in_cell(crossings, cell))
        answer = -1
        if len(all_walls.items) + len(all_ground.items) > MANY_AROUND:
            for share in NEAR_SHARES:
                far_m = share * reach_m
                near_walls, near_ground = _within(all_walls, x, y, far_m), _within(all_ground, x, y, far_m)
                answer = _sees_some(x, y, reach_m, square, near_walls, near_ground, all_crossings, far_m)
                if answer >= 0:
                    break
        if answer < 0:
            answer = _sees_some(x, y, reach_m, square, all_walls, all_ground, all_crossings, math.inf)
        seen[p] = answer == 1
    return seen

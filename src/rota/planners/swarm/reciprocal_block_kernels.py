# mypy: disable-error-code="no-any-return"
"""The decision of ``decide_reciprocal`` for many robots at a time, without branches, so that it fills vector registers.

Each robot may choose the velocities v, |v| <= R, in up to four half-planes v . e <= b. The line of a half-plane runs
through the disc along t -> b e + t (-e_y, e_x), |t| <= sqrt(R^2 - b^2). Every other half-plane bounds t from one side,
and what is left is a piece of the set's border, its *chord*. Chords add triangles over the origin, and the arcs between
them sectors. For the area only the sum of all angles of arcs is needed: it is the argument of the product of all places
where arcs end, each over the one where it begins, as complex numbers. So the order of the border never matters, and no
polygon is cut.

A robot is left to ``decide_reciprocal`` where rounding might count for more than 1e-9 R (sets with next to no area,
parallel lines, corners on the circle), by walls, and among more robots than there is room for. A
robot's decision does not depend on the others of its block. It differs from that of ``decide_reciprocal`` by rounding.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats, Ints
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.kernels import cell_of
from rota.planners.swarm.reciprocal_kernels import SAME_PLACE_M2, decide_reciprocal
from rota.planners.swarm.state import Room

U = np.uint64  # of an index that is never below 0: numba would look whether it is
BLOCK = 32  # robots; the rows of all fit in the first cache
PLANES = 4
MOST_ROUND = 48  # robots in the cells round about
# rows of the room, each of BLOCK numbers: of each neighbour the vector to it and the velocity relative to it; of each
# robot its velocity and top speed, the decision, and whether it is left to be made otherwise
DX, DY, RX, RY = range(0, 4 * PLANES, PLANES)
VX, VY, SPEED, NEW_VX, NEW_VY, NEAREST2, OPEN, LEFT = range(4 * PLANES, 4 * PLANES + 8)
ROWS = 4 * PLANES + 8
UNBOUNDED = 1e100  # bound of what is no half-plane; its square is finite
EMPTY = 1e-9  # share of R; lines that miss each other by more leave nothing
# sine of an angle; an area over R times its lines' distances, times the least such sine; radians: a set with less is
# left open
PARALLEL, FLAT, TURN = 1e-6, 1e-7, 1e-6
TWO_PI = 2.0 * math.pi
FOLDED_ABOVE = 0.66  # the arc tangent of more than this is taken from pi / 4 on


class BlockRoom(NamedTuple):
    """What one thread writes to: (MOST_ROUND + 1,) robots found in range, (ROWS * BLOCK,) rows, room for one robot.

    exact: (0,), since nobody has gone on unheard.
    """

    found: Ints
    rows: Floats
    alone: Room
    exact: Floats


@allocation_free
def argument(x: float, y: float) -> float:
    """The angle of (x, y) in radians, 0..2 pi, to two units in the last place; NaN of (0, 0).

    Source of the fraction: S. Moshier, Cephes, atan.c.
    """
    ax, ay = abs(x), abs(y)
    t = (ay if ax > ay else ax) / (ax if ax > ay else ay)
    u = (t - 1.0) / (t + 1.0) if t > FOLDED_ABOVE else t
    z = u * u
    p = -8.750608600031904122785e-1 * z - 1.615753718733365076637e1
    p = ((p * z - 7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1
    q = (z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2
    q = ((q * z + 4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2
    angle = z * (p / q) * u + u
    angle = angle + 0.25 * math.pi if t > FOLDED_ABOVE else angle
    angle = 0.5 * math.pi - angle if ay > ax else angle
    angle = math.pi - angle if x < 0.0 else angle
    return TWO_PI - angle if y < 0.0 else angle


@allocation_free
def neighbour_of(k: int, lane: int, rows: Any) -> tuple[float, float, float, float]:
    """The vector to neighbour k, and the velocity relative to it."""
    dx, dy = rows[(DX + k) * BLOCK + lane], rows[(DY + k) * BLOCK + lane]
    return dx, dy, rows[(RX + k) * BLOCK + lane], rows[(RY + k) * BLOCK + lane]


@allocation_free
def in_order(one: Any, other: Any) -> tuple[Any, Any]:
    """Two neighbours, the one farther left first, so that sums do not depend on how the grid has them."""
    ax, ay, aux, auy = one
    bx, by, bux, buy = other
    change = ax > bx or (ax == bx and ay > by)
    first = bx if change else ax, by if change else ay, bux if change else aux, buy if change else auy
    return first, (ax if change else bx, ay if change else by, aux if change else bux, auy if change else buy)


@allocation_free
def chord_of(neighbour: Any, vx: float, vy: float, speed: float) -> tuple[Any, float]:
    """The line of a neighbour's half-plane: e, b, half its length in the disc, and where it counts, so far all along.

    And how far it is to the neighbour, squared. The robot itself in place of a neighbour bounds nothing.
    """
    dx, dy, rx, ry = neighbour
    distance2 = dx * dx + dy * dy
    other = distance2 >= SAME_PLACE_M2
    distance = math.sqrt(distance2) if other else 1.0
    ex, ey = dx / distance if other else 1.0, dy / distance if other else 0.0
    bound = vx * ex + vy * ey - 0.5 * (rx * ex + ry * ey) if other else UNBOUNDED
    square = speed * speed - bound * bound
    half = math.sqrt(square) if square > 0.0 else 0.0
    return (ex, ey, bound, half, -half, half), distance2 if other else math.inf


@allocation_free
def narrow(low: float, high: float, slope: float, left: float) -> tuple[float, float]:
    """What of low <= t <= high has slope t <= left."""
    t = left / slope
    high = t if slope > 0.0 and t < high else high
    low = t if slope < 0.0 and t > low else low
    return low, high


@allocation_free
def meet(one: Any, other: Any) -> tuple[Any, Any, float]:
    """Two chords, each as far as the other's half-plane leaves it; and the sine of the angle between them."""
    ax, ay, a, a_half, a_low, a_high = one
    bx, by, b, b_half, b_low, b_high = other
    sine, cosine = ax * by - ay * bx, ax * bx + ay * by
    a_low, a_high = narrow(a_low, a_high, sine, b - a * cosine)
    b_low, b_high = narrow(b_low, b_high, -sine, a - b * cosine)
    steep = abs(sine) if a_half > 0.0 and b_half > 0.0 else 1.0
    return (ax, ay, a, a_half, a_low, a_high), (bx, by, b, b_half, b_low, b_high), steep


@allocation_free
def add(total: Any, chord: Any, radius: float) -> Any:
    """The sums over chords, with one more of them.

    Twice the area and thrice the first moment (x, y) over them; the arcs' ends less their beginnings, (x, y), and the
    quotient of these, a complex number; how many more arcs end than begin, how many end; the distances of the lines.
    """
    area, mx, my, sx, sy, px, py, balance, ends, away = total
    ex, ey, bound, half, low, high = chord
    some = half > 0.0 and high > low
    cross = bound * (high - low) if some else 0.0
    ux, uy, wx, wy = bound * ex - low * ey, bound * ey + low * ex, bound * ex - high * ey, bound * ey + high * ex
    enters, leaves = some and low == -half, some and high == half
    fx, fy = ux / radius if enters else 1.0, uy / radius if enters else 0.0
    gx, gy = wx / radius if leaves else 1.0, wy / radius if leaves else 0.0
    qx, qy = fx * gx + fy * gy, fy * gx - fx * gy
    end, beginning = 1.0 if enters else 0.0, 1.0 if leaves else 0.0
    return (
        area + cross,
        mx + 0.5 * cross * (ux + wx),
        my + 0.5 * cross * (uy + wy),
        sx + ((ux if enters else 0.0) - (wx if leaves else 0.0)),
        sy + ((uy if enters else 0.0) - (wy if leaves else 0.0)),
        px * qx - py * qy,
        px * qy + py * qx,
        balance + (end - beginning),
        ends + end,
        away + (abs(bound) if some else 0.0),
    )


@allocation_free
def widest(one: Any, two: Any, three: Any, four: Any) -> float:
    """The length of the longest of four chords, below 0 where other half-planes leave nothing of any."""
    a = one[5] - one[4] if one[3] > 0.0 else -math.inf
    b = two[5] - two[4] if two[3] > 0.0 else -math.inf
    c = three[5] - three[4] if three[3] > 0.0 else -math.inf
    d = four[5] - four[4] if four[3] > 0.0 else -math.inf
    a, c = a if a > b else b, c if c > d else d
    return a if a > c else c


@allocation_free
def choose_velocities(rows: Any) -> None:
    """The centroids of the sets of a block's robots into its rows; OPEN: 1 where the set is left open, else 0.

    Without any half-plane the centroid is 0, and likewise where all lines run through the origin and leave no sector.
    """
    for lane in range(BLOCK):
        radius = rows[SPEED * BLOCK + lane]
        vx, vy = rows[VX * BLOCK + lane], rows[VY * BLOCK + lane]
        a, b = in_order(neighbour_of(0, lane, rows), neighbour_of(1, lane, rows))
        c, d = in_order(neighbour_of(2, lane, rows), neighbour_of(3, lane, rows))
        a, c = in_order(a, c)
        b, d = in_order(b, d)
        b, c = in_order(b, c)
        one, nearest2 = chord_of(a, vx, vy, radius)
        two, second2 = chord_of(b, vx, vy, radius)
        three, third2 = chord_of(c, vx, vy, radius)
        four, fourth2 = chord_of(d, vx, vy, radius)
        rows[NEAREST2 * BLOCK + lane] = min(min(nearest2, second2), min(third2, fourth2))
        one, two, steep = meet(one, two)
        one, three, other = meet(one, three)
        steep = min(steep, other)
        one, four, other = meet(one, four)
        steep = min(steep, other)
        two, three, other = meet(two, three)
        steep = min(steep, other)
        two, four, other = meet(two, four)
        steep = min(steep, other)
        three, four, other = meet(three, four)
        steep = min(steep, other)
        total = add((0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0), one, radius)
        total = add(add(add(total, two, radius), three, radius), four, radius)
        area, mx, my, sx, sy, px, py, balance, ends, away = total
        angle, r2 = argument(px, py), radius * radius
        area += r2 * angle
        unsure = balance != 0.0 or (ends > 0.0 and (angle < TURN or angle > TWO_PI - TURN))
        unsure = unsure or not area * steep > FLAT * radius * (away + (radius if ends > 0.0 else 0.0))
        least = min(min(one[2], two[2]), min(three[2], four[2]))
        # lines that leave nothing of each other: the set is empty, or, if it holds the origin, the origin alone
        length = widest(one, two, three, four)
        still = steep > PARALLEL and (length < -EMPTY * radius or (least == 0.0 and length <= 0.0))
        share = 2.0 / (3.0 * area)
        settled = least >= radius or still or unsure
        rows[NEW_VX * BLOCK + lane] = 0.0 if settled else share * (mx + r2 * sy)
        rows[NEW_VY * BLOCK + lane] = 0.0 if settled else share * (my - r2 * sx)
        rows[OPEN * BLOCK + lane] = 1.0 if unsure and not still and least < radius else 0.0


@allocation_free
def without_farthest(i: int, count: int, robots: Any, found: Any) -> int:
    """Take the farthest from robot i out of ``count`` found ones; of two as far, that of the greater number.

    Returns how many are left.
    """
    x, y, last, most2 = robots.x[i], robots.y[i], 0, -1.0
    for k in range(count):
        j = found[k]
        dx, dy = robots.x[j] - x, robots.y[j] - y
        distance2 = dx * dx + dy * dy
        if distance2 > most2 or (distance2 == most2 and robots.name[j] > robots.name[found[last]]):
            last, most2 = k, distance2
    found[last] = found[count - 1]
    return count - 1


@allocation_free
def gather(first: int, lanes: int, snapshot: Any, room: Any) -> None:
    """Write the robots first..first + lanes - 1 and their nearest neighbours into the rows of a ``BlockRoom``.

    Neighbours count as in ``find_neighbours``, but are not sorted. A robot without as many has itself for the rest.
    LEFT: 1 of a robot with walls in reach, with more robots round about than there is room for, with a neighbour in its
    very place, or with one that is a body only, else 0.
    """
    robots, kinds, grid, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule
    found, rows = room.found, room.rows
    stride = grid.columns + 2
    for lane in range(lanes):
        i = first + lane
        x, y, vx, vy, kind = robots.x[U(i)], robots.y[U(i)], robots.vx[U(i)], robots.vy[U(i)], robots.kind[U(i)]
        range_m = kinds.neighbour_range_m[U(kind)]
        range2, c = range_m * range_m, cell_of(x, y, grid)
        # the robots of three rows of cells in one loop: of three short ones nobody can foretell the ends
        a, a_end = grid.start[U(c - stride - 1)], grid.start[U(c - stride + 2)]
        b, b_end = grid.start[U(c - 1)], grid.start[U(c + 2)]
        d, d_end = grid.start[U(c + stride - 1)], grid.start[U(c + stride + 2)]
        to_a, to_b = a_end - a, a_end - a + b_end - b
        total = to_b + d_end - d
        left = total > MOST_ROUND or grid.wall_start[U(c)] < grid.wall_start[U(c + 1)]
        b, d, count = b - to_a, d - to_b, 0
        for k in range(0 if left else total):
            j = k + (a if k < to_a else (b if k < to_b else d))
            dx, dy = robots.x[U(j)] - x, robots.y[U(j)] - y
            # written even where it does not count: a branch would be taken at random
            found[U(count)] = j
            count += (1 if dx * dx + dy * dy <= range2 else 0) & (1 if j != i else 0)
        while count > rule.neighbours:
            count = without_farthest(i, count, robots, found)
        rows[U(VX * BLOCK + lane)], rows[U(VY * BLOCK + lane)] = vx, vy
        rows[U(SPEED * BLOCK + lane)] = kinds.speed_m_s[U(kind)]
        for k in range(PLANES):
            j = found[U(k)] if k < count else i
            dx, dy = robots.x[U(j)] - x, robots.y[U(j)] - y
            rows[U((DX + k) * BLOCK + lane)], rows[U((DY + k) * BLOCK + lane)] = dx, dy
            rows[U((RX + k) * BLOCK + lane)] = vx - robots.vx[U(j)]
            rows[U((RY + k) * BLOCK + lane)] = vy - robots.vy[U(j)]
            left = left or robots.kind[U(j)] >= robots.member_kinds or (j != i and dx * dx + dy * dy < SAME_PLACE_M2)
        rows[U(LEFT * BLOCK + lane)] = 1.0 if left else 0.0


@allocation_free
def decide_in_blocks(begin: int, end: int, snapshot: Any, widest_m: float, decisions: Any, room: Any) -> None:
    """As ``decide_reciprocal`` and ``filter_velocities``, for exact centroids, tangents and 1 to ``PLANES`` neighbours.

    Nothing moves but robots, whose ranges reach as far as the filter looks. widest_m: as ``filter_velocities`` takes
    it; below 0: unfiltered. room: a ``BlockRoom`` of one thread.
    """
    rows, kinds, kind = room.rows, snapshot.kinds, snapshot.robots.kind
    for first in range(begin, end, BLOCK):
        lanes = min(BLOCK, end - first)
        gather(first, lanes, snapshot, room)
        choose_velocities(rows)
        for lane in range(lanes):
            i = first + lane
            left = rows[U(LEFT * BLOCK + lane)] > 0.0
            nearest2 = 0.0 if left else rows[U(NEAREST2 * BLOCK + lane)]
            decisions.vx[U(i)], decisions.vy[U(i)] = rows[U(NEW_VX * BLOCK + lane)], rows[U(NEW_VY * BLOCK + lane)]
            decisions.nearest2[U(i)] = nearest2
            step_m = kinds.speed_m_s[U(kind[U(i)])] * snapshot.rule.time_step_s
            reach_m = kinds.body_m[U(kind[U(i)])] + step_m + widest_m
            if left or rows[U(OPEN * BLOCK + lane)] > 0.0:
                decide_reciprocal(i, i + 1, snapshot, decisions, room.alone)
            if nearest2 <= reach_m * reach_m and widest_m >= 0.0:
                filter_velocities(i, i + 1, snapshot, widest_m, room.exact, decisions, room.alone)

"""Compiled loops that tell which samples a leg sees. Arrays have fixed types: one compilation serves all."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import allocation_free, always_inline, noinline
from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.sight_kernels import (
    DEPTH_SECTORS,
    Line,
    end_of_hiding,
    hides_all,
    nearest_in_range,
    range_interval,
    sectors_from_x,
)
from rota.planners.patrol.tolerances import ON_LINE_M, SAME_PLACE_M

Index = np.uint64  # in the hottest loops: each index that may be negative costs a look whether it is


@by_reference
class Samples(NamedTuple):
    """Points (n) that must be seen: those of lattices row by row, then all others by bins; see ``samples.py``.

    x, y, weight, period, visit_m, shrink_m: (n,), as ``SamplePoints`` has them. Point i has the walls
    wall_item[wall_start[i] : wall_start[i + 1]] near it, rows of walls (k, 4). next_walled: (n,) the first point from i
    on that has any. depth2: (w, 2, DEPTH_SECTORS) how far each of these sees, see ``depth_kernels.py``; depth_row: (n,)
    its row there. frames (f, 4), frame_ints (f, 4), column_start: the lattices, see ``samples.lattice_frames``.
    bin_start: where each bin of the other points begins; bins: (2,) how many columns and rows there are. origin: (5,)
    metres, the least x and y of all points, the side of a bin, the farthest that a visit is served from, and
    ``end_of_hiding``'s corner.
    """

    x: Floats
    y: Floats
    weight: Floats
    period: Ints
    visit_m: Floats
    shrink_m: Floats
    wall_start: Ints
    wall_item: Ints
    walls: Floats
    depth2: NDArray[np.float32]
    depth_row: NDArray[np.int32]
    next_walled: Ints
    frames: Floats
    frame_ints: Ints
    column_start: NDArray[np.int32]
    bin_start: Ints
    origin: Floats
    bins: Ints


class Leg(NamedTuple):
    """A straight way from a to b, in metres, and the sensor that is taken along it.

    reach: metres, a disc's radius or half a square's side; square: 1 for a square, 0 for a disc.
    """

    ax: float
    ay: float
    bx: float
    by: float
    reach: float
    square: int


class Lane(NamedTuple):
    """What is in range of a leg from a along d: the leg, 1 / dy (0 for a level leg), and the reach r in metres.

    (nx, ny): across the leg, as long as the reach.
    """

    ax: float
    ay: float
    dx: float
    dy: float
    per_dy: float
    nx: float
    ny: float
    r: float


@always_inline
def square_row(lane: Lane, y: float) -> tuple[float, float]:
    """Least and greatest x at height y that a square's range sweeps on the leg; the first is greater: none."""
    ax, ay, dx, dy, reach = lane.ax, lane.ay, lane.dx, lane.dy, lane.r
    first, last = 0.0, 1.0
    if dy == 0.0:
        if abs(y - ay) > reach:
            return 1.0, 0.0
    else:
        t0, t1 = (y - reach - ay) * lane.per_dy, (y + reach - ay) * lane.per_dy
        first, last = max(0.0, min(t0, t1)), min(1.0, max(t0, t1))
        if first > last:
            return 1.0, 0.0
    x0, x1 = ax + first * dx, ax + last * dx
    return min(x0, x1) - reach, max(x0, x1) + reach


@always_inline
def disc_row(lane: Lane, y: float) -> tuple[float, float]:
    """Least and greatest x at height y that a disc's range sweeps on the leg; the first is greater: none."""
    ax, ay, dx, dy, reach = lane.ax, lane.ay, lane.dx, lane.dy, lane.r
    left, right = math.inf, -math.inf
    up = y - ay
    under = reach * reach - up * up
    if under >= 0:
        wide = math.sqrt(under)
        left, right = ax - wide, ax + wide
    up -= dy
    under = reach * reach - up * up
    if under >= 0:
        wide = math.sqrt(under)
        left, right = min(left, ax + dx - wide), max(right, ax + dx + wide)
    if dy != 0.0:
        # the straight sides of the lane
        t = (y - ay - lane.ny) * lane.per_dy
        if 0 <= t <= 1:
            x = ax + lane.nx + t * dx
            left, right = min(left, x), max(right, x)
        t = (y - ay + lane.ny) * lane.per_dy
        if 0 <= t <= 1:
            x = ax - lane.nx + t * dx
            left, right = min(left, x), max(right, x)
    return left, right


@always_inline
def in_sight(line: Line, near: float, reach: float, square: int, i: int, s: Samples) -> bool:
    """Whether sample i is in range and not hidden somewhere on a leg; line: the leg as the sample sees it.

    near: a leg parameter in range, where sight is likeliest. Mostly one look from there is enough, and mostly the
    depths tell what comes of it. They change nothing of the answer.
    """
    cx, cy, corner, begin, end = s.x[i], s.y[i], s.origin[4], s.wall_start[i], s.wall_start[i + 1]
    walls, items, depth2, row = s.walls, s.wall_item, s.depth2, s.depth_row[i]
    qx, qy = line.px + near * line.dx, line.py + near * line.dy
    near2 = qx * qx + qy * qy
    if near2 < depth2[row, 0, int(sectors_from_x(qx, qy)) % DEPTH_SECTORS]:
        return True
    hidden = False
    for j in range(begin, end):
        k = items[j]
        ux, uy, vx, vy = walls[k, 0] - cx, walls[k, 1] - cy, walls[k, 2] - cx, walls[k, 3] - cy
        if end_of_hiding(near, ux, uy, vx, vy, line, corner) > near:
            hidden = True
            break
    if not hidden:
        return True
    if line.dx * line.dx + line.dy * line.dy < SAME_PLACE_M * SAME_PLACE_M:
        return False
    t, last = range_interval(line, reach, square)
    ex, ey = line.px + last * line.dx, line.py + last * line.dy
    if hides_all(line.px + t * line.dx, line.py + t * line.dy, ex, ey, near2, depth2, row):
        return False
    moved = True
    while moved:
        moved = False
        for j in range(begin, end):
            k = items[j]
            ux, uy, vx, vy = walls[k, 0] - cx, walls[k, 1] - cy, walls[k, 2] - cx, walls[k, 3] - cy
            until = end_of_hiding(t, ux, uy, vx, vy, line, corner)
            if until > t:
                if until >= last:
                    return False
                t = until + 1e-12
                moved = True
    return True


@noinline
def leg_sees(leg: Leg, period_class: int, s: Samples, out: Any) -> int:
    """Write what the leg sees of the samples of this period class or a longer one: first index, one past the last.

    Returns how many numbers it wrote to ``out``, two for each run, or -1 if that is short. No two runs share a sample.
    """
    written = lattice_runs(leg, period_class, s, out)
    if written < 0:
        return written
    return loose_runs(leg, period_class, s, out, written)


@allocation_free
def lattice_runs(leg: Leg, period_class: int, s: Samples, out: Any) -> int:
    """The part of ``leg_sees`` that lies on lattices."""
    dx, dy = leg.bx - leg.ax, leg.by - leg.ay
    aa = dx * dx + dy * dy
    per_aa = 1 / aa if aa >= SAME_PLACE_M * SAME_PLACE_M else 0.0
    per_dy = 1 / dy if dy != 0.0 else 0.0
    per_leg = 1 / math.sqrt(aa) if aa > 0 else 0.0
    written = 0
    for f in range(s.frames.shape[0]):
        r = leg.reach - s.frames[f, 3]
        if s.frame_ints[f, 0] < period_class or r < 0:
            continue
        lane = Lane(leg.ax, leg.ay, dx, dy, per_dy, -dy * per_leg * r, dx * per_leg * r, r)
        written = frame_runs(f, leg, lane, per_aa, s, out, np.int64(written))
        if written < 0:
            return -1
    return written


@noinline
def frame_runs(f: int, leg: Leg, lane: Lane, per_aa: float, s: Samples, out: Any, written: int) -> int:
    """The part that lies on lattice f, row by row; samples are asked one by one only where walls are near."""
    xs, ys, next_walled, column_start, square = s.x, s.y, s.next_walled, s.column_start, leg.square
    left, low, step = s.frames[f, 0], s.frames[f, 1], s.frames[f, 2]
    rows, columns, table = s.frame_ints[f, 1], s.frame_ints[f, 2], s.frame_ints[f, 3]
    row0 = max(0, math.ceil((min(leg.ay, leg.by) - lane.r - low) / step))
    row1 = min(rows - 1, math.floor((max(leg.ay, leg.by) + lane.r - low) / step))
    if max(leg.ax, leg.bx) + lane.r < left or min(leg.ax, leg.bx) - lane.r > left + columns * step:
        return written
    per_step, room = 1 / step, out.shape[0] - 1
    for row in range(row0, row1 + 1):
        y = low + row * step
        if square:
            x0, x1 = square_row(lane, y)
        else:
            x0, x1 = disc_row(lane, y)
        if x0 > x1 or x1 < left or x0 > left + columns * step:
            continue
        c0 = max(0, math.ceil((x0 - left) * per_step))
        c1 = min(columns, math.floor((x1 - left) * per_step) + 1)
        if c0 >= c1:
            continue
        at = table + row * (columns + 1)
        i, end = np.int64(column_start[at + c0]), np.int64(column_start[at + c1])
        while i < end:
            until = min(end, next_walled[i])
            if until == i:
                line = Line(leg.ax - xs[i], leg.ay - ys[i], lane.dx, lane.dy)
                t = nearest_in_range(line, per_aa, lane.r, square, ON_LINE_M)
                if t < 0 or not in_sight(line, t, lane.r, square, i, s):
                    i += 1
                    continue
                until = i + 1
            if written > 0 and out[written - 1] == i:
                out[written - 1] = until
            else:
                if written >= room:
                    return -1
                out[written], out[written + 1] = i, until
                written += 2
            i = until
    return written


@noinline
def loose_runs(leg: Leg, period_class: int, s: Samples, out: Any, written: int) -> int:
    """The part of ``leg_sees`` that lies on no lattice, bin by bin; ``written`` numbers are in ``out`` already."""
    # local names: the loop below runs over everything near every leg that is ever tried
    xs, ys, period, visit, shrink = s.x, s.y, s.period, s.visit_m, s.shrink_m
    wall_start, bin_start = s.wall_start, s.bin_start
    left, low, cell = s.origin[0], s.origin[1], s.origin[2]
    columns, rows = s.bins[0], s.bins[1]
    far = max(leg.reach * (1.4142135623730951 if leg.square else 1.0), s.origin[3])
    x0 = max(0, int((min(leg.ax, leg.bx) - far - left) / cell))
    x1 = min(columns - 1, int((max(leg.ax, leg.bx) + far - left) / cell))
    y0 = max(0, int((min(leg.ay, leg.by) - far - low) / cell))
    y1 = min(rows - 1, int((max(leg.ay, leg.by) + far - low) / cell))
    dx, dy = leg.bx - leg.ax, leg.by - leg.ay
    aa = dx * dx + dy * dy
    per_aa = 1 / aa if aa >= SAME_PLACE_M * SAME_PLACE_M else 0.0
    room = out.shape[0] - 1
    if x0 > x1:
        return written
    for row in range(y0, y1 + 1):
        # the bins of a row follow each other, and most are empty
        for i in range(bin_start[row * columns + x0], bin_start[row * columns + x1 + 1]):
            if period[i] < period_class:
                continue
            line = Line(leg.ax - xs[i], leg.ay - ys[i], dx, dy)
            r, wide = leg.reach - shrink[i], leg.square
            if visit[i] > 0:
                r, wide = visit[i], 0
            t = nearest_in_range(line, per_aa, r, wide, 0.0)
            if t < 0:
                continue
            if visit[i] == 0 and wall_start[i + 1] > wall_start[i] and not in_sight(line, t, r, wide, i, s):
                continue
            if written > 0 and out[written - 1] == i:
                out[written - 1] = i + 1
                continue
            if written >= room:
                return -1
            out[written], out[written + 1] = i, i + 1
            written += 2
    return written

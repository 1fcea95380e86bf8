# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the sweep round one point, the origin: walls cut to a frame, and which is nearest where."""

from __future__ import annotations

from math import hypot, inf

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.geometry.kernels import TOUCH_M


@allocation_free
def is_inside(walls):
    """Whether the origin lies to the left of the walls: crossing parity of the ray to the right."""
    odd = False
    for k in range(len(walls)):
        y0, y1 = walls[k, 1], walls[k, 3]
        if (y0 <= 0.0) != (y1 <= 0.0) and (walls[k, 0] * y1 - walls[k, 2] * y0 > 0.0) == (y1 > y0):
            odd = not odd
    return odd


@allocation_free
def _clip(x0, y0, x1, y1, frame):
    """Parameters of the part of the wall inside the convex frame (sides with the inside on the left)."""
    first, last = 0.0, 1.0
    for k in range(len(frame)):
        fx, fy = frame[k, 2] - frame[k, 0], frame[k, 3] - frame[k, 1]
        d0 = fx * (y0 - frame[k, 1]) - fy * (x0 - frame[k, 0])
        d1 = fx * (y1 - frame[k, 1]) - fy * (x1 - frame[k, 0])
        if d0 < 0.0 and d1 < 0.0:
            return 1.0, 0.0
        if d0 < 0.0:
            first = max(first, d0 / (d0 - d1))
        elif d1 < 0.0:
            last = min(last, d0 / (d0 - d1))
    return first, last


@allocation_free
def lines_in_frame(walls, frame, lines, rays):
    """Fill lines with the walls inside the frame, turning left round the origin; return how many, and how many rays.

    Walls that touch the origin become rays instead: a direction, and 1 where the obstacle begins there (turning left)
    or 0 where it ends.
    """
    count, touching = 0, 0
    for k in range(len(walls)):
        x0, y0, x1, y1 = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        wx, wy = x1 - x0, y1 - y0
        s = min(max(-(x0 * wx + y0 * wy) / (wx * wx + wy * wy), 0.0), 1.0)
        if hypot(x0 + s * wx, y0 + s * wy) <= TOUCH_M:
            for end in range(2):
                x, y = walls[k, 2 * end], walls[k, 2 * end + 1]
                if hypot(x, y) > TOUCH_M:
                    rays[touching, 0], rays[touching, 1], rays[touching, 2] = x, y, end
                    touching += 1
            continue
        turn = x0 * y1 - y0 * x1
        first, last = _clip(x0, y0, x1, y1, frame)
        # a wall seen along its own line hides nothing
        if first >= last or abs(turn) <= TOUCH_M * hypot(wx, wy):
            continue
        if last < 1.0:
            x1, y1 = x0 + last * wx, y0 + last * wy
        if first > 0.0:
            x0, y0 = x0 + first * wx, y0 + first * wy
        if turn < 0.0:
            x0, y0, x1, y1 = x1, y1, x0, y0
        lines[count, 0], lines[count, 1], lines[count, 2], lines[count, 3] = x0, y0, x1, y1
        count += 1
    return count, touching


@kernel
def nearest_lines(lines, first, last, ux, uy):
    """For each sector with middle direction (ux, uy) the line nearest to the origin, -1 without one.

    Line k, which turns left, spans the sectors from first[k] up to, but not including, last[k]. Lines meet at their
    ends only, so that the middle of a sector decides for all of it.
    """
    count = len(ux)
    nearest, depth = np.full(count, -1, np.int64), np.full(count, inf)
    for k in range(len(lines)):
        wx, wy = lines[k, 2] - lines[k, 0], lines[k, 3] - lines[k, 1]
        turn = lines[k, 0] * wy - lines[k, 1] * wx
        sector = first[k]
        while sector != last[k]:
            across = ux[sector] * wy - uy[sector] * wx
            if across > 0.0 and turn < depth[sector] * across:
                depth[sector] = turn / across
                nearest[sector] = k
            sector = sector + 1 if sector + 1 < count else 0
    return nearest

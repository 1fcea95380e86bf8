"""Compiled loops: for every sample the leg that sees it with most to spare, and from where."""

from __future__ import annotations

import math
from typing import Any

from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.sight_kernels import STANDING_M2, Line, compiled, hidden_until, norm, range_interval


@compiled
def range_at(px: float, py: float, dx: float, dy: float, t: float, square: int) -> Any:
    """Range of a sensor that takes in the origin from p + t d: a radius, or half a side."""
    x, y = px + t * dx, py + t * dy
    return max(abs(x), abs(y)) if square else norm(x, y)


@compiled
def nearest_parameter(px: float, py: float, dx: float, dy: float, square: int) -> float:
    """The leg parameter in 0..1 at which p + t d is nearest to the origin, as the sensor measures it."""
    aa = dx * dx + dy * dy
    if aa < STANDING_M2:
        return 0.0
    best = min(1.0, max(0.0, -(px * dx + py * dy) / aa))
    if not square:
        return best
    least = range_at(px, py, dx, dy, best, square)
    for which in range(6):
        # the ends, where the leg crosses the axes, and where it crosses the diagonals
        over, under = (0.0, 1.0)
        if which == 1:
            over = 1.0
        elif which == 2:
            over, under = -px, dx
        elif which == 3:
            over, under = -py, dy
        elif which == 4:
            over, under = py - px, dx - dy
        elif which == 5:
            over, under = -py - px, dx + dy
        if abs(under) < 1e-12:
            continue
        t = min(1.0, max(0.0, over / under))
        here = range_at(px, py, dx, dy, t, square)
        if here < least:
            least, best = here, t
    return best


@compiled
def clear_from(
    px: float, py: float, dx: float, dy: float, t: float, last: float, cx: float, cy: float, i: int, s: Samples
) -> float:
    """The first leg parameter from t on, before ``last``, from which sample i, at c, is not hidden; inf: none is."""
    corner = s.origin[4]
    moved = True
    while moved:
        moved = False
        for j in range(s.wall_start[i], s.wall_start[i + 1]):
            k = s.wall_item[j]
            ux, uy = s.walls[k, 0] - cx, s.walls[k, 1] - cy
            vx, vy = s.walls[k, 2] - cx, s.walls[k, 3] - cy
            until = hidden_until(t, ux, uy, vx, vy, Line(px, py, dx, dy), corner)
            if until > t:
                if until >= last:
                    return math.inf
                t = until + 1e-12
                moved = True
    return t


@compiled
def clear_sighting(
    ax: float, ay: float, dx: float, dy: float, near: float, reach: float, square: int, i: int, s: Samples
) -> float:
    """The leg parameter nearest to ``near`` from which sample i is not hidden, of a leg from a along d that sees it."""
    cx, cy = s.x[i], s.y[i]
    px, py = ax - cx, ay - cy
    first, last = range_interval(Line(px, py, dx, dy), reach, square)
    after: float = clear_from(px, py, dx, dy, near, max(near, last), cx, cy, i, s)
    if after == near:
        return near
    # the same leg from its other end
    before: float = 1 - clear_from(px + dx, py + dy, -dx, -dy, 1 - near, max(1 - near, 1 - first), cx, cy, i, s)
    if not math.isfinite(after):
        return before if math.isfinite(before) else near
    if not math.isfinite(before):
        return after
    nearer = range_at(px, py, dx, dy, before, square) < range_at(px, py, dx, dy, after, square)
    return before if nearer else after


@compiled
def best_sightings(
    legs: Any, period_class: Any, reach: Any, square: Any, further: float, s: Samples,
    runs: Any, leg: Any, at: Any, lack: Any,
) -> int:  # fmt: skip
    """For every sample (n,) the leg and the parameter from which it is seen with most range to spare; -1: from none.

    legs (m, 4): from and to; period_class, reach, square (m,) of their robots. further: legs count from
    which a sample would be in range if sensors reached so much further. lack (n,): by how much range is short, less
    than 0 where it is not. Returns -1 when ``runs`` is too short for what one leg sees.
    """
    xs, ys, visit, shrink, wall_start = s.x, s.y, s.visit_m, s.shrink_m, s.wall_start
    for i in range(leg.shape[0]):
        leg[i], at[i], lack[i] = -1, 0.0, math.inf
    for k in range(legs.shape[0]):
        ax, ay, bx, by = legs[k, 0], legs[k, 1], legs[k, 2], legs[k, 3]
        dx, dy = bx - ax, by - ay
        found = leg_sees(Leg(ax, ay, bx, by, reach[k] + further, square[k]), period_class[k], s, runs)
        if found < 0:
            return -1
        for run in range(0, found, 2):
            for i in range(runs[run], runs[run + 1]):
                px, py = ax - xs[i], ay - ys[i]
                wide, limit = square[k], reach[k] - shrink[i]
                if visit[i] > 0:
                    wide, limit = 0, visit[i]
                t = nearest_parameter(px, py, dx, dy, wide)
                short = range_at(px, py, dx, dy, t, wide) - limit
                if short >= lack[i]:
                    continue
                if visit[i] == 0 and wall_start[i] < wall_start[i + 1]:
                    # never nearer than where walls are left aside
                    t = clear_sighting(ax, ay, dx, dy, t, reach[k] + further, wide, i, s)
                    short = range_at(px, py, dx, dy, t, wide) - limit
                if short < lack[i]:
                    leg[i], at[i], lack[i] = k, t, short
    return 0

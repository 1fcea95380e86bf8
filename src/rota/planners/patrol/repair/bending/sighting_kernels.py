"""Compiled loops: for every sample the legs that see it with most to spare, and from where."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.sight_kernels import (
    Line,
    end_of_hiding,
    norm,
    range_interval,
)
from rota.planners.patrol.tolerances import SAME_PLACE_M


@allocation_free
def range_at(px: float, py: float, dx: float, dy: float, t: float, square: int) -> Any:
    """Range of a sensor that takes in the origin from p + t d: a radius, or half a side."""
    x, y = px + t * dx, py + t * dy
    return max(abs(x), abs(y)) if square else norm(x, y)


@allocation_free
def nearest_parameter(px: float, py: float, dx: float, dy: float, square: int) -> float:
    """The leg parameter in 0..1 at which p + t d is nearest to the origin, as the sensor measures it."""
    aa = dx * dx + dy * dy
    if aa < SAME_PLACE_M * SAME_PLACE_M:
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
        range_m = range_at(px, py, dx, dy, t, square)
        if range_m < least:
            least, best = range_m, t
    return best


class SensingLegs(NamedTuple):
    """The legs of all tours, with the sensors that go along them.

    ends_m: (m, 4) from and to. period_class: (m,) shortest class that counts as seen. reach_m: (m,). square: (m,) 1
    where the sensor is a square.
    """

    ends_m: Floats
    period_class: Ints
    reach_m: Floats
    square: Ints


class Sightings(NamedTuple):
    """For every sample the legs (n, c) that see it with most range to spare, the best first, and from where (0 to 1).

    range_deficit_m (n, c): by how much range is short; less than 0 where the sample is seen. Where fewer legs come near
    it is inf, and the leg is -1.
    """

    leg: Ints
    at: Floats
    range_deficit_m: Floats


@allocation_free
def clear_from(line: Line, t: float, last: float, i: int, s: Samples) -> float:
    """The first leg parameter from t on, before ``last``, from which sample i is not hidden; inf: none is."""
    corner = s.origin[4]
    cx, cy = s.x[i], s.y[i]
    moved = True
    while moved:
        moved = False
        for j in range(s.wall_start[i], s.wall_start[i + 1]):
            k = s.wall_item[j]
            ux, uy = s.walls[k, 0] - cx, s.walls[k, 1] - cy
            vx, vy = s.walls[k, 2] - cx, s.walls[k, 3] - cy
            until = end_of_hiding(t, ux, uy, vx, vy, line, corner)
            if until > t:
                if until >= last:
                    return math.inf
                t = until + 1e-12
                moved = True
    return t


@allocation_free
def clear_sighting(line: Line, near: float, reach_m: float, square: int, i: int, s: Samples) -> float:
    """The leg parameter nearest to ``near`` from which sample i is not hidden, of a leg that sees it."""
    px, py, dx, dy = line
    first, last = range_interval(line, reach_m, square)
    after: float = clear_from(line, near, max(near, last), i, s)
    if after == near:
        return near
    # the same leg from its other end
    before: float = 1 - clear_from(Line(px + dx, py + dy, -dx, -dy), 1 - near, max(1 - near, 1 - first), i, s)
    if not math.isfinite(after):
        return before if math.isfinite(before) else near
    if not math.isfinite(before):
        return after
    nearer = range_at(px, py, dx, dy, before, square) < range_at(px, py, dx, dy, after, square)
    return before if nearer else after


@allocation_free
def meets_at_its_end(leg: Ints, at: Floats, i: int, k: int) -> bool:
    """Whether the leg before leg k sees sample i from its end, which is where k begins."""
    meets = False
    for c in range(leg.shape[1]):
        meets = meets or (leg[i, c] == k - 1 and at[i, c] == 1)
    return meets


@allocation_free
def best_sightings(legs: SensingLegs, further_m: float, s: Samples, runs: Any, best: Sightings) -> int:
    """Write for every sample the legs (n, c) and the places from which it is seen with most range to spare.

    further_m: legs count from which a sample would be in range if sensors reached so much further. runs: (r,) scratch.
    Returns -1 when ``runs`` is too short for what one leg sees, otherwise 0.
    """
    xs, ys, visit, shrink, wall_start = s.x, s.y, s.visit_m, s.shrink_m, s.wall_start
    leg, at, deficit = best.leg, best.at, best.range_deficit_m
    ends, reach, square = legs.ends_m, legs.reach_m, legs.square
    last = leg.shape[1] - 1
    for i in range(leg.shape[0]):
        for c in range(last + 1):
            leg[i, c], at[i, c], deficit[i, c] = -1, 0.0, math.inf
    for k in range(ends.shape[0]):
        ax, ay, bx, by = ends[k, 0], ends[k, 1], ends[k, 2], ends[k, 3]
        dx, dy = bx - ax, by - ay
        numbers = leg_sees(Leg(ax, ay, bx, by, reach[k] + further_m, square[k]), legs.period_class[k], s, runs)
        if numbers < 0:
            return -1
        for run in range(0, numbers, 2):
            for i in range(runs[run], runs[run + 1]):
                px, py = ax - xs[i], ay - ys[i]
                wide, limit = square[k], reach[k] - shrink[i]
                if visit[i] > 0:
                    wide, limit = 0, visit[i]
                t = nearest_parameter(px, py, dx, dy, wide)
                short = range_at(px, py, dx, dy, t, wide) - limit
                if short >= deficit[i, last]:
                    continue
                if visit[i] == 0 and wall_start[i] < wall_start[i + 1]:
                    # never nearer than where walls are left aside
                    t = clear_sighting(Line(px, py, dx, dy), t, reach[k] + further_m, wide, i, s)
                    short = range_at(px, py, dx, dy, t, wide) - limit
                if short < deficit[i, last] and not (t == 0 and meets_at_its_end(leg, at, i, k)):
                    c = last
                    while c > 0 and short < deficit[i, c - 1]:
                        leg[i, c], at[i, c], deficit[i, c] = leg[i, c - 1], at[i, c - 1], deficit[i, c - 1]
                        c -= 1
                    leg[i, c], at[i, c], deficit[i, c] = k, t, short
    return 0

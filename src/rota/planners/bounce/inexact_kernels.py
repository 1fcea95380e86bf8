# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop of discs that drive straight in the plane and turn inexactly at contacts, from one contact to the next.

The rim of walls and corners is that of ``polygon_kernels``. Nothing is rounded to headings or cells; cells only tell
where a robot's centre has been.
"""

from __future__ import annotations

from math import cos, floor, inf, log, pi, sin, sqrt

import numpy as np
from numba import njit

from rota.planners.bounce.polygon_kernels import APPROACH, TOUCH_M, first_contact, is_blocked, place_on

BOUNDED, GAUSSIAN = 0, 1
CORNER = 1e-9  # of a straight way's length
MOST_VISITS = 256  # of a zone in one straight stretch, by all robots
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_SHIFT_1, _SHIFT_2, _SHIFT_3, _SHIFT_DOUBLE = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@njit(cache=True, nogil=True)
def _uniform(random):
    """The next number of splitmix64 in 0..1; random: (1,) its state."""
    random[0] += _GOLDEN
    z = (random[0] ^ (random[0] >> _SHIFT_1)) * _MIX_1
    z = (z ^ (z >> _SHIFT_2)) * _MIX_2
    return float((z ^ (z >> _SHIFT_3)) >> _SHIFT_DOUBLE) * 2.0**-53


@njit(cache=True, nogil=True)
def _error(random, size, shape):
    """The error of one turn in radians."""
    if size == 0.0:
        return 0.0
    if shape == BOUNDED:
        return size * (2 * _uniform(random) - 1)
    return size * sqrt(-2 * log(1 - _uniform(random))) * cos(2 * pi * _uniform(random))


@njit(cache=True, nogil=True)
def _mark(x, y, u, v, begin_s, end_s, corner_x, corner_y, cell_m, number, entered_s):
    """Note when a straight way from (x, y) to (u, v) enters cells not entered before; returns how many."""
    rows, columns = number.shape
    px, py, qx, qy = (x - corner_x) / cell_m, (y - corner_y) / cell_m, (u - corner_x) / cell_m, (v - corner_y) / cell_m
    column, row = floor(px), floor(py)
    left = abs(floor(qx) - column) + abs(floor(qy) - row)
    dx, dy = qx - px, qy - py
    step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    next_x = ((column + (step_x > 0)) - px) / dx if dx != 0 else inf
    next_y = ((row + (step_y > 0)) - py) / dy if dy != 0 else inf
    new, share = 0, 0.0
    while True:
        if 0 <= column < columns and 0 <= row < rows and number[row, column] >= 0:
            cell = number[row, column]
            at_s = begin_s + min(share, 1.0) * (end_s - begin_s)
            new += entered_s[cell] == inf
            entered_s[cell] = min(entered_s[cell], at_s)  # another robot may come there later in the same stretch
        if left == 0:
            return new
        left -= 1
        if abs(next_x - next_y) < CORNER and left > 0:  # through a corner: the cells beside it are not entered
            left -= 1
            share = next_x
            next_x += abs(1 / dx)
            next_y += abs(1 / dy)
            column += step_x
            row += step_y
        elif next_x < next_y:
            share = next_x
            next_x += abs(1 / dx)
            column += step_x
        else:
            share = next_y
            next_y += abs(1 / dy) if dy != 0 else inf
            row += step_y


@njit(cache=True, nogil=True)
def _is_inside(x, y, sides):
    """Whether a point is inside rings given as sides (k, 4), by counting those to its right."""
    inside = False
    for k in range(len(sides)):
        x0, y0, x1, y1 = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside


@njit(cache=True, nogil=True)
def _note_visits(x, y, u, v, begin_s, end_s, sides, cuts, visits, count):
    """Append to visits (n, 2) when a straight way, or a stay, is within a zone's sides; returns how many there are."""
    found = 0
    for k in range(len(sides)):
        ax, ay, bx, by = sides[k, 0], sides[k, 1], sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1]
        across = (u - x) * by - (v - y) * bx
        if across == 0 or found >= len(cuts) - 2:
            continue
        along = ((ax - x) * by - (ay - y) * bx) / across
        beside = ((ax - x) * (v - y) - (ay - y) * (u - x)) / across
        if 0 < along < 1 and 0 <= beside <= 1:
            cuts[found] = along
            found += 1
    cuts[found] = 1.0
    ends = np.sort(cuts[: found + 1])
    before = 0.0
    for k in range(len(ends)):
        middle = (before + ends[k]) / 2
        if _is_inside(x + middle * (u - x), y + middle * (v - y), sides) and count < len(visits):
            visits[count, 0] = begin_s + before * (end_s - begin_s)
            visits[count, 1] = begin_s + ends[k] * (end_s - begin_s)
            count += 1
        before = ends[k]
    return count


@njit(cache=True, nogil=True)
def _watch(visits, count, period_s, end_s, known_until, watched_s, z):
    """Add to the zone's time in which it had been visited within a period; known_until: (z,) up to when that is told.

    Only times from the first period on count, up to end_s.
    """
    for k in range(count):
        earliest = k
        for j in range(k + 1, count):
            if visits[j, 0] < visits[earliest, 0]:
                earliest = j
        first, last = visits[earliest, 0], visits[earliest, 1]
        visits[earliest, 0], visits[earliest, 1] = visits[k, 0], visits[k, 1]
        low = max(first, known_until[z], period_s)
        high = min(last + period_s, end_s)
        if high > low:
            watched_s[z] += high - low
        known_until[z] = max(known_until[z], last + period_s)


@njit(cache=True, nogil=True)
def _begin(i, now_s, rim, kind, radius, x, y, heading, moving, dx, dy, until_s, contact, speed, turning):
    """Let robot i go on: straight, or with another turn where a wall that it touches is in the way.

    turning: (angle, error, shape, seconds of a turn, random state).
    """
    angle, error, shape, turn_s, random = turning
    dx[i], dy[i] = cos(heading[i]), sin(heading[i])
    blocked = is_blocked(rim, kind, radius, x[i], y[i], dx[i], dy[i])
    if blocked:
        _turn(i, now_s, heading, moving, until_s, angle, error, shape, turn_s, random)
        return
    e, s, way = first_contact(rim, kind, radius, x[i], y[i], dx[i], dy[i])
    moving[i] = True
    contact[i, 0], contact[i, 1] = e, s
    until_s[i] = now_s + way / speed if e >= 0 else inf


@njit(cache=True, nogil=True)
def _turn(i, now_s, heading, moving, until_s, angle, error, shape, turn_s, random):
    """Let robot i turn."""
    heading[i] = (heading[i] + angle[i] + _error(random, error, shape)) % (2 * pi)
    moving[i] = False
    until_s[i] = now_s + turn_s


@njit(cache=True, nogil=True)
def _meeting(m, x, y, dx, dy, moving, speed, apart):
    """The soonest contact of two robots on their present ways: seconds until then, and both; inf: there is none."""
    best, first, second = inf, -1, -1
    for i in range(m):
        for j in range(i):
            if not (moving[i] or moving[j]):
                continue
            gx, gy = x[i] - x[j], y[i] - y[j]
            vx = speed * ((dx[i] if moving[i] else 0.0) - (dx[j] if moving[j] else 0.0))
            vy = speed * ((dy[i] if moving[i] else 0.0) - (dy[j] if moving[j] else 0.0))
            b, a = gx * vx + gy * vy, vx * vx + vy * vy
            if b >= -APPROACH * speed * max(apart[i, j], TOUCH_M) or apart[i, j] <= 0:
                continue
            under = b * b - a * (gx * gx + gy * gy - apart[i, j] ** 2)
            if under <= 0:
                continue
            wait = max((-b - sqrt(under)) / a, 0.0)
            if wait < best:
                best, first, second = wait, i, j
    return best, first, second


@njit(cache=True, nogil=True)
def _watch_zones(
    x, y, dx, dy, moving, speed, now_s, then_s, zone_sides, zone_first, periods_s, duration_s, cuts, visits,
    known_until, watched_s,
):  # fmt: skip
    """Note from now_s to then_s who is in which zone; watched_s: (z,) of this run, see ``_watch``."""
    for z in range(len(periods_s)):
        count = 0
        for i in range(len(x)):
            way = speed * (then_s - now_s) if moving[i] else 0.0
            count = _note_visits(
                x[i], y[i], x[i] + way * dx[i], y[i] + way * dy[i], now_s, then_s,
                zone_sides[zone_first[z] : zone_first[z + 1]], cuts, visits, count,
            )  # fmt: skip
        _watch(visits, count, periods_s[z], duration_s, known_until, watched_s, z)


@njit(cache=True, nogil=True)
def run_inexact(
    rim, kind, radius, apart, angle, error, shape, speed, turn_s, duration_s,
    starts, seeds, corner_x, corner_y, cell_m, number, zone_sides, zone_first, periods_s, entered_s, watched_s,
):  # fmt: skip
    """Let a team drive once for each row of ``starts`` (r, m, 3): x, y, heading.

    apart: (m, m) distance of centres at which two bodies touch; angle: (m,) bouncing angles; error, shape: of each
    turn; turn_s: what a turn takes, above 0. number: (rows, columns) of cells, -1 where there is none; entered_s
    (r, n), written: when any centre first entered each cell, inf: not in duration_s. zone_sides: (k, 4) of all zones,
    those of zone z from zone_first[z] on; watched_s (r, z), written: see ``_watch``. A run without zones ends when all
    cells were entered.
    """
    runs, m = starts.shape[0], starts.shape[1]
    zones = len(periods_s)
    x, y, heading = np.empty(m), np.empty(m), np.empty(m)
    dx, dy, until_s = np.empty(m), np.empty(m), np.empty(m)
    moving, contact = np.empty(m, np.bool_), np.empty((m, 2))
    random = np.empty(1, np.uint64)
    known_until, cuts, visits = np.empty(zones), np.empty(64), np.empty((MOST_VISITS, 2))
    for r in range(runs):
        random[0] = seeds[r]
        entered_s[r, :], watched_s[r, :], known_until[:] = inf, 0.0, 0.0
        left, now_s = entered_s.shape[1], 0.0
        turning = (angle, error, shape, turn_s, random)
        x[:], y[:], heading[:] = starts[r, :, 0], starts[r, :, 1], starts[r, :, 2]
        for i in range(m):
            left -= _mark(x[i], y[i], x[i], y[i], 0.0, 0.0, corner_x, corner_y, cell_m, number, entered_s[r])
            _begin(i, 0.0, rim, kind, radius, x, y, heading, moving, dx, dy, until_s, contact, speed, turning)
        while now_s < duration_s and (zones > 0 or left > 0):
            wait, one, other = _meeting(m, x, y, dx, dy, moving, speed, apart)
            then_s = min(now_s + wait, duration_s)
            event = -1
            for i in range(m):
                if until_s[i] <= then_s:  # before robots that touch: turns that end together do so for both
                    then_s, event = until_s[i], i
            _watch_zones(
                x, y, dx, dy, moving, speed, now_s, then_s, zone_sides, zone_first, periods_s, duration_s,
                cuts, visits, known_until, watched_s[r],
            )  # fmt: skip
            for i in range(m):
                if moving[i]:
                    way = speed * (then_s - now_s)
                    u, v = x[i] + way * dx[i], y[i] + way * dy[i]
                    left -= _mark(x[i], y[i], u, v, now_s, then_s, corner_x, corner_y, cell_m, number, entered_s[r])
                    x[i], y[i] = u, v
            now_s = then_s
            if event >= 0:
                if moving[event]:
                    e, s = int(contact[event, 0]), contact[event, 1]
                    x[event], y[event], _, _ = place_on(rim, kind, radius, e, s)
                    _turn(event, now_s, heading, moving, until_s, angle, error, shape, turn_s, random)
                else:
                    _begin(
                        event, now_s, rim, kind, radius, x, y, heading, moving, dx, dy, until_s, contact, speed,
                        turning,
                    )  # fmt: skip
            elif one >= 0 and now_s < duration_s:
                for i in (one, other):
                    if moving[i]:
                        _turn(i, now_s, heading, moving, until_s, angle, error, shape, turn_s, random)

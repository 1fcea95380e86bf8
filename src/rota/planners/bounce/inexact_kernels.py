# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop of discs that drive straight in the plane and turn inexactly at contacts, from one contact to the next.

The rim of walls and corners is that of ``polygon_kernels``. Nothing is rounded to headings or cells; cells only tell
where a robot's centre has been.
"""

from __future__ import annotations

from math import cos, floor, inf, log, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import kernel
from rota.model.arrays import Flags, Floats, Ints
from rota.planners.bounce.polygon_kernels import APPROACH, TOUCH_M, first_contact, is_blocked, place_on

BOUNDED, GAUSSIAN = 0, 1
CORNER = 1e-9  # a way that passes a corner of cells by less than this share of its length goes through it
MOST_VISITS = 256  # of a zone in one straight stretch, by all robots
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_SHIFT_1, _SHIFT_2, _SHIFT_3, _SHIFT_DOUBLE = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


class Crew(NamedTuple):
    """How m robots drive and turn: touching distances of centres (m, m) metres, bouncing angles (m,) radians.

    speed_m_s: of all. turn_s: what a turn takes, above 0. error_rad, shape: of each turn, BOUNDED or GAUSSIAN.
    """

    apart_m: Floats
    angles_rad: Floats
    speed_m_s: float
    turn_s: float
    error_rad: float
    shape: int


class Robots(NamedTuple):
    """Where m robots are and what they do, (m,) each: places in metres, headings, unit directions of their ways.

    moving: whether each drives; it turns else. until_s: when that ends. contact: (m, 2) the rim element at the end of
    its way, and where on it.
    """

    x: Floats
    y: Floats
    heading: Floats
    dx: Floats
    dy: Floats
    moving: Flags
    until_s: Floats
    contact: Floats


class Lattice(NamedTuple):
    """Cells whose first entry is noted: corner of the first in metres, their side, and (rows, columns) numbers.

    The number is -1 where there is no cell.
    """

    corner_x: float
    corner_y: float
    cell_m: float
    number: Ints


class Zones(NamedTuple):
    """Zones that are watched: (k, 4) sides of all, those of zone z from first[z] to first[z + 1], and (z,) periods."""

    sides: Floats
    first: Ints
    periods_s: Floats


class Watching(NamedTuple):
    """Room to write to while zones are watched.

    cuts: room for crossings of one way. visits: (n, 2) room for from, to of visits in one stretch. known_until: (z,)
    seconds up to which it is decided whether a zone had been visited within its period.
    """

    cuts: Floats
    visits: Floats
    known_until: Floats


class Stretch(NamedTuple):
    """A straight way from (x, y) to (u, v) in metres, or a stay, between two times."""

    x: float
    y: float
    u: float
    v: float
    begin_s: float
    end_s: float


@kernel
def _uniform(random):
    """The next number of splitmix64 in 0..1; random: (1,) its state."""
    random[0] += _GOLDEN
    z = (random[0] ^ (random[0] >> _SHIFT_1)) * _MIX_1
    z = (z ^ (z >> _SHIFT_2)) * _MIX_2
    return float((z ^ (z >> _SHIFT_3)) >> _SHIFT_DOUBLE) * 2.0**-53


@kernel
def _error(random, size, shape):
    """The error of one turn in radians."""
    if size == 0.0:
        return 0.0
    if shape == BOUNDED:
        return size * (2 * _uniform(random) - 1)
    return size * sqrt(-2 * log(1 - _uniform(random))) * cos(2 * pi * _uniform(random))


@kernel
def _mark(stretch, lattice, entered_s):
    """Note in entered_s (n,) when a ``Stretch`` enters cells not entered before; returns how many."""
    x, y, u, v, begin_s, end_s = stretch
    corner_x, corner_y, cell_m, number = lattice
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


@kernel
def _is_inside(x, y, sides):
    """Whether a point is inside rings given as sides (k, 4), by counting those to its right."""
    inside = False
    for k in range(len(sides)):
        x0, y0, x1, y1 = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside


@kernel
def _note_visits(stretch, sides, watching, count):
    """Append when a ``Stretch`` is within a zone's sides (k, 4) to the ``count`` visits; returns their number."""
    x, y, u, v, begin_s, end_s = stretch
    cuts, visits = watching.cuts, watching.visits
    crossings = 0
    for k in range(len(sides)):
        ax, ay, bx, by = sides[k, 0], sides[k, 1], sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1]
        across = (u - x) * by - (v - y) * bx
        if across == 0 or crossings >= len(cuts) - 2:
            continue
        along = ((ax - x) * by - (ay - y) * bx) / across
        beside = ((ax - x) * (v - y) - (ay - y) * (u - x)) / across
        if 0 < along < 1 and 0 <= beside <= 1:
            cuts[crossings] = along
            crossings += 1
    cuts[crossings] = 1.0
    ends = np.sort(cuts[: crossings + 1])
    before = 0.0
    for k in range(len(ends)):
        middle = (before + ends[k]) / 2
        if _is_inside(x + middle * (u - x), y + middle * (v - y), sides) and count < len(visits):
            visits[count, 0] = begin_s + before * (end_s - begin_s)
            visits[count, 1] = begin_s + ends[k] * (end_s - begin_s)
            count += 1
        before = ends[k]
    return count


@kernel
def _watch(watching, count, period_s, end_s, watched_s, z):
    """Add to watched_s (z,) the time for which zone z had been visited within a period, by ``count`` visits.

    The visits are those of one stretch. Only times from the first period on count, up to end_s.
    """
    visits, known_until = watching.visits, watching.known_until
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


@kernel
def _begin(i, now_s, rim, robots, crew, random):
    """Let robot i go on: straight, or with another turn where a wall that it touches is in the way."""
    x, y, dx, dy = robots.x, robots.y, robots.dx, robots.dy
    dx[i], dy[i] = cos(robots.heading[i]), sin(robots.heading[i])
    if is_blocked(rim, x[i], y[i], dx[i], dy[i]):
        _turn(i, now_s, robots, crew, random)
        return
    e, s, way = first_contact(rim, x[i], y[i], dx[i], dy[i])
    robots.moving[i] = True
    robots.contact[i, 0], robots.contact[i, 1] = e, s
    robots.until_s[i] = now_s + way / crew.speed_m_s if e >= 0 else inf


@kernel
def _turn(i, now_s, robots, crew, random):
    """Let robot i turn."""
    error = _error(random, crew.error_rad, crew.shape)
    robots.heading[i] = (robots.heading[i] + crew.angles_rad[i] + error) % (2 * pi)
    robots.moving[i] = False
    robots.until_s[i] = now_s + crew.turn_s


@kernel
def _meeting(robots, crew):
    """The soonest contact of two robots on their present ways: seconds until then, and both robots; inf: none."""
    x, y, dx, dy, moving = robots.x, robots.y, robots.dx, robots.dy, robots.moving
    speed, apart = crew.speed_m_s, crew.apart_m
    best, first, second = inf, -1, -1
    for i in range(len(x)):
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


@kernel
def _ahead(i, robots, speed, now_s, then_s):
    """The place (x, y) in metres where robot i is at then_s if it goes on as it does at now_s."""
    way = speed * (then_s - now_s) if robots.moving[i] else 0.0
    return robots.x[i] + way * robots.dx[i], robots.y[i] + way * robots.dy[i]


@kernel
def _drive(robots, speed, now_s, then_s, lattice, entered_s):
    """Move all robots that drive; returns how many cells they enter that were not entered before."""
    new = 0
    for i in range(len(robots.x)):
        if robots.moving[i]:
            u, v = _ahead(i, robots, speed, now_s, then_s)
            new += _mark(Stretch(robots.x[i], robots.y[i], u, v, now_s, then_s), lattice, entered_s)
            robots.x[i], robots.y[i] = u, v
    return new


@kernel
def _watch_zones(robots, speed, now_s, then_s, zones, duration_s, watching, watched_s):
    """Note from now_s to then_s who is in which zone; watched_s: (z,) of this run, see ``_watch``."""
    for z in range(len(zones.periods_s)):
        sides, count = zones.sides[zones.first[z] : zones.first[z + 1]], 0
        for i in range(len(robots.x)):
            u, v = _ahead(i, robots, speed, now_s, then_s)
            count = _note_visits(Stretch(robots.x[i], robots.y[i], u, v, now_s, then_s), sides, watching, count)
        _watch(watching, count, zones.periods_s[z], duration_s, watched_s, z)


@kernel
def _act(event, touching, now_s, rim, robots, crew, random):
    """Let happen what is due at now_s: robot ``event`` ends its way or turn, or else both of ``touching`` turn."""
    if event >= 0:
        if robots.moving[event]:
            e, s = int(robots.contact[event, 0]), robots.contact[event, 1]
            robots.x[event], robots.y[event], _, _ = place_on(rim, e, s)
            _turn(event, now_s, robots, crew, random)
        else:
            _begin(event, now_s, rim, robots, crew, random)
        return
    for i in touching:
        if i >= 0 and robots.moving[i]:
            _turn(i, now_s, robots, crew, random)


@kernel
def run_inexact(rim, crew, duration_s, starts, seeds, lattice, zones, results):
    """Let a team drive once for each row of ``starts`` (r, m, 3): x, y, heading; seeds: (r,).

    rim: ``RimElements``; crew, lattice, zones: the named tuples above. results, written: entered_s (r, n), when any
    centre first entered each cell, inf: not in duration_s; watched_s (r, z), see ``_watch``; met_s (r,), when two
    bodies first touched, inf: never. A run without zones ends when all cells were entered.
    """
    entered_s, watched_s, met_s = results
    runs, m, n_zones, speed = starts.shape[0], starts.shape[1], len(zones.periods_s), crew.speed_m_s
    x, y, heading = np.empty(m), np.empty(m), np.empty(m)
    robots = Robots(x, y, heading, np.empty(m), np.empty(m), np.empty(m, np.bool_), np.empty(m), np.empty((m, 2)))
    random = np.empty(1, np.uint64)
    watching = Watching(np.empty(64), np.empty((MOST_VISITS, 2)), np.empty(n_zones))
    for r in range(runs):
        random[0] = seeds[r]
        entered_s[r, :], watched_s[r, :], watching.known_until[:], met_s[r] = inf, 0.0, 0.0, inf
        left, now_s = entered_s.shape[1], 0.0
        x[:], y[:], heading[:] = starts[r, :, 0], starts[r, :, 1], starts[r, :, 2]
        for i in range(m):
            left -= _mark(Stretch(x[i], y[i], x[i], y[i], 0.0, 0.0), lattice, entered_s[r])
            _begin(i, 0.0, rim, robots, crew, random)
        while now_s < duration_s and (n_zones > 0 or left > 0):
            wait, first, second = _meeting(robots, crew)
            then_s = min(now_s + wait, duration_s)
            event = -1
            for i in range(m):
                if robots.until_s[i] <= then_s:  # before robots that touch: turns that end together do so for both
                    then_s, event = robots.until_s[i], i
            _watch_zones(robots, speed, now_s, then_s, zones, duration_s, watching, watched_s[r])
            left -= _drive(robots, speed, now_s, then_s, lattice, entered_s[r])
            now_s = then_s
            if event < 0 and now_s < duration_s:
                met_s[r] = min(met_s[r], now_s)
            if event >= 0 or now_s < duration_s:
                _act(event, (first, second), now_s, rim, robots, crew, random)

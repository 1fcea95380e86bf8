# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Closed rounds of robots with limited accelerations: speeds at corners, times, and legs (compiled).

A corner is rounded by a parabola, on which a constant acceleration turns the velocity from one leg's direction into the
next one's. At the speed v, with half the turning angle h and the acceleration a it takes T = 2 v sin(h) / a, begins and
ends v T / 2 from the corner, and passes it at a T^2 / 8. Where jerk is limited, an acceleration is half as much at its
beginning and at its end, each for as long as the jerk takes to build it up: what is driven then keeps to the jerk, as
far as legs of constant acceleration can tell.

Speeds come from a pass forward and one backward (Bobrow, Dubowsky and Gibson, Int. J. of Robotics Research 4(3), 1985):
each corner is as fast as it allows, as the way from the corner before it allows, and as the way to the next one does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.planners.patrol.tolerances import BISECTIONS, SHORTEST_S, STRAIGHT, TIE


class Limits(NamedTuple):
    """What a robot keeps to. jerk_m_s3: inf where it is not limited. turn_s: seconds a radian, at stops."""

    speed_m_s: float
    along_m_s2: float
    corner_m_s2: float
    jerk_m_s3: float
    cut_m: float
    turn_s: float


class Heading(NamedTuple):
    """A place in metres and a unit vector in whose direction a robot drives there."""

    x: float
    y: float
    ux: float
    uy: float


@allocation_free
def change_s(change_m_s, most_m_s2, jerk_m_s3):
    """Seconds that a change of velocity by so much takes."""
    if change_m_s < most_m_s2 * most_m_s2 / jerk_m_s3:
        return 2 * math.sqrt(change_m_s / jerk_m_s3)
    return change_m_s / most_m_s2 + most_m_s2 / jerk_m_s3


@allocation_free
def ramp_m(from_m_s, to_m_s, limits):
    """Metres in which the speed changes from one to another."""
    return (from_m_s + to_m_s) / 2 * change_s(abs(to_m_s - from_m_s), limits.along_m_s2, limits.jerk_m_s3)


@allocation_free
def _corner_m_s2(sine, limits):
    """The greatest acceleration round a corner: where it leads straight back, its parabola is the way itself."""
    return limits.corner_m_s2 if sine < 1 - TIE else min(limits.corner_m_s2, limits.along_m_s2)


@allocation_free
def rounding(speed_m_s, sine, limits):
    """Of a corner passed at this speed: seconds, metres from the corner to either end, and how far off it passes.

    sine: of half the turning angle; a vertex that is no corner takes no time.
    """
    if sine < STRAIGHT:
        return 0.0, 0.0, 0.0
    change, jerk, most = 2 * speed_m_s * sine, limits.jerk_m_s3, _corner_m_s2(sine, limits)
    whole_s = change_s(change, most, jerk)
    peak = min(most, math.sqrt(change * jerk))
    half_s, rise_s = whole_s / 2, peak / jerk
    off_m = peak / 2 * rise_s * (half_s - rise_s / 2) + peak * (half_s - rise_s) ** 2 / 2
    return whole_s, speed_m_s * half_s, off_m


@allocation_free
def fastest_round(sine, shorter_m, limits):
    """The greatest speed at a corner whose shorter leg is so long."""
    if sine < STRAIGHT:
        return limits.speed_m_s
    if limits.cut_m == 0:
        return 0.0
    low, high = 0.0, limits.speed_m_s
    _, half_m, off_m = rounding(high, sine, limits)
    if half_m <= shorter_m / 2 * (1 - TIE) and off_m <= limits.cut_m:
        return high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        _, half_m, off_m = rounding(middle, sine, limits)
        if half_m <= shorter_m / 2 * (1 - TIE) and off_m <= limits.cut_m:
            low = middle
        else:
            high = middle
    return low


@allocation_free
def greatest_corner_speed(from_m_s, from_half_m, to_m_s, sine, leg_m, limits):
    """The greatest speed at a corner, of at most ``to_m_s``, that the leg leaves room for.

    The robot leaves the corner before at ``from_m_s``, whose rounding ends ``from_half_m`` from it.
    """
    if to_m_s <= from_m_s:
        return to_m_s
    low, high = from_m_s, to_m_s
    if from_half_m + rounding(high, sine, limits)[1] + ramp_m(from_m_s, high, limits) <= leg_m:
        return high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if from_half_m + rounding(middle, sine, limits)[1] + ramp_m(from_m_s, middle, limits) <= leg_m:
            low = middle
        else:
            high = middle
    return low


@allocation_free
def peak_m_s(from_m_s, to_m_s, room_m, limits):
    """The greatest speed on a way of ``room_m`` that begins and ends at these speeds."""
    high = limits.speed_m_s
    if ramp_m(from_m_s, high, limits) + ramp_m(high, to_m_s, limits) <= room_m:
        return high
    low = max(from_m_s, to_m_s)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if ramp_m(from_m_s, middle, limits) + ramp_m(middle, to_m_s, limits) <= room_m:
            low = middle
        else:
            high = middle
    return low


@allocation_free
def between_s(from_m_s, to_m_s, room_m, limits):
    """Seconds that a way of ``room_m`` takes that begins and ends at these speeds."""
    peak = peak_m_s(from_m_s, to_m_s, room_m, limits)
    ramps_m = ramp_m(from_m_s, peak, limits) + ramp_m(peak, to_m_s, limits)
    ramps_s = change_s(peak - from_m_s, limits.along_m_s2, limits.jerk_m_s3)
    ramps_s += change_s(peak - to_m_s, limits.along_m_s2, limits.jerk_m_s3)
    return ramps_s + max(0.0, room_m - ramps_m) / max(peak, 1e-12)


@kernel(noinline=True)
def corners_of(vertices_m, closed, limits):
    """A row for each vertex (n, 2) of a polyline: sine of half its turn, its speed, and the leg after it in metres.

    Where it is not closed, the robot begins and ends at rest; the leg after the last vertex then says nothing.
    """
    n = len(vertices_m)
    rows = np.empty((n, 3))
    for k in range(n):
        rows[k, 2] = math.hypot(
            vertices_m[(k + 1) % n, 0] - vertices_m[k, 0], vertices_m[(k + 1) % n, 1] - vertices_m[k, 1]
        )
    for k in range(n):
        before_m, after_m = rows[k - 1, 2], rows[k, 2]
        inner = (vertices_m[k] - vertices_m[k - 1]) * (vertices_m[(k + 1) % n] - vertices_m[k])
        cosine = (inner[0] + inner[1]) / max(before_m * after_m, 1e-300)
        rows[k, 0] = math.sqrt(max(0.0, (1 - cosine) / 2))
        rows[k, 1] = fastest_round(rows[k, 0], min(before_m, after_m), limits)
    if not closed:
        rows[0, :2], rows[n - 1, :2] = 0.0, 0.0
    for turn in range(2 * n):  # twice round, so that the first corner knows of those before it
        k = turn % n
        after = (k + 1) % n
        half_m = rounding(rows[k, 1], rows[k, 0], limits)[1]
        rows[after, 1] = greatest_corner_speed(rows[k, 1], half_m, rows[after, 1], rows[after, 0], rows[k, 2], limits)
    for turn in range(2 * n - 1, -1, -1):
        k = turn % n
        after = (k + 1) % n
        half_m = rounding(rows[after, 1], rows[after, 0], limits)[1]
        rows[k, 1] = greatest_corner_speed(rows[after, 1], half_m, rows[k, 1], rows[k, 0], rows[k, 2], limits)
    return rows


@kernel(noinline=True)
def round_s(vertices_m, limits):
    """Seconds of a round of a closed polyline (n, 2), n > 1."""
    rows = corners_of(vertices_m, True, limits)
    n, total_s = len(rows), 0.0
    for k in range(n):
        after = (k + 1) % n
        whole_s, half_m, _ = rounding(rows[k, 1], rows[k, 0], limits)
        next_half_m = rounding(rows[after, 1], rows[after, 0], limits)[1]
        room_m = max(0.0, rows[k, 2] - half_m - next_half_m)
        total_s += whole_s + between_s(rows[k, 1], rows[after, 1], room_m, limits)
        if limits.turn_s > 0:
            total_s += 2 * math.asin(min(1.0, rows[k, 0])) * limits.turn_s
    return total_s


@allocation_free
def _add_row(rows, n, x, y, in_s, acceleration):
    """Write a leg that ends at (x, y) after so long; one that takes next to no time is left to the next one.

    rows (m, 5): seconds, x, y, acceleration along the leg that ends there, and seconds not written yet. Returns how
    many there are.
    """
    whole_s = in_s + rows[n - 1, 4]
    if whole_s < SHORTEST_S or (x == rows[n - 1, 1] and y == rows[n - 1, 2] and in_s == 0.0):
        rows[n - 1, 4] = whole_s
        return n
    rows[n, 0], rows[n, 1], rows[n, 2], rows[n, 3], rows[n, 4] = rows[n - 1, 0] + whole_s, x, y, acceleration, 0.0
    return n + 1


@allocation_free
def _add_ramp(rows, n, at, from_m_s, to_m_s, limits):
    """Write a change of speed that begins at a heading: one leg, or three where jerk is limited."""
    x, y, ux, uy = at
    change = abs(to_m_s - from_m_s)
    whole_s = change_s(change, limits.along_m_s2, limits.jerk_m_s3)
    peak = min(limits.along_m_s2, math.sqrt(change * limits.jerk_m_s3))
    rise_s, sign = peak / limits.jerk_m_s3, 1.0 if to_m_s > from_m_s else -1.0
    speed, done_m = from_m_s, 0.0
    for part in range(3):
        in_s = whole_s - 2 * rise_s if part == 1 else rise_s
        if in_s <= 0:
            continue
        acceleration = sign * (peak if part == 1 else peak / 2)
        done_m += speed * in_s + acceleration * in_s * in_s / 2
        speed += acceleration * in_s
        n = _add_row(rows, n, x + ux * done_m, y + uy * done_m, in_s, acceleration)
    return n


@allocation_free
def _add_rounding(rows, n, at, towards, corner, step_s, limits):
    """Write a rounded corner, a row of ``corners_of``, from a heading on, by its tangents, at most so much time apart.

    towards: the unit vector in whose direction it ends.
    """
    (x, y, ux, uy), (vx, vy), sine, speed = at, towards, corner[0], corner[1]
    whole_s, _, _ = rounding(speed, sine, limits)
    peak = min(_corner_m_s2(sine, limits), math.sqrt(2 * speed * sine * limits.jerk_m_s3))
    rise_s = peak / limits.jerk_m_s3
    size = math.hypot(vx - ux, vy - uy)
    nx, ny = (vx - ux) / size, (vy - uy) / size
    px, py, wx, wy = x, y, speed * ux, speed * uy
    for part in range(3):
        in_s = whole_s - 2 * rise_s if part == 1 else rise_s
        if in_s <= 0:
            continue
        strength = peak if part == 1 else peak / 2
        # tangents: at half a step from either end, and a step apart; see check.accelerations
        tangents = max(1, math.ceil(in_s / step_s - 1e-9))
        x, y, step = px, py, in_s / tangents
        for c in range(tangents + 1):
            leg_s, gained = (step / 2 if c in (0, tangents) else step), strength * step * c
            x, y = x + (wx + nx * gained) * leg_s, y + (wy + ny * gained) * leg_s
            n = _add_row(rows, n, x, y, leg_s, 0.0)
        px += wx * in_s + nx * strength * in_s * in_s / 2
        py += wy * in_s + ny * strength * in_s * in_s / 2
        wx += nx * strength * in_s
        wy += ny * strength * in_s
    return n


@kernel(noinline=True)
def timed_rows(vertices_m, closed, step_s, limits):
    """Rows (m, 5) of a way along a polyline (n, 2), n > 1: seconds, x, y, and what the leg is that ends there.

    That is its acceleration, and which of the polyline's legs it is beside.

    A closed one begins and ends where the rounding of the first corner ends, another one at rest at its ends. step_s:
    the longest time between two tangents to a rounding.
    """
    corners = corners_of(vertices_m, closed, limits)
    n = len(corners)
    most = 1
    for k in range(n):
        most += 12 + int(rounding(corners[k, 1], corners[k, 0], limits)[0] / step_s) + 6
    rows, beside = np.zeros((most, 5)), np.zeros(most)
    x0, y0 = 0.0, 0.0
    count = 1
    for k in range(n if closed else n - 1):
        after, later = (k + 1) % n, (k + 2) % n
        leg_m = corners[k, 2]
        ux, uy = (vertices_m[after] - vertices_m[k]) / leg_m
        half_m = rounding(corners[k, 1], corners[k, 0], limits)[1]
        next_s, next_half_m, _ = rounding(corners[after, 1], corners[after, 0], limits)
        room_m = max(0.0, leg_m - half_m - next_half_m)
        begin_m_s, end_m_s = corners[k, 1], corners[after, 1]
        first = count
        peak = peak_m_s(begin_m_s, end_m_s, room_m, limits)
        up_m, down_m = ramp_m(begin_m_s, peak, limits), ramp_m(peak, end_m_s, limits)
        x, y = vertices_m[k, 0] + ux * half_m, vertices_m[k, 1] + uy * half_m
        if k == 0:
            rows[0, 1], rows[0, 2] = x, y
            x0, y0 = x, y
        count = _add_ramp(rows, count, Heading(x, y, ux, uy), begin_m_s, peak, limits)
        steady_m = max(0.0, room_m - up_m - down_m)
        x, y = x + ux * (up_m + steady_m), y + uy * (up_m + steady_m)
        count = _add_row(rows, count, x, y, steady_m / max(peak, 1e-12), 0.0)
        count = _add_ramp(rows, count, Heading(x, y, ux, uy), peak, end_m_s, limits)
        x, y = x + ux * down_m, y + uy * down_m
        if limits.turn_s > 0:
            turn_s = 2 * math.asin(min(1.0, corners[after, 0])) * limits.turn_s
            count = _add_row(rows, count, x, y, turn_s, 0.0)
        beside[first:most] = k
        if next_s > 0 and corners[after, 0] >= STRAIGHT:
            vx, vy = (vertices_m[later] - vertices_m[after]) / corners[after, 2]
            begins = count
            count = _add_rounding(rows, count, Heading(x, y, ux, uy), (vx, vy), corners[after], step_s, limits)
            beside[(begins + count) // 2 : count] = k + 1
    rows[count - 1, 0] += rows[count - 1, 4]
    if closed:
        if rows[count - 2, 1] == rows[count - 1, 1] and rows[count - 2, 2] == rows[count - 1, 2]:
            rows[count - 2, 1], rows[count - 2, 2] = x0, y0  # a pause stays one
        rows[count - 1, 1], rows[count - 1, 2] = x0, y0
    rows[:count, 4] = beside[:count]
    return rows[:count]


@kernel(noinline=True)
def run_up(x, y, ux, uy, speed_m_s, limits):
    """Rows (m, 5) as above of a start from rest that gets to (x, y), in the direction u, at this speed."""
    rows = np.zeros((8, 5))
    length_m = ramp_m(0.0, speed_m_s, limits)
    rows[0, 1], rows[0, 2] = x - ux * length_m, y - uy * length_m
    count = _add_ramp(rows, 1, Heading(rows[0, 1], rows[0, 2], ux, uy), 0.0, speed_m_s, limits)
    rows[count - 1, 0] += rows[count - 1, 4]
    rows[count - 1, 1], rows[count - 1, 2] = x, y
    return rows[:count]

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Rounds of legs that blend at corners, by ``scurve_kernels``: where the copter is to be, and what corners cost."""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import kernel
from rota.vehicles.scurve_kernels import (
    ACCELERATION,
    LENGTH,
    RISE,
    STEADY,
    WHOLE,
    along,
    blend_s,
    legs_of,
    round_times,
)

ANGLES, LENGTHS = 33, 64  # rows and columns of a table of corners
SMALLEST_TURN = 1e-5  # the first row's
SAME_M_S = 1e-9  # speeds that differ by less are one
SLIVER = 0.2  # of a chord's time: what lasts no longer joins the leg before, or its windows would have no room


@kernel
def closed_points(vertices_m):
    """A closed polyline (n, 2) as points (n + 1, 3) at one height."""
    n = len(vertices_m)
    points = np.zeros((n + 1, 3))
    points[:n, :2] = vertices_m
    points[n] = points[0]
    return points


@kernel(noinline=True)
def round_of(vertices_m, speed_m_s, limits, lag_s3_m2, shape):
    """Seconds (n,) of each leg of a round of a closed polyline (n, 2), n > 1, without waits; see ``round_times``."""
    points = closed_points(vertices_m)
    n = len(vertices_m)
    legs = legs_of(points, np.full(n, speed_m_s), np.ones(2), limits, shape)
    return round_times(points, np.zeros(n), legs, lag_s3_m2, shape)


@kernel(noinline=True)
def corner_table(longest_m, speed_m_s, pace_m_s, limits, lag_s3_m2, shape):
    """What corners add, as metres at a pace, by their sharpness and the legs beside them: (ANGLES, LENGTHS).

    Row j is for half a turn with the sine j / (ANGLES - 1), the first for the smallest there is; column i for a leg of
    (i / (LENGTHS - 1))^2 ``longest_m`` between two corners alike, which has half of each.
    """
    table = np.zeros((ANGLES, LENGTHS))
    points = np.zeros((3, 3))
    for i in range(1, LENGTHS):
        leg_m = longest_m * (i / (LENGTHS - 1)) ** 2
        for j in range(ANGLES):
            sine = max(SMALLEST_TURN, j / (ANGLES - 1))
            turn = 2 * math.asin(min(1.0, sine))
            points[1, 0] = leg_m
            points[2, 0], points[2, 1] = leg_m + leg_m * math.cos(turn), leg_m * math.sin(turn)
            legs = legs_of(points, np.full(2, speed_m_s), np.ones(2), limits, shape)
            whole_s = legs[0, WHOLE] - blend_s(points, 1, legs[0], legs[1], shape)
            whole_s += lag_s3_m2 * legs[0, ACCELERATION] ** 2 * (legs[0, RISE] + legs[0, STEADY]) * sine**3
            table[j, i] = (whole_s * pace_m_s - leg_m) / 2
    return table


@kernel(noinline=True)
def blends_of(vertices_m, speed_m_s, limits, lag_s3_m2, shape):
    """For each leg of a round of a closed polyline (n, 2): when it begins, and how long it blends with the one before.

    (n + 1, 2) seconds; the last row is the first leg's, a round later. What copters lag behind is left out.
    """
    points = closed_points(vertices_m)
    n = len(vertices_m)
    legs = legs_of(points, np.full(n, speed_m_s), np.ones(2), limits, shape)
    around = np.empty((n + 2, 3))
    around[0], around[1:] = points[n - 1], points
    times = np.zeros((n + 1, 2))
    for k in range(n):
        times[k, 1] = blend_s(around, k + 1, legs[k - 1], legs[k], shape)
    times[n, 1] = times[0, 1]
    for k in range(n):
        times[k + 1, 0] = times[k, 0] + legs[k, WHOLE] - times[k + 1, 1]
    return times


@kernel(noinline=True)
def from_rest(vertices_m, k, lasts_s, pieces, speed_m_s, limits, shape):
    """Metres and m/s along leg k of a closed polyline (n, 2) from rest, (pieces + 1, 2), in its first seconds."""
    points = closed_points(vertices_m)
    leg = legs_of(points[k : k + 2], np.full(1, speed_m_s), np.ones(2), limits, shape)[0]
    rows = np.zeros((pieces + 1, 2))
    for c in range(pieces + 1):
        rows[c, 0], rows[c, 1], _ = along(lasts_s * c / pieces, leg)
    return rows


@kernel(noinline=True)
def sampled_round(vertices_m, speed_m_s, round_s, chord_s, straight_s, limits, lag_s3_m2, shape):
    """Rows (m, 5) of a round of a closed polyline (n, 2): seconds, x, y, and what the leg is that ends there.

    That is its acceleration, and which of the polyline's legs it is beside.

    It begins and ends as the leg from the first corner begins, and takes ``round_s``: what copters lag behind is spread
    over it. chord_s, straight_s: the longest legs where two blend, and elsewhere.
    """
    points = closed_points(vertices_m)
    n = len(vertices_m)
    legs = legs_of(points, np.full(n, speed_m_s), np.ones(2), limits, shape)
    around = np.empty((n + 2, 3))
    around[0], around[1:] = points[n - 1], points
    times = blends_of(vertices_m, speed_m_s, limits, lag_s3_m2, shape)
    blends = times[:n, 1]
    rows = np.zeros((4 + 8 * n + int(legs[:, WHOLE].sum() / min(chord_s, straight_s)), 5))
    count, last_speed = 0, 0.0
    for k in range(n):
        begins_s, next_s = times[k, 0], times[k + 1, 0]
        before = legs[k - 1]
        ux, uy = (points[k + 1, :2] - points[k, :2]) / legs[k, LENGTH]
        px, py = (around[k + 1, :2] - around[k, :2]) / before[LENGTH]
        for part in range(2):  # while the leg before goes on, and alone
            lasts_s = blends[k] if part == 0 else next_s - begins_s - blends[k]
            sliver = lasts_s < SLIVER * chord_s
            if lasts_s <= 1e-9:
                continue
            if sliver and count > 1:
                count -= 1  # its end takes the place of the row before
            pieces = max(1, math.ceil(lasts_s / (chord_s if part == 0 else straight_s) - 1e-9))
            first_s = 0.0 if part == 0 else blends[k]
            for c in range(pieces + 1):
                at_s = first_s + lasts_s * c / pieces
                done_m, speed, _ = along(at_s, legs[k])
                left_m = along(blends[k] - at_s, before)[0] if part == 0 else 0.0
                x = points[k, 0] + ux * done_m - px * left_m
                y = points[k, 1] + uy * done_m - py * left_m
                if (c == 0 or (sliver and count == 1)) and count > 0:
                    last_speed = speed
                    continue
                rows[count, 0], rows[count, 1], rows[count, 2] = begins_s + at_s, x, y
                rows[count, 4] = k if part == 1 or 2 * c > pieces else (k - 1) % n
                if part == 1 and sliver:
                    rows[count, 3] = 0.0
                elif part == 1 and count > 0:
                    steady = abs(speed - last_speed) < SAME_M_S and c > 1 and rows[count - 1, 3] == 0.0
                    if steady and speed > 0.999 * (legs[k, ACCELERATION] * (legs[k, RISE] + legs[k, STEADY])):
                        count -= 1  # one leg for all of the way at full speed
                        rows[count, 0], rows[count, 1], rows[count, 2] = begins_s + at_s, x, y
                        rows[count, 4] = k
                    elif abs(speed - last_speed) >= SAME_M_S:
                        rows[count, 3] = (speed - last_speed) / (lasts_s / pieces)
                last_speed = speed
                count += 1
    rows[count - 1, 1], rows[count - 1, 2] = rows[0, 1], rows[0, 2]
    stretch = round_s / rows[count - 1, 0]
    rows[:count, 0] *= stretch
    rows[:count, 3] /= stretch * stretch
    return rows[:count]

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""The S-curves by which ArduPilot flies straight legs, and how two of them blend at a corner (compiled).

A leg goes from rest to rest. Its speed rises by a ramp, stays, and falls by the same ramp. Within a ramp the
acceleration rises as a raised cosine, stays, and falls: a/2 (1 - cos(pi t / rise)). The parameters are WPNAV_SPEED,
WPNAV_ACCEL, WPNAV_JERK and ATC_INPUT_TC, by which the rise is lengthened, since a copter has to lean first (ArduPilot
developer documentation, "Copter Position Control and Navigation"; the closed forms are the integrals of the raised
cosine).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import kernel

BISECTIONS = 50
# columns of a row of legs
LENGTH, SPEED, CLIMBING, ACCELERATION, RISE, STEADY, RAMP, WHOLE = range(8)
COLUMNS = 8


class Shape(NamedTuple):
    """What S-curves are made by: m/s3, seconds that jerk itself takes, m of a waypoint's radius, m/s2 at corners."""

    jerk_m_s3: float
    jerk_rise_s: float
    radius_m: float
    corner_m_s2: float


@kernel(noinline=True)
def ramp_of(length_m, speed_m_s, most_m_s2, shape):
    """The ramp of a leg: its acceleration, how long that rises or falls, and how long it stays.

    The least of three accelerations holds: the most allowed, the one at which the speed is reached as the acceleration
    has just risen and fallen, and the one at which half the leg is.
    """
    jerk, soft_s = shape.jerk_m_s3, shape.jerk_rise_s
    by_speed = jerk / 2 * (math.sqrt(soft_s * soft_s + 4 * speed_m_s / jerk) - soft_s)
    low, high = 0.0, most_m_s2
    if high * (high / jerk + soft_s) ** 2 <= length_m / 2:
        low = high
    else:
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            if middle * (middle / jerk + soft_s) ** 2 < length_m / 2:
                low = middle
            else:
                high = middle
    acceleration = min(most_m_s2, by_speed, low)
    if acceleration < jerk * soft_s:  # not even the jerk gets to its most
        half_s = min((speed_m_s * soft_s / (2 * jerk)) ** (1 / 3), (length_m * soft_s / (8 * jerk)) ** 0.25)
        half_s = min(half_s, math.sqrt(most_m_s2 * soft_s / jerk), soft_s)
        acceleration, rise_s = jerk * half_s * half_s / soft_s, 2 * half_s
    else:
        rise_s = acceleration / jerk + soft_s
    steady_s = 0.0
    if acceleration >= most_m_s2 * (1 - 1e-12):
        by_length_s = (math.sqrt(rise_s * rise_s + 4 * length_m / most_m_s2) - 3 * rise_s) / 2
        steady_s = max(0.0, min(speed_m_s / most_m_s2 - rise_s, by_length_s))
    return acceleration, rise_s, steady_s


@kernel(noinline=True)
def legs_of(points_m, speeds_m_s, climbing, limits_m_s2, shape):
    """A row for each leg between points (n, 3): see the columns above. Legs without length take no time.

    speeds_m_s (n - 1,): over the ground. climbing: most m/s upwards and downwards, (2,). limits_m_s2: most acceleration
    over the ground and of the height, (2,). A leg that climbs is as fast as both of its parts allow.
    """
    legs = np.zeros((len(points_m) - 1, COLUMNS))
    for k in range(len(legs)):
        step = points_m[k + 1] - points_m[k]
        flat_m, length_m = math.hypot(step[0], step[1]), math.sqrt((step * step).sum())
        if length_m == 0:
            continue
        legs[k, LENGTH], legs[k, CLIMBING] = length_m, step[2] / length_m
        speed, acceleration = math.inf, math.inf
        if flat_m > 0:
            speed, acceleration = speeds_m_s[k] * length_m / flat_m, limits_m_s2[0] * length_m / flat_m
        if step[2] != 0:
            vertical_m_s = climbing[0] if step[2] > 0 else climbing[1]
            speed = min(speed, vertical_m_s * length_m / abs(step[2]))
            acceleration = min(acceleration, limits_m_s2[1] * length_m / abs(step[2]))
        a, rise_s, steady_s = ramp_of(length_m, speed, acceleration, shape)
        peak_m_s, ramp_s = a * (rise_s + steady_s), 2 * rise_s + steady_s
        legs[k, SPEED], legs[k, ACCELERATION], legs[k, RISE], legs[k, STEADY], legs[k, RAMP] = (
            speed, a, rise_s, steady_s, ramp_s,
        )  # fmt: skip
        legs[k, WHOLE] = 2 * ramp_s + max(0.0, length_m - peak_m_s * ramp_s) / peak_m_s
    return legs


@kernel
def _rising(t_s, leg):
    """Metres, m/s and m/s2 after so long in a ramp from rest; beyond its end at the speed that it ends with."""
    a, rise_s, steady_s, ramp_s = leg[ACCELERATION], leg[RISE], leg[STEADY], leg[RAMP]
    peak_m_s, w = a * (rise_s + steady_s), math.pi / rise_s
    if t_s >= ramp_s:
        return peak_m_s * ramp_s / 2 + peak_m_s * (t_s - ramp_s), peak_m_s, 0.0
    s = min(t_s, ramp_s - t_s)  # the ramp is the same from its end, but for what falls short of the peak
    if s < rise_s:
        metres = a / 2 * (s * s / 2 + (math.cos(w * s) - 1) / (w * w))
        speed, acceleration = a / 2 * (s - math.sin(w * s) / w), a / 2 * (1 - math.cos(w * s))
    else:
        more_s = s - rise_s
        speed = a / 2 * rise_s
        metres = a / 2 * (rise_s * rise_s / 2 - 2 / (w * w)) + speed * more_s + a / 2 * more_s * more_s
        speed, acceleration = speed + a * more_s, a
    if s < t_s:
        return peak_m_s * ramp_s / 2 - peak_m_s * s + metres, peak_m_s - speed, acceleration
    return metres, speed, acceleration


@kernel(noinline=True)
def along(t_s, leg):
    """Metres, m/s and m/s2 along a leg after so long: at rest before it and after it."""
    if t_s <= 0:
        return 0.0, 0.0, 0.0
    if t_s >= leg[WHOLE]:
        return leg[LENGTH], 0.0, 0.0
    if t_s <= leg[WHOLE] / 2:
        return _rising(t_s, leg)
    metres, speed, acceleration = _rising(leg[WHOLE] - t_s, leg)
    return leg[LENGTH] - metres, speed, -acceleration


@kernel(noinline=True)
def may_blend(left_s, points_m, k, before, after, shape):
    """Whether the leg after point k may begin while the one before it still takes ``left_s``, at most half of either.

    In the middle of that time, which is the middle of the corner, the copter has to be nearer to the point than its
    radius, no faster than the slower leg, and to accelerate by less than allowed at corners.
    """
    if left_s > before[RAMP] + after[RISE] + after[STEADY] or left_s > min(before[WHOLE], after[WHOLE]) / 2:
        return False
    half_s = left_s / 2
    d_in, v_in, a_in = along(before[WHOLE] - half_s, before)
    d_out, v_out, a_out = along(half_s, after)
    off2_m2, speed2, accel2 = 0.0, 0.0, 0.0
    for axis in range(3):
        u_in = (points_m[k, axis] - points_m[k - 1, axis]) / before[LENGTH]
        u_out = (points_m[k + 1, axis] - points_m[k, axis]) / after[LENGTH]
        off2_m2 += (u_out * d_out - u_in * (before[LENGTH] - d_in)) ** 2
        if axis < 2:
            speed2 += (u_in * v_in + u_out * v_out) ** 2
            accel2 += (u_in * a_in + u_out * a_out) ** 2
    near = off2_m2 < shape.radius_m**2
    return near and speed2 < min(before[SPEED], after[SPEED]) ** 2 and accel2 < shape.corner_m_s2**2


@kernel
def blend_s(points_m, k, before, after, shape):
    """For how long two legs blend at point k between them: the most that is allowed, found by bisection.

    What is allowed is taken to be allowed for all shorter times as well.
    """
    most_s = min(before[RAMP] + after[RISE] + after[STEADY], before[WHOLE] / 2, after[WHOLE] / 2)
    low_s, high_s = 0.0, most_s
    if may_blend(most_s, points_m, k, before, after, shape):
        return most_s
    for _ in range(BISECTIONS):
        middle_s = (low_s + high_s) / 2
        if may_blend(middle_s, points_m, k, before, after, shape):
            low_s = middle_s
        else:
            high_s = middle_s
    return low_s


@kernel
def round_times(points_m, waits_s, legs, lag_s3_m2, shape):
    """Seconds of each leg of a closed round (n + 1, 3) whose last point is the first: to the middle of its last corner.

    waits_s (n,): how long the copter stays at the point that each leg begins at; it stops there if at all. Legs that
    blend lose half of the time in which they do. After a corner the copter lags behind what it is to follow, by
    ``lag_s3_m2`` a v sin(half the turn)^3 with the acceleration and the peak speed of the leg after it.
    """
    n = len(legs)
    corners = np.empty((n + 2, 3))
    corners[0], corners[1:] = points_m[n - 1], points_m
    times_s = legs[:, WHOLE] + waits_s
    for k in range(n):
        before, after = legs[k - 1], legs[k]
        if waits_s[k] > 0 or before[LENGTH] == 0 or after[LENGTH] == 0:
            continue
        half_s = blend_s(corners, k + 1, before, after, shape) / 2
        times_s[k - 1] -= half_s
        times_s[k] -= half_s
        straight = 0.0
        for axis in range(3):
            straight += ((corners[k + 1, axis] - corners[k, axis]) * (corners[k + 2, axis] - corners[k + 1, axis])) / (
                before[LENGTH] * after[LENGTH]
            )
        turn = max(0.0, (1 - straight) / 2) ** 1.5
        times_s[k] += lag_s3_m2 * after[ACCELERATION] ** 2 * (after[RISE] + after[STEADY]) * turn
    return times_s

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""An ArduCopter that flies a mission, in small steps of time (compiled).

A target moves along the S-curves of the legs; the copter follows it by a position controller, a velocity controller and
its lean, against the drag of the air; and the target waits for the copter: its clock runs slower where the copter falls
behind (ArduPilot developer documentation, "Copter Position Control and Navigation"; parameters PSC_POSXY_P, PSC_VELXY_P
and its like, ANGLE_MAX, ATC_INPUT_TC). Heights follow the target without delay. Vectors are x east, y north.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import kernel
from rota.model.arrays import Floats
from rota.vehicles.scurve_kernels import LENGTH, WHOLE, along, may_blend

GRAVITY_M_S2 = 9.80665
MARGIN = 0.05  # by which the target may be faster than the copter before it waits
TURNS_FROM = 0.05  # of the set speed: slower copters keep their heading
# rows of the copter's state, x and y each
POSITION, VELOCITY, LEAN_AIM, LEAN_RATE, LEAN, INTEGRAL, ERROR, SLOPE, BEYOND, HEADING = range(10)
ROWS = 10
# rows of the target's state, x, y and height each
AT, SPEED, ACCEL = range(3)


class Control(NamedTuple):
    """Gains of the controllers, in powers of 1/s, and what the lean is limited by; SI units."""

    position: float
    velocity: float
    integral: float
    slope: float
    filter_hz: float
    lean_rise_s: float
    lean_rad_s2: float
    yaw_rad_s: float
    attitude_lag_s: float
    lean_rad: float
    accel_m_s2: float
    pace_s: float


class Air(NamedTuple):
    """The drag per mass at a speed v through the air, ``linear`` v + ``square`` v^2, and the wind, x and y in m/s."""

    linear_per_s: float
    square_per_m: float
    wind_x_m_s: float
    wind_y_m_s: float


class Course(NamedTuple):
    """Points (n, 3), the speed to each but the first (n - 1,), the wait at each (n,), and the S-curves between them."""

    points_m: Floats
    speeds_m_s: Floats
    waits_s: Floats
    legs: Floats


@kernel
def _eased(error, gain, most):
    """A correction that grows with the error, and with its root once ``most`` is what it may change by."""
    bend = most / (gain * gain)
    if abs(error) > bend:
        return math.copysign(math.sqrt(2 * most * (abs(error) - bend / 2)), error)
    return error * gain


@kernel(noinline=True)
def _add_leg(target, points_m, k, leg, t_s, from_end):
    """Add to the target what a leg from point k contributes after so long: its way counts from its start or its end."""
    if leg[LENGTH] == 0:
        return
    metres, speed, acceleration = along(t_s, leg)
    way_m = metres - leg[LENGTH] if from_end else metres
    for axis in range(3):
        unit = (points_m[k + 1, axis] - points_m[k, axis]) / leg[LENGTH]
        target[AT, axis] += unit * way_m
        target[SPEED, axis] += unit * speed
        target[ACCEL, axis] += unit * acceleration


@kernel
def _pace(copter, target):
    """The share of its speed at which the target may move on: less than 1 where the copter is slower, or behind it."""
    speed = math.hypot(target[SPEED, 0], target[SPEED, 1])
    if speed == 0:
        return 1.0
    ahead = 0.0
    for axis in range(2):
        ahead += target[SPEED, axis] * (copter[VELOCITY, axis] - (target[AT, axis] - copter[POSITION, axis]))
    return min(1.0, max(0.0, MARGIN + ahead / (speed * speed)))


@kernel(noinline=True)
def _steer(copter, target, asked, most_off_m, control, step_s):
    """Put into ``asked`` (2,) the acceleration by which the copter follows the target."""
    off_m = math.hypot(target[AT, 0] - copter[POSITION, 0], target[AT, 1] - copter[POSITION, 1])
    correction = _eased(min(off_m, most_off_m), control.position, control.accel_m_s2)
    share = step_s / (step_s + 1 / (2 * math.pi * control.filter_hz))
    integral_m_s2 = math.hypot(copter[INTEGRAL, 0], copter[INTEGRAL, 1])
    winds_up = 0.0
    for axis in range(2):
        toward = (target[AT, axis] - copter[POSITION, axis]) / off_m if off_m > 0 else 0.0
        error = toward * correction + target[SPEED, axis] - copter[VELOCITY, axis]
        change = (error - copter[ERROR, axis]) * share
        copter[ERROR, axis] += change
        copter[SLOPE, axis] += (change / step_s - copter[SLOPE, axis]) * share
        grows = copter[ERROR, axis] * control.integral * step_s
        copter[INTEGRAL, axis] += grows
        winds_up += grows * copter[BEYOND, axis]
    now_m_s2 = math.hypot(copter[INTEGRAL, 0], copter[INTEGRAL, 1])
    shrink = integral_m_s2 / now_m_s2 if winds_up > 0 and now_m_s2 > integral_m_s2 else 1.0
    for axis in range(2):
        copter[INTEGRAL, axis] *= shrink
        asked[axis] = (
            copter[ERROR, axis] * control.velocity
            + copter[INTEGRAL, axis]
            + copter[SLOPE, axis] * control.slope
            + target[ACCEL, axis]
        )
    _limit(copter, target, asked, GRAVITY_M_S2 * math.tan(control.lean_rad))


@kernel
def _limit(copter, target, asked, most_m_s2):
    """Cut what is asked to what the greatest lean gives; across the way comes first, along it gets what is left."""
    copter[BEYOND] = 0.0
    total = math.hypot(asked[0], asked[1])
    if total <= most_m_s2:
        return
    copter[BEYOND] = asked
    speed = math.hypot(target[SPEED, 0], target[SPEED, 1])
    if speed == 0:
        asked *= most_m_s2 / total
        return
    ux, uy = target[SPEED, 0] / speed, target[SPEED, 1] / speed
    ahead, side = asked[0] * ux + asked[1] * uy, asked[1] * ux - asked[0] * uy
    side = min(most_m_s2, max(-most_m_s2, side))
    left = math.sqrt(max(0.0, most_m_s2 * most_m_s2 - side * side))
    ahead = min(left, max(-left, ahead))
    asked[0], asked[1] = ahead * ux - side * uy, ahead * uy + side * ux


@kernel(noinline=True)
def _lean(copter, asked, control, step_s):
    """Lean the copter towards what is asked: by a limited angular acceleration, and with the attitude's own delay."""
    total = math.hypot(asked[0], asked[1])
    lean_rad = math.atan(total / GRAVITY_M_S2)
    most = control.lean_rad_s2 * step_s
    for axis in range(2):
        aim = asked[axis] / total * lean_rad if total > 0 else 0.0
        rate = _eased(aim - copter[LEAN_AIM, axis], 1 / control.lean_rise_s, control.lean_rad_s2)
        copter[LEAN_RATE, axis] += min(most, max(-most, rate - copter[LEAN_RATE, axis]))
        copter[LEAN_AIM, axis] += copter[LEAN_RATE, axis] * step_s
        copter[LEAN, axis] += (copter[LEAN_AIM, axis] - copter[LEAN, axis]) * step_s / control.attitude_lag_s


@kernel(noinline=True)
def _move(copter, asked, air, step_s):
    """Move the copter by its lean and the air's drag; ``asked`` is overwritten.

    The height is held. So a lean gives g tan(lean), and more of it makes rotors push, and drag, more. The square part
    of drag acts along the body's own two axes.
    """
    lean_rad = math.hypot(copter[LEAN, 0], copter[LEAN, 1])
    steep = math.tan(lean_rad) / lean_rad if lean_rad > 1e-9 else 1.0
    wind = (copter[VELOCITY, 0] - air.wind_x_m_s, copter[VELOCITY, 1] - air.wind_y_m_s)
    cos, sin = math.cos(lean_rad), math.sin(lean_rad)
    into = (wind[0] * copter[LEAN, 0] + wind[1] * copter[LEAN, 1]) / lean_rad if lean_rad > 1e-9 else 0.0
    along_body = air.square_per_m * (into * cos) ** 2 + air.linear_per_s * abs(into) * cos
    through_rotors = air.square_per_m * (into * sin) ** 2 + air.linear_per_s * abs(into) * sin
    thrust = (GRAVITY_M_S2 - math.copysign(along_body * sin, into)) / cos + math.copysign(through_rotors, into)
    linear = air.linear_per_s * math.sqrt(max(0.3, thrust / GRAVITY_M_S2))
    hx, hy = copter[HEADING, 0], copter[HEADING, 1]
    ahead, side = hx * wind[0] + hy * wind[1], hx * wind[1] - hy * wind[0]
    lean_ahead = math.cos(hx * copter[LEAN, 0] + hy * copter[LEAN, 1])
    lean_side = math.cos(hx * copter[LEAN, 1] - hy * copter[LEAN, 0])
    drag_ahead = (air.square_per_m * abs(ahead) * lean_ahead + linear) * ahead
    drag_side = (air.square_per_m * abs(side) * lean_side + linear) * side
    asked[0] = GRAVITY_M_S2 * steep * copter[LEAN, 0] - hx * drag_ahead + hy * drag_side
    asked[1] = GRAVITY_M_S2 * steep * copter[LEAN, 1] - hy * drag_ahead - hx * drag_side
    for axis in range(2):
        copter[POSITION, axis] += (copter[VELOCITY, axis] + asked[axis] * step_s / 2) * step_s
        copter[VELOCITY, axis] += asked[axis] * step_s


@kernel(noinline=True)
def _turn(copter, target, slow_m_s, most_rad):
    """Turn the copter's nose towards where the target goes, by at most so much."""
    if math.hypot(target[SPEED, 0], target[SPEED, 1]) <= slow_m_s:
        return
    heading = math.atan2(copter[HEADING, 1], copter[HEADING, 0])
    turn = math.atan2(target[SPEED, 1], target[SPEED, 0]) - heading
    turn -= 2 * math.pi * math.floor(turn / (2 * math.pi) + 0.5)
    heading += min(most_rad, max(-most_rad, turn))
    copter[HEADING, 0], copter[HEADING, 1] = math.cos(heading), math.sin(heading)


@kernel(noinline=True)
def _at_rest(points_m, control, air):
    """The state of a copter that hovers over the first point, leaning into the wind."""
    copter = np.zeros((ROWS, 2))
    copter[POSITION] = points_m[0, :2]
    copter[HEADING, 0] = 1.0
    wind_m_s = math.hypot(air.wind_x_m_s, air.wind_y_m_s)
    drag = air.linear_per_s + air.square_per_m * wind_m_s
    copter[INTEGRAL, 0], copter[INTEGRAL, 1] = -drag * air.wind_x_m_s, -drag * air.wind_y_m_s
    lean_rad = min(control.lean_rad, math.atan(drag * wind_m_s / GRAVITY_M_S2))
    if wind_m_s > 0:
        copter[LEAN, 0], copter[LEAN, 1] = -lean_rad * air.wind_x_m_s / wind_m_s, -lean_rad * air.wind_y_m_s / wind_m_s
        copter[LEAN_AIM] = copter[LEAN]
    return copter


@kernel
def fly(course, end, shape, control, air, step_s, track, reached_s):
    """Fly a course from rest over its first point until point number ``end`` is reached, or ``track`` is full.

    Copters stop at points with a wait and at the last one, and pass the others. track (m, 3): where the copter is after
    each step. reached_s (n,): the time at which each point counts as reached: in the middle of its corner, or when the
    copter is within the radius of a point that it stops at. Returns the number of steps.
    """
    points_m, speeds_m_s, waits_s, legs = course.points_m, course.speeds_m_s, course.waits_s, course.legs
    copter, asked, target = _at_rest(points_m, control, air), np.empty(2), np.zeros((3, 3))
    target[AT] = points_m[0]
    before_s, now_s, after_s, stay_s, pace, k = 0.0, 0.0, 0.0, waits_s[0], 1.0, 0
    for step in range(len(track)):
        leg = legs[k]
        pace += (_pace(copter, target) - pace) * step_s / control.pace_s
        by_s = pace * step_s
        target[AT], target[SPEED], target[ACCEL] = points_m[k], 0.0, 0.0
        if k > 0 and waits_s[k] == 0:
            before_s += by_s
            _add_leg(target, points_m, k - 1, legs[k - 1], before_s, True)
        if stay_s > 0:
            stay_s -= step_s
        else:
            now_s += by_s
        _add_leg(target, points_m, k, leg, now_s, False)
        left_s, done = max(0.0, leg[WHOLE] - now_s), now_s >= leg[WHOLE]
        passes = k + 2 < len(points_m) and waits_s[k + 1] == 0 and leg[LENGTH] > 0 and legs[k + 1, LENGTH] > 0
        if passes and (after_s > 0 or may_blend(left_s, points_m, k + 1, leg, legs[k + 1], shape)):
            after_s += by_s
            _add_leg(target, points_m, k + 1, legs[k + 1], after_s, False)
            done = done or after_s >= left_s
        if done and not passes:
            off = (copter[POSITION, 0] - points_m[k + 1, 0], copter[POSITION, 1] - points_m[k + 1, 1])
            done = math.hypot(off[0], off[1]) <= shape.radius_m
        if done:
            k += 1
            reached_s[k] = step * step_s
            if k == end:
                return step
            before_s, now_s, after_s, stay_s = now_s, after_s, 0.0, waits_s[k]
        speed_m_s, accel = speeds_m_s[min(k, len(legs) - 1)], control.accel_m_s2
        most_off_m = accel / 2 + speed_m_s**2 / (2 * accel) if speed_m_s > accel else speed_m_s
        _steer(copter, target, asked, most_off_m, control, step_s)
        _turn(copter, target, TURNS_FROM * speed_m_s, control.yaw_rad_s * step_s)
        _lean(copter, asked, control, step_s)
        _move(copter, asked, air, step_s)
        track[step, 0], track[step, 1], track[step, 2] = copter[POSITION, 0], copter[POSITION, 1], target[AT, 2]
    return len(track)

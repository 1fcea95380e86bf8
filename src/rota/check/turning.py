"""Whether every corner can be driven: turns on the spot take their time, turns on arcs keep the turn radius."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.check.charging import docked_rows
from rota.check.report import Violation, violation
from rota.check.tolerances import (
    FLOAT_EPS,
    RADIUS_TOLERANCE,
    SPEED_TOLERANCE,
    STILL_M,
    STRAIGHT_RAD,
    TURN_OFF_SHARE,
    TURN_TOLERANCE_RAD,
)
from rota.model.mission import Robot
from rota.model.plan import Trajectory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_PER_ROBOT = 20
TURNED_S = 1.0  # on a charger, after which a robot may face anywhere; by less it only touches the ground


def turn_violations(trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Corners without the pause that turning takes, the seam of the loop included, and headings that turn too fast.

    The value of a corner is its pause in seconds, the limit the least pause. The value of headings is their rate in
    rad/s. Steps of up to 1e-9 m count as standing still, and so do those whose direction rounding hides, far away.
    """
    if robot.turn_rate_rad_s is None:
        return []
    violations = _heading_violations(trajectory, robot, robot.turn_rate_rad_s)
    xy, times = trajectory.positions_m[:, :2], trajectory.times_s
    steps = np.diff(xy, axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1])
    far_m = float(np.abs(xy).max())
    moving = np.flatnonzero(length > max(STILL_M, 4 * FLOAT_EPS * far_m / STRAIGHT_RAD))
    if not len(moving):
        return violations
    before, after = moving[:-1], moving[1:]
    pause = times[after] - times[before + 1]
    looping = moving[moving >= trajectory.loop_index]
    if len(looping):
        last, first = looping[-1], looping[0]
        before, after = np.append(before, last), np.append(after, first)
        seam = times[-1] - times[last + 1] + times[first] - trajectory.loop_start_s
        pause = np.append(pause, seam)
    angle, noise = _turns_rad(steps, length, before, after, far_m)
    need = angle / robot.turn_rate_rad_s
    allowed = np.maximum(0.0, angle - noise) / robot.turn_rate_rad_s * (1 - SPEED_TOLERANCE) - 4 * FLOAT_EPS * times[-1]
    for k in np.flatnonzero(pause < allowed)[:MOST_PER_ROBOT]:
        m = before[k] + 1
        place = (xy[m, 0], xy[m, 1])
        violations.append(violation("turn", robot.name, place, float(times[m]), float(pause[k]), float(need[k]), "s"))
    return violations


def _heading_violations(trajectory: Trajectory, robot: Robot, rate_rad_s: float) -> list[Violation]:
    """Headings that turn faster than the rate from one timed point to the next, the seam of the loop included."""
    if trajectory.headings_rad is None:
        return []
    change = np.diff(trajectory.headings_rad)
    if trajectory.loop_duration_s > 0:
        change = np.append(change, trajectory.headings_rad[trajectory.loop_index] - trajectory.headings_rad[-1])
    turn = np.abs((change + math.pi) % (2 * math.pi) - math.pi)
    time = np.append(np.diff(trajectory.times_s), 0.0)[: len(turn)]
    allowed = rate_rad_s * (time * (1 + SPEED_TOLERANCE) + 4 * FLOAT_EPS * trajectory.times_s[-1]) + TURN_TOLERANCE_RAD
    violations = []
    for m in np.flatnonzero(turn > allowed)[:MOST_PER_ROBOT]:
        x, y = trajectory.positions_m[m, :2]
        value = float(turn[m] / time[m]) if time[m] > 0 else math.inf
        violations.append(
            violation("turn", robot.name, (x, y), float(trajectory.times_s[m]), value, rate_rad_s, "rad/s")
        )
    return violations


def turn_radius_violations(trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Corners that a robot with a turn radius cannot follow, the seam of the loop included.

    A curve of arcs with the turn radius r and of straight lines must run within r / 200 of the legs. An arc that
    touches both legs of a corner with turn a leaves it by r (1 / cos(a / 2) - 1), and takes r tan(a / 2) of each leg;
    what the two corners of a leg take must not overlap. So a turn is at most 11.4 degrees, and legs are long enough.
    Legs in a straight row are one. Standing still does not help: such a robot cannot turn on the spot. On a charger it
    can be turned: it takes off in any heading, if it charged for as long as the turn takes on its arc, or for a second.
    The value is the radius in metres that the corner's legs leave room for; 0 where the turn is too sharp.
    """
    radius_m = robot.turn_radius_m
    if radius_m == 0:
        return []
    xy = trajectory.positions_m[:, :2]
    steps = np.diff(xy, axis=0)
    lengths = np.hypot(*steps.T)
    moving = np.flatnonzero(lengths > STILL_M)
    legs = np.concatenate([moving, moving[moving >= trajectory.loop_index]])  # the loop twice, for what spans its seam
    if len(legs) < 2:
        return []
    angle, noise = _turns_rad(steps, lengths, legs[:-1], legs[1:], float(np.abs(xy).max()))
    from_charger = np.zeros(len(angle), np.bool_)
    if trajectory.charges:
        stays_s = _charge_before_s(trajectory, legs)
        needed_s = np.minimum(angle * radius_m / robot.speed_m_s, TURNED_S) * (1 - SPEED_TOLERANCE)
        from_charger = (stays_s > 0) & (stays_s >= needed_s)
        angle[from_charger] = 0.0
    corners = np.union1d(_real_corners(angle, noise), np.flatnonzero(from_charger))
    # of each straight row of legs: its length, and how much its two corners take for a radius of 1
    row_m = np.add.reduceat(lengths[legs], np.concatenate([[0], corners + 1]))
    half = np.tan(np.minimum(angle[corners], math.pi / 2) / 2)
    taken = np.concatenate([half, [0.0]]) + np.concatenate([[0.0], half])
    room_m = np.divide(row_m, taken, out=np.full(len(row_m), math.inf), where=taken > 0)
    if trajectory.loop_duration_s > 0 and len(legs) > len(moving):
        room_m[-1] = math.inf  # its end is that of the first round's last row
        if trajectory.loop_index == 0:
            room_m[0] = math.inf  # it begins before the seam
    fits_m = np.minimum(room_m[:-1], room_m[1:])
    sharp = angle[corners] > 2 * math.acos(1 / (1 + TURN_OFF_SHARE))
    fits_m[sharp] = 0.0
    violations: dict[int, Violation] = {}
    for k in np.flatnonzero(fits_m < radius_m * (1 - RADIUS_TOLERANCE)).tolist():
        m = int(legs[corners[k]]) + 1
        place, when = (xy[m, 0], xy[m, 1]), float(trajectory.times_s[m])
        found = violation("turn radius", robot.name, place, when, float(fits_m[k]), radius_m, "m")
        violations.setdefault(m, found)  # the second round of a loop has the same again
    return list(violations.values())[:MOST_PER_ROBOT]


def _charge_before_s(trajectory: Trajectory, legs: Ints) -> Floats:
    """For how long a robot is on a charger before each of the legs (k,) but the first, in the order of driving."""
    docked_s = np.where(docked_rows(trajectory.times_s, trajectory.charges), np.diff(trajectory.times_s), 0.0)
    until_s = np.concatenate([[0.0], np.cumsum(docked_s)])
    before, after = legs[:-1], legs[1:]
    stays_s = until_s[after] - until_s[before + 1]
    over_seam_s = until_s[-1] - until_s[before + 1] + until_s[after] - until_s[trajectory.loop_index]
    return np.asarray(np.where(after > before, stays_s, over_seam_s))


def _real_corners(angle: Floats, noise: Floats) -> Ints:
    """Where (k,) legs are not in a straight row: turns beyond noise, and all of a row whose turns add up to a bend."""
    beyond = angle > noise
    row = np.cumsum(beyond)
    added = np.bincount(row, weights=np.where(beyond, 0.0, angle))
    return np.flatnonzero(beyond | (added[row] > STRAIGHT_RAD))


def _turns_rad(steps: Floats, lengths: Floats, before: Ints, after: Ints, far_m: float) -> tuple[Floats, Floats]:
    """The turn (c,) from legs before to legs after, 0 to pi, and what rounding and the tolerance may add to it (c,)."""
    a, b = steps[before], steps[after]
    angle = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
    return angle, TURN_TOLERANCE_RAD + 4 * FLOAT_EPS * far_m * (1 / lengths[before] + 1 / lengths[after])

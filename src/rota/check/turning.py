"""Whether every corner can be driven: turns on the spot take their time, turns on arcs keep the turn radius."""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Flags, Floats, Ints
from rota.check.charging import docked_rows
from rota.check.distances import point_distances
from rota.check.report import Violation, violation
from rota.check.tolerances import (
    FLOAT_EPS,
    RADIUS_TOLERANCE,
    SPEED_TOLERANCE,
    STILL_M,
    STRAIGHT_RAD,
    TOUCH_M,
    TURN_OFF_SHARE,
    TURN_TOLERANCE_RAD,
)
from rota.model.mission import Robot
from rota.model.plan import Trajectory

TURNED_S = 1.0  # on a charger, after which a robot may face anywhere; by less it only touches the ground


def turn_violations(trajectory: Trajectory, robot: Robot) -> list[Violation]:
    """Corners without the pause that turning takes, the seam of the loop included, and headings that turn too fast.

    The value of a corner is its pause in seconds, the limit the least pause. The value of headings is their rate in
    rad/s. Steps of up to 1e-9 m count as standing still, and so do those whose direction rounding hides, far away.
    What it may hide of turns does not add up: no row of corners turns by 1e-3 rad more than its pauses allow.
    """
    if robot.turn_rate_rad_s is None:
        return []
    violations = _heading_violations(trajectory, robot, robot.turn_rate_rad_s)
    xy, times = trajectory.positions_m[:, :2], trajectory.times_s
    steps = np.diff(xy, axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1])
    far_m = float(np.abs(xy).max())
    moving = np.flatnonzero(length > max(STILL_M, 4 * FLOAT_EPS * far_m / STRAIGHT_RAD))
    legs = np.concatenate([moving, moving[moving >= trajectory.loop_index]])  # the loop twice, for what spans its seam
    before, after = legs[:-1], legs[1:]
    pause = _between(times, legs, trajectory.loop_index)
    a, b = steps[before], steps[after]
    turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    noise = TURN_TOLERANCE_RAD / 2 + 4 * FLOAT_EPS * far_m / length[legs]  # of each leg's direction
    rate, late_s = robot.turn_rate_rad_s, 4 * FLOAT_EPS * times[-1]
    allowed = np.maximum(0.0, np.abs(turn) - noise[:-1] - noise[1:]) / rate * (1 - SPEED_TOLERANCE) - late_s
    corners = np.flatnonzero(pause[: len(moving)] < allowed[: len(moving)])
    rows = [(k, k + 1) for k in corners] or _row_turned(turn, rate * (pause * (1 + SPEED_TOLERANCE) + late_s), noise)
    for k, end in rows:
        m = before[k] + 1
        paused_s, need_s = float(pause[k:end].sum()), float(np.abs(turn[k:end].sum()) / rate)
        violations.append(violation("turn", robot.name, xy[m], float(times[m]), paused_s, need_s, "s"))
    return violations


def _row_turned(turn: Floats, turned: Floats, noise: Floats) -> list[tuple[int, int]]:
    """The first row of corners, (from, to), that turns by more than its pauses allow and rounding explains, or none.

    turn, turned: (k,) by how much each corner turns, to the left above 0, and how much its pause is enough for. noise:
    (k + 1,) of the directions of the legs beside: what is between them cancels out.
    """
    for side in (1, -1):
        ahead = np.concatenate([[0.0], np.cumsum(side * turn - turned)])
        least = np.minimum.accumulate(ahead + noise)[:-1]
        if len(too_far := np.flatnonzero(ahead[1:] - noise[1:] - least > STRAIGHT_RAD)):
            end = int(too_far[0]) + 1
            return [(int(np.argmin((ahead + noise)[:end])), end)]
    return []


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
    for m in np.flatnonzero(turn > allowed):
        x, y = trajectory.positions_m[m, :2]
        value = float(turn[m] / time[m]) if time[m] > 0 else math.inf
        violations.append(
            violation("turn", robot.name, (x, y), float(trajectory.times_s[m]), value, rate_rad_s, "rad/s")
        )
    return violations


def turn_radius_violations(trajectory: Trajectory, robot: Robot, *, begins_whole: bool = True) -> list[Violation]:
    """Corners that a robot with a turn radius cannot follow, the seam of the loop included.

    A curve of arcs with the turn radius r and of straight lines must run within r / 200 of the legs. An arc that
    touches both legs of a corner with turn a leaves it by r (1 / cos(a / 2) - 1), and takes r tan(a / 2) of each leg;
    what the two corners of a leg take must not overlap. So a turn is at most 11.4 degrees, and legs are long enough.
    Where they are not, places up to 1e-6 m off a line past them may be left out. Standing still does not help: such a
    robot cannot turn on the spot. On a charger it can be turned: it takes off in any heading, if it charged for as long
    as the turn takes on its arc, or for a second. begins_whole: False: the first leg is a piece of a longer one. The
    value is the radius in metres that the corner's legs leave room for; 0 where the turn is too sharp.
    """
    if robot.turn_radius_m == 0:
        return []
    xy, first = trajectory.positions_m[:, :2], trajectory.loop_index
    moving = np.flatnonzero((np.diff(xy, axis=0) != 0).any(axis=1))
    again = moving[moving >= first]
    legs = np.concatenate([moving, again])  # the loop twice, for what spans its seam
    if len(legs) < 2:
        return []
    # of a loop the second round's end is that of the first, and its begin may be before the seam
    whole = (begins_whole and (first > 0 or not len(again)), not len(again))
    docked_s = np.where(docked_rows(trajectory.times_s, trajectory.charges), np.diff(trajectory.times_s), 0.0)
    charged_s = _between(np.append(0.0, np.cumsum(docked_s)), legs, first)
    corners, fits_m = _tight_corners(np.vstack([xy[legs], xy[legs[-1] + 1]]), charged_s, robot, whole)
    violations: dict[int, Violation] = {}
    for corner, fit_m in zip(corners.tolist(), fits_m.tolist(), strict=True):
        m = int(legs[corner]) + 1
        place, when = (xy[m, 0], xy[m, 1]), float(trajectory.times_s[m])
        found = violation("turn radius", robot.name, place, when, fit_m, robot.turn_radius_m, "m")
        violations.setdefault(m, found)  # the second round of a loop has the same again
    return list(violations.values())


def _tight_corners(places_m: Floats, charged_s: Floats, robot: Robot, whole: tuple[bool, bool]) -> tuple[Ints, Floats]:
    """The corners (c,) of a way past places (n + 2, 2) that are too tight, and the radius (c,) that each has room for.

    charged_s: (n,) on a charger at each corner. whole: whether the first leg and the last one are no pieces. Places
    beside tight corners are left out as long as the way past the others is within 1e-6 m of all: a curve that follows
    that one follows them.
    """
    kept, off_m = np.arange(len(places_m)), np.zeros(len(places_m) - 1)
    while True:
        left_m = places_m[kept]
        half, fits_m, turned = _corners_of(left_m, charged_s[kept[1:-1] - 1], robot, whole)
        tight = np.flatnonzero(fits_m < robot.turn_radius_m * (1 - RADIUS_TOLERANCE))
        if not len(tight):
            return tight, fits_m[tight]
        # places that the arcs of these corners would reach, each second one of a row of them
        along_m = np.cumsum(np.hypot(*np.diff(left_m[:-1], axis=0).T))
        reach_m, count = robot.turn_radius_m * half[tight], len(along_m) + 1
        begins = np.searchsorted(along_m, along_m[tight] - reach_m)
        ends = np.searchsorted(along_m, along_m[tight] + reach_m, side="right")
        reached = np.cumsum(np.bincount(begins, minlength=count) - np.bincount(ends, minlength=count))[:-1] > 0
        beside_m, _ = point_distances(left_m[1:-1], left_m[:-2], left_m[2:] - left_m[:-2])
        beside_m += np.maximum(off_m[:-1], off_m[1:])
        out = reached & ~turned & (beside_m <= TOUCH_M)
        number = np.arange(len(out))
        out &= (number - np.maximum.accumulate(np.where(out, -1, number))) % 2 == 1
        if not out.any():
            return kept[1:-1][tight] - 1, fits_m[tight]
        off_m[:-1][out] = beside_m[out]
        kept, off_m = kept[np.concatenate([[True], ~out, [True]])], off_m[np.append(True, ~out)]


def _corners_of(
    places_m: Floats, charged_s: Floats, robot: Robot, whole: tuple[bool, bool]
) -> tuple[Floats, Floats, Flags]:
    """Of the corners (n,) of a way past places (n + 2, 2): what each takes of its legs for a radius of 1, for which
    radius they leave it room, and whether the robot is turned there; see ``_tight_corners``.
    """
    steps = np.diff(places_m, axis=0)
    a, b = steps[:-1], steps[1:]
    angle = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
    needed_s = np.minimum(angle * robot.turn_radius_m / robot.speed_m_s, TURNED_S) * (1 - SPEED_TOLERANCE)
    turned = (charged_s > 0) & (charged_s >= needed_s)
    angle[turned] = 0.0
    half = np.tan(np.minimum(angle, math.pi / 2) / 2)
    taken = np.append(half, 0.0) + np.append(0.0, half)
    room_m = np.divide(np.hypot(*steps.T), taken, out=np.full(len(taken), math.inf), where=taken > 0)
    room_m[[0, -1]] = np.where(whole, room_m[[0, -1]], math.inf)
    fits_m = np.minimum(room_m[:-1], room_m[1:])
    fits_m[angle > 2 * math.acos(1 / (1 + TURN_OFF_SHARE))] = 0.0
    return half, fits_m, turned


def _between(clock: Floats, legs: Ints, first: int) -> Floats:
    """By how much a clock (n,) goes on between each of the legs (k,) and the next, in the order of driving.

    Where the next one does not come later, the loop, which begins at index first, begins again between them.
    """
    before, after = legs[:-1], legs[1:]
    return np.asarray(clock[after] - clock[before + 1] + np.where(after > before, 0.0, clock[-1] - clock[first]))

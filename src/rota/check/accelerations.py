"""Whether the changes of velocity of a plan can be driven: accelerations along legs and at vertices, and jerk.

A plan's velocity may jump at a vertex, by a vector J. No mass does that; but a motion close by spreads the jump evenly
over a time h before and h after it. At a time s from the vertex it is off the plan by J (h - s)^2 / (4 h): by |J| h / 4
at most, and not at all from h on. There its acceleration is the leg's own plus J / (2 h). So a plan counts as driven if
there are windows, none of which overlap, in which that keeps the limit and |J| h / 4 is at most 5 cm (``OFF_M``): a
motion then exists that keeps the limit all the time and is never farther off the plan.

How wide a window must be follows from J, the limit and the accelerations of both legs. Where two on one leg do not fit,
one that needs no more than half of the leg has it, and the other one is told with what is left.

A curve of constant acceleration A is kept exactly by its tangents at times d apart, d at most sqrt(8 * 5 cm / A): legs
of d / 2, of d each, and of d / 2, each at the velocity that the curve has in the middle of its time, the first and the
last at those before and after the curve. Each jump then is A d, and its window d / 2.

Before a robot begins, and where it has come to stay, it is at rest; only a loop that begins at 0 is under way then.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from rota.check.arrays import Flags, Floats, Ints
from rota.check.report import Violation, violation
from rota.check.tolerances import ACCELERATION_TOLERANCE, FLOAT_EPS, OFF_M, STILL_M, TURN_TOLERANCE_RAD
from rota.model.mission import Robot
from rota.model.plan import Trajectory
from rota.model.violation_kinds import ViolationKind

ROUNDS = 4  # of a loop that are looked at, so that all that spans its seam is whole in one
VAGUE_M_S = 1e-3  # of rounding in the velocity of a leg, beyond which it tells nothing: one of a millionth of a second
PIECES_S, COARSE = (
    (1e-3, 1e-2),
    1.5,
)  # of what is judged in pieces, which differ in length: by this much more than the limits
FAR_BEYOND = 10  # times what rounding may make of a jump: then it says little of it
MOST_ROUNDED_M_S = 1e-2  # that rounding may add up to over all short legs of a round before they are judged in pieces
MOMENTS_S = 1e-3, 1e-2, 0.1  # legs that are shorter may be told too vaguely to say whether those beside are one
LEAST_LEFT = 1e-12  # of the square of a limit in m/s2 that a leg leaves for a jump: a window for it is then very long


class _Motion(NamedTuple):
    """n legs, the loop's four times: velocities (n, d) as each begins and as it ends, its acceleration.

    Robots at rest have a leg before they begin, and one after they end, that lasts for ever. noise_m_s: (n,) what
    rounding may make of a leg's velocity. points: (n,) of the trajectory, at which each leg begins.
    """

    begin_m_s: Floats
    end_m_s: Floats
    acceleration_m_s2: Floats
    lasts_s: Floats
    noise_m_s: Floats
    points: Ints

    def join(self, other: _Motion) -> _Motion:
        """These legs and then the other ones."""
        return _Motion(*(np.concatenate(both) for both in zip(self, other, strict=True)))


def acceleration_violations(
    trajectory: Trajectory, robot: Robot, *, from_rest: bool = True, seam: int | None = None
) -> list[Violation]:
    """Legs and vertices at which a robot would have to accelerate more than it can, and jerks.

    Kinds: "acceleration" along a leg, and where the speed jumps; "corner acceleration" where the direction does; "jerk"
    where accelerations change, see ``_jerk_violations``. Each is told with the least value that the plan asks for.
    Robots whose limits state no acceleration have none of these. from_rest: whether what is before the trajectory is
    known: rest, or the loop that begins at 0. If it is not, the first leg is judged with what is told of it. seam: the
    number of the point at which a plan took over.
    """
    most_m_s2 = robot.motion.acceleration_m_s2
    if most_m_s2 is None or len(trajectory.times_s) == 1:
        return []
    told = _motion_of(trajectory, from_rest)
    motion = _without_vague_legs(told)
    corner_m_s2 = robot.motion.corner_acceleration_m_s2 or most_m_s2
    violations = _along_violations(trajectory, most_m_s2)
    whole = not from_rest or bool(np.isinf(motion.lasts_s[0]))
    violations += _vertex_violations(trajectory, _without_cuts(motion), most_m_s2, corner_m_s2, whole)
    for piece_s in PIECES_S:
        if (
            not violations
            and (coarse := _in_even_pieces(told, piece_s, piece_s * max(most_m_s2, corner_m_s2))) is not None
        ):
            limits_m_s2 = COARSE * most_m_s2, COARSE * corner_m_s2
            violations += _vertex_violations(trajectory, _without_cuts(coarse), *limits_m_s2, whole)
    if (most_m_s3 := robot.motion.jerk_m_s3) is not None:
        # a loop may begin amid a leg, or with a curve: the motion without that point tells, or that with it
        points = {trajectory.loop_index, trajectory.loop_index if seam is None else seam}
        either = [each for k in range(len(points) + 1) for each in itertools.combinations(sorted(points), k)]
        jerks = [_jerk_violations(trajectory, _without_cuts(motion, at=at), most_m_s3, whole) for at in either]
        fewest = min(jerks, key=lambda own: (len(own), sum(each.value for each in own)))
        violations += fewest
    return violations


def _motion_of(trajectory: Trajectory, from_rest: bool) -> _Motion:
    """The legs of a trajectory as its robot drives them."""
    times, places, first = trajectory.times_s, trajectory.positions_m, trajectory.loop_index
    steps, lasts = np.diff(places, axis=0), np.diff(times)
    mean = steps / lasts[:, None]
    loops, count = trajectory.loop_duration_s > 0, len(lasts)
    legs = np.concatenate([np.arange(count), *[np.arange(first, count)] * (ROUNDS - 1)])
    half = mean[legs] * trajectory.bends[legs, None]
    far_m = float(np.abs(places).max())
    noise = (STILL_M + 4 * FLOAT_EPS * far_m) / lasts[legs]
    motion = _Motion(
        begin_m_s=mean[legs] - half,
        end_m_s=mean[legs] + half,
        acceleration_m_s2=2 * half / lasts[legs, None],
        lasts_s=lasts[legs],
        noise_m_s=noise,
        points=legs,
    )
    still = np.zeros((1, places.shape[1]))
    for_ever = _Motion(still, still, still, np.full(1, math.inf), np.zeros(1), np.full(1, count))
    if from_rest and (not loops or first > 0):
        motion = for_ever.join(motion)
    return motion if loops else motion.join(for_ever)


def _without_vague_legs(motion: _Motion) -> _Motion:
    """The motion with legs too short to tell their velocity as part of the legs before them.

    Nobody can say of such a leg whether the velocity jumps at its ends; but what it jumps by from the leg before to the
    leg after is told. So a corner, or a turn back, with a moment's leg in it is judged as one without. Those that come
    first are left out: of a loop they come again after the last one.
    """
    told = motion.noise_m_s <= VAGUE_M_S
    if told.all() or not told.any():
        return motion
    first = np.flatnonzero(told)
    changes = np.where(told[:, None], 0.0, motion.end_m_s - motion.begin_m_s)
    return _Motion(
        begin_m_s=motion.begin_m_s[first],
        end_m_s=motion.end_m_s[first] + np.add.reduceat(changes, first),
        acceleration_m_s2=motion.acceleration_m_s2[first],
        lasts_s=np.add.reduceat(motion.lasts_s, first),
        noise_m_s=motion.noise_m_s[first],
        points=motion.points[first],
    )


def _in_even_pieces(motion: _Motion, piece_s: float, corner_m_s: float) -> _Motion | None:
    """The motion with rows of legs shorter than a tenth of a piece in such pieces; None: it has few of them.

    What rounding may make of each such leg's velocity could add up to any curve. A piece has the mean velocity and
    acceleration of its legs. Jumps of velocity beyond corner_m_s that are far beyond rounding are at the ends of rows.
    Rows of less than a piece are part of the leg before; those that come first are left out.
    """
    short = motion.lasts_s < piece_s / 10
    if motion.noise_m_s[short].sum() <= ROUNDS * MOST_ROUNDED_M_S:
        return None
    jumps_m_s = _sizes(motion.begin_m_s[1:] - motion.end_m_s[:-1])
    far_m_s = np.maximum(corner_m_s, FAR_BEYOND * (motion.noise_m_s[1:] + motion.noise_m_s[:-1]))
    # of rows of short legs, and of others
    begins = np.flatnonzero(np.diff(short, prepend=~short[0]) | np.append(False, short[1:] & (jumps_m_s > far_m_s)))
    lasts_s = np.where(short, motion.lasts_s, 0.0)
    row_s, until_s = np.add.reduceat(lasts_s, begins), np.cumsum(lasts_s) - lasts_s
    row = np.cumsum(np.isin(np.arange(len(short)), begins)) - 1
    pieces = np.floor(row_s / piece_s)[row]
    part = np.floor(
        (until_s - until_s[begins][row]) / np.where(pieces > 0, row_s[row] / np.maximum(pieces, 1), math.inf)
    )
    joined = short & (pieces == 0)
    starts = ~short | (np.diff(row, prepend=-1) > 0) | (np.diff(part, prepend=-1.0) != 0)
    first = np.flatnonzero(starts & ~joined)
    if not len(first):
        return None
    size_s = np.add.reduceat(lasts_s, first)[:, None]
    piece, length_s = short[first][:, None], np.where(size_s > 0, size_s, 1.0)
    mean_m_s = np.add.reduceat((motion.begin_m_s + motion.end_m_s) / 2 * lasts_s[:, None], first) / length_s
    mean_m_s2 = np.add.reduceat(motion.acceleration_m_s2 * lasts_s[:, None], first) / length_s
    changes = np.add.reduceat(np.where(joined[:, None], motion.end_m_s - motion.begin_m_s, 0.0), first)
    return _Motion(
        begin_m_s=np.where(piece, mean_m_s - mean_m_s2 * length_s / 2, motion.begin_m_s[first]),
        end_m_s=np.where(piece, mean_m_s + mean_m_s2 * length_s / 2, motion.end_m_s[first] + changes),
        acceleration_m_s2=np.where(piece, mean_m_s2, motion.acceleration_m_s2[first]),
        lasts_s=np.add.reduceat(motion.lasts_s, first),
        noise_m_s=motion.noise_m_s[first] * np.where(piece, lasts_s[first][:, None] / length_s, 1.0)[:, 0],
        points=motion.points[first],
    )


def _without_cuts(motion: _Motion, at: tuple[int, ...] | None = None) -> _Motion:
    """The motion with legs as one where nothing but a point is between them: no jump of velocity or acceleration.

    So the point at which a loop begins, in the midst of a leg, changes nothing of what can be driven. at: only
    these points of the trajectory; None: any.
    """
    noise = motion.noise_m_s[1:] + motion.noise_m_s[:-1]
    shorter_s = np.minimum(motion.lasts_s[1:], motion.lasts_s[:-1])
    changes = _sizes(np.diff(motion.acceleration_m_s2, axis=0)) * np.where(np.isinf(shorter_s), 0.0, shorter_s)
    is_cut = (_sizes(motion.begin_m_s[1:] - motion.end_m_s[:-1]) <= noise) & (changes <= noise)
    if at is not None:
        is_cut &= np.isin(motion.points[1:], at)
    first = _first_legs(~is_cut, motion, motion.acceleration_m_s2, motion.noise_m_s, per_s=False)
    last = np.append(first[1:], len(motion.lasts_s)) - 1
    return _Motion(
        begin_m_s=motion.begin_m_s[first],
        end_m_s=motion.end_m_s[last],
        acceleration_m_s2=motion.acceleration_m_s2[first],
        lasts_s=np.add.reduceat(motion.lasts_s, first),
        noise_m_s=np.maximum.reduceat(motion.noise_m_s, first),
        points=motion.points[first],
    )


def _first_legs(parts: Flags, motion: _Motion, acceleration_m_s2: Floats, noise: Floats, *, per_s: bool) -> Ints:
    """The first leg of each row. parts: (n - 1,) where a leg ends a row by what is told of it and the next one.

    A moment's leg is told too vaguely to differ from either of its neighbours, and would make one row of both: where
    these differ, the later one begins a row. noise: of legs' accelerations (per_s), or of their velocities.
    """
    first = np.append(0, np.flatnonzero(parts) + 1)
    for moment_s in MOMENTS_S:
        tell = np.flatnonzero(motion.lasts_s >= moment_s)
        shorter_s = np.minimum(motion.lasts_s[tell[1:]], motion.lasts_s[tell[:-1]])
        over_s = 1.0 if per_s else np.where(np.isinf(shorter_s), 0.0, shorter_s)
        differ = _sizes(np.diff(acceleration_m_s2[tell], axis=0)) * over_s > noise[tell[1:]] + noise[tell[:-1]]
        row = np.searchsorted(first, tell, side="right")
        first = np.union1d(first, tell[1:][differ & (np.diff(row) == 0)])
    return first


def _along_violations(trajectory: Trajectory, most_m_s2: float) -> list[Violation]:
    """Legs along which the robot accelerates or brakes more than it can."""
    if trajectory.accelerations_m_s2 is None:
        return []
    found = np.abs(trajectory.accelerations_m_s2)
    return [
        _violation("acceleration", trajectory, int(m), float(found[m]), most_m_s2, "m/s2")
        for m in np.flatnonzero(found > most_m_s2 * (1 + ACCELERATION_TOLERANCE))
    ]


def _vertex_violations(
    trajectory: Trajectory, motion: _Motion, most_m_s2: float, corner_m_s2: float, begins_whole: bool
) -> list[Violation]:
    """Jumps of velocity that no motion within 5 cm drives; see the module. begins_whole: the first leg is no piece."""
    jump = motion.begin_m_s[1:] - motion.end_m_s[:-1]
    size = _sizes(jump)
    noise = motion.noise_m_s[1:] + motion.noise_m_s[:-1]
    jump *= (np.maximum(0.0, size - noise) / np.where(size > 0, size, 1.0))[:, None]
    size, turns = _sizes(jump), _turns(motion)
    limit = np.where(turns, max(most_m_s2, corner_m_s2), most_m_s2)
    legs = motion.acceleration_m_s2[:-1], motion.acceleration_m_s2[1:]
    needed_s = np.maximum(*(_least_window_s(jump, leg, limit) for leg in legs))
    needed_s = np.maximum(needed_s, np.where(turns, size / (2 * corner_m_s2), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        window_s = np.minimum(_windows_s(needed_s, motion.lasts_s), 4 * OFF_M / size)
        spread = np.where(size[:, None] > 0, jump / (2 * window_s[:, None]), 0.0)
    asked, by_corner = np.maximum(*(_sizes(leg + spread) for leg in legs)), _sizes(spread)
    lateral = turns & (by_corner / corner_m_s2 > asked / limit)
    asked, limit = np.where(lateral, by_corner, asked), np.where(lateral, corner_m_s2, limit)
    # beside legs that are cut off where the rounds begin and end, vertices are judged in another round
    whole = np.ones(len(size), np.bool_)
    whole[:1] &= begins_whole
    whole[-1:] &= np.isinf(motion.lasts_s[-1:])
    violations: dict[int, Violation] = {}
    for j in np.flatnonzero(whole & (size > 0) & (asked > limit * (1 + ACCELERATION_TOLERANCE))):
        kind: ViolationKind = "corner acceleration" if turns[j] else "acceleration"
        k = int(motion.points[j + 1])
        violations.setdefault(k, _violation(kind, trajectory, k, float(asked[j]), float(limit[j]), "m/s2"))
    return list(violations.values())


def _turns(motion: _Motion) -> Flags:
    """At which vertices (n - 1,) the direction changes by more than rounding; never beside a stop."""
    velocity = motion.begin_m_s + motion.end_m_s
    speed = _sizes(velocity)
    moves = speed > 2 * motion.noise_m_s
    direction = velocity / np.where(moves, speed, 1.0)[:, None]
    noise = 2 * motion.noise_m_s / np.where(moves, speed, 1.0)
    turn = _sizes(np.diff(direction, axis=0))
    return np.asarray(moves[1:] & moves[:-1] & (turn > TURN_TOLERANCE_RAD + noise[1:] + noise[:-1]))


def _least_window_s(jump: Floats, leg_m_s2: Floats, limit_m_s2: Floats) -> Floats:
    """The least h (v,) with |a + J / (2 h)| within the limit, for jumps J and accelerations a of legs, (v, d) each."""
    size2 = (jump**2).sum(axis=1)
    left = np.maximum((limit_m_s2 * (1 + ACCELERATION_TOLERANCE)) ** 2 - (leg_m_s2**2).sum(axis=1), LEAST_LEFT)
    along = (leg_m_s2 * jump).sum(axis=1)
    root = np.sqrt(along**2 + size2 * left)
    # the form whose sum does not cancel
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(
            np.where(size2 > 0, np.where(along > 0, (along + root) / left, size2 / (root - along)) / 2, 0.0)
        )


def _windows_s(needed_s: Floats, lasts_s: Floats) -> Floats:
    """What legs (n,) leave for windows at the vertices (n - 1,) between: what no other needs, or half."""
    beside = np.concatenate([[0.0], needed_s, [0.0]])
    before = lasts_s[:-1] - np.minimum(beside[:-2], lasts_s[:-1] / 2)
    after = lasts_s[1:] - np.minimum(beside[2:], lasts_s[1:] / 2)
    return np.asarray(np.minimum(before, after))


def _jerk_violations(trajectory: Trajectory, motion: _Motion, most_m_s3: float, begins_whole: bool) -> list[Violation]:
    """Changes of the acceleration that are faster than the robot's jerk allows.

    The velocity at a vertex is the mean of what it is just before and just after, the acceleration of a leg what makes
    the one at its end of that at its begin; neighbours with one acceleration are one phase. From one phase to the next,
    of T and U seconds, it may change by the jerk times (T + U) / 2: then an acceleration that goes straight from the
    middle of each phase to the middle of the next keeps the jerk. A ramp with half of the acceleration A for A / jerk
    seconds, then A, then half again is as long and as far as the one that a limited jerk makes, and keeps this exactly.
    How far the two are apart meanwhile is not judged.
    """
    at = (motion.begin_m_s[1:] + motion.end_m_s[:-1]) / 2
    change = np.diff(np.concatenate([motion.begin_m_s[:1], at, motion.end_m_s[-1:]]), axis=0)
    acceleration = change / motion.lasts_s[:, None]
    noise_m_s = motion.noise_m_s + np.maximum(np.append(motion.noise_m_s[1:], 0), np.append(0, motion.noise_m_s[:-1]))
    noise = noise_m_s / motion.lasts_s
    noise += ACCELERATION_TOLERANCE * most_m_s3 / 2
    other = _sizes(np.diff(acceleration, axis=0)) > noise[1:] + noise[:-1]
    first = _first_legs(other, motion, acceleration, noise, per_s=True)
    lasts_s = np.add.reduceat(motion.lasts_s, first)
    phase = np.add.reduceat(change, first) / lasts_s[:, None]
    noise = np.maximum.reduceat(noise_m_s, first) / lasts_s  # a moment's leg makes a phase no vaguer
    jerk = np.maximum(0.0, _sizes(np.diff(phase, axis=0)) - noise[1:] - noise[:-1]) / ((lasts_s[1:] + lasts_s[:-1]) / 2)
    # where rounds begin and end nobody knows by how much the first and last leg change the velocity, nor whether the
    # leg beside is of one phase with them: their phases are judged in another round
    whole, legs = np.ones(len(first), np.bool_), np.arange(len(change))
    for beside, known in ((legs[:2], begins_whole), (legs[-2:], bool(np.isinf(lasts_s[-1])))):
        whole[np.searchsorted(first, beside, side="right") - 1] &= known
    violations: dict[int, Violation] = {}
    for j in np.flatnonzero((jerk > most_m_s3 * (1 + ACCELERATION_TOLERANCE)) & whole[1:] & whole[:-1]):
        k = int(motion.points[first[j + 1]])
        violations.setdefault(k, _violation("jerk", trajectory, k, float(jerk[j]), most_m_s3, "m/s3"))
    return list(violations.values())


def _sizes(vectors: Floats) -> Floats:
    """Lengths (n,) of vectors (n, d)."""
    return np.asarray(np.sqrt((vectors**2).sum(axis=1)))


def _violation(kind: ViolationKind, trajectory: Trajectory, k: int, value: float, most: float, unit: str) -> Violation:
    """The violation at point k of the trajectory."""
    return violation(kind, trajectory.robot, trajectory.positions_m[k, :2], trajectory.times_s[k], value, most, unit)

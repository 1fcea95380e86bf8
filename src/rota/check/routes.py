"""The legs of a plan as plain arrays, and which loops share a common period."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import get_coordinates, get_parts, get_rings, linestrings, points

from rota.check.arrays import HOLD as HOLD, LOOP as LOOP, TRANSIENT as TRANSIENT, Flags, Floats, Ints
from rota.check.tolerances import FLOAT_EPS, SAME_RATIO, SAME_STEP
from rota.model.mission import DiscSensor
from rota.model.plan import Plan

LARGEST_DENOMINATOR = 64
MOST_STEPS = 100_000  # of a loop on a grid


@dataclass(frozen=True, kw_only=True, eq=False)
class Routes:
    """All legs of all robots, robot by robot and in the order of time.

    legs_m: (m, 4) x0, y0, x1, y1. heights_m: (m, 2) at both ends, nan where the plan has none. times_s: (m, 2). bends:
    (m,) see ``Trajectory.bends``. robots: (m,) index of the trajectory. kinds: (m,) 0 before the loop, 1 in its first
    turn, 2 a robot that stays there for ever. durations_s: (k,) of the loops, 0: it stays. classes: (k,) loops with one
    number share a period; parts: (k,) their durations in units_s[class]. from_s: the latest loop start.
    """

    legs_m: Floats
    heights_m: Floats
    times_s: Floats
    bends: Floats
    robots: Ints
    kinds: Ints
    durations_s: Floats
    classes: Ints
    parts: Ints
    units_s: Floats
    from_s: float

    def legs(self, which: Ints | Flags) -> Routes:
        """Those legs alone, in the order of their indices; or those that are flagged, (m,)."""
        return replace(
            self,
            legs_m=np.ascontiguousarray(self.legs_m[which]),
            heights_m=self.heights_m[which],
            times_s=np.ascontiguousarray(self.times_s[which]),
            bends=np.ascontiguousarray(self.bends[which]),
            robots=self.robots[which],
            kinds=self.kinds[which],
        )


def routes_of(plan: Plan) -> Routes:
    """The legs of every trajectory of a plan; a robot that stays has a last leg of no length."""
    legs, heights, times, bends = [np.empty((0, 4))], [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    robots: list[int] = []
    kinds: list[int] = []
    for k, trajectory in enumerate(plan):
        xy, t = trajectory.positions_m[:, :2], trajectory.times_s
        z = trajectory.positions_m[:, 2] if trajectory.positions_m.shape[1] == 3 else np.full(len(t), np.nan)
        legs.append(np.hstack([xy[:-1], xy[1:]]))
        heights.append(np.stack([z[:-1], z[1:]], axis=1))
        times.append(np.stack([t[:-1], t[1:]], axis=1))
        bends.append(trajectory.bends)
        start = trajectory.loop_index
        kinds += [TRANSIENT] * start + [LOOP] * (len(t) - 1 - start)
        if trajectory.loop_duration_s == 0:
            legs.append(np.hstack([xy[-1:], xy[-1:]]))
            heights.append(np.array([[z[-1], z[-1]]]))
            times.append(np.array([[t[-1], t[-1]]]))
            bends.append(np.zeros(1))
            kinds.append(HOLD)
        robots += [k] * (len(kinds) - len(robots))
    durations = np.array([trajectory.loop_duration_s for trajectory in plan], np.float64)
    rules = plan.mission.planning.bouncing
    keeps_step = rules is not None and rules.cell_m > 0
    ends_s = np.array([trajectory.times_s[-1] for trajectory in plan], np.float64)
    classes, parts, units = classes_in_step(durations, ends_s) if keeps_step else commensurable_classes(durations)
    return Routes(
        legs_m=np.ascontiguousarray(np.vstack(legs)),
        heights_m=np.vstack(heights),
        times_s=np.ascontiguousarray(np.vstack(times)),
        bends=np.concatenate(bends),
        robots=np.array(robots, np.int64),
        kinds=np.array(kinds, np.int64),
        durations_s=durations,
        classes=classes,
        parts=parts,
        units_s=units,
        from_s=max((trajectory.loop_start_s for trajectory in plan), default=0.0),
    )


def routes_driven(legs_m: Floats, times_s: Floats, bends: Floats, robots: Ints, count: int) -> Routes:
    """What ``count`` robots drove once, each by itself: legs (m, 4), times (m, 2), bends and robots (m,)."""
    return Routes(
        legs_m=np.ascontiguousarray(legs_m),
        heights_m=np.full((len(legs_m), 2), np.nan),
        times_s=np.ascontiguousarray(times_s),
        bends=bends,
        robots=robots,
        kinds=np.full(len(legs_m), LOOP, np.int64),
        durations_s=np.zeros(count),
        classes=np.arange(count, dtype=np.int64),
        parts=np.ones(count, np.int64),
        units_s=np.ones(count),
        from_s=0.0,
    )


def commensurable_classes(durations_s: Sequence[float] | Floats) -> tuple[Ints, Ints, Floats]:
    """Classes of loops that share a period: (k,) class, (k,) duration in units of its class, (classes,) units in s.

    Two loops share a period when one is p/q of the other with q <= 64 within 1e-9, or both share one with a third. No
    two loops of a class miss the ratio of their parts by more than 1e-9: a loop that would is in another class. A robot
    that stays (duration 0) is alone in its class, with one part.
    """
    durations = np.asarray(durations_s, np.float64)
    kinds_s, kind_of = np.unique(durations, return_inverse=True)
    n = len(durations)
    classes, parts = np.full(n, -1, np.int64), np.ones(n, np.int64)
    units: list[float] = []
    for head in range(n):
        if classes[head] >= 0:
            continue
        if durations_s[head] == 0:
            classes[head] = len(units)
            units.append(1.0)
            continue
        ratios = {head: Fraction(1)}
        least_s = most_s = float(durations[head])  # each loop of the class by its ratio: what it makes of the first one
        reached, done = [head], set()
        for i in reached:
            if durations[i] in done:
                continue  # all that shares a period with it has been reached
            done.add(durations[i])
            for j in map(int, np.flatnonzero(_perhaps_alike(kinds_s, durations[i])[kind_of])):
                ratio = _ratio(durations_s[j], durations_s[i]) if j not in ratios and classes[j] < 0 else None
                if ratio is None:
                    continue
                first_s = float(durations[j] / (ratios[i] * ratio))
                if max(most_s, first_s) - min(least_s, first_s) <= SAME_RATIO * min(least_s, first_s):
                    least_s, most_s = min(least_s, first_s), max(most_s, first_s)
                    ratios[j] = ratios[i] * ratio
                    reached.append(j)
        common = math.lcm(*(ratio.denominator for ratio in ratios.values()))
        if any(int(ratio * common) >= 1 << 40 for ratio in ratios.values()):
            ratios, common = {head: Fraction(1)}, 1
        for i, ratio in ratios.items():
            classes[i], parts[i] = len(units), int(ratio * common)
        units.append(durations_s[head] / common if durations_s[head] > 0 else 1.0)
    return classes, parts, np.array(units, np.float64)


def classes_in_step(durations_s: Floats, ends_s: Floats) -> tuple[Ints, Ints, Floats]:
    """The same of robots that keep in step on a grid, whose loops (k,) are whole numbers of one step.

    All that move are in one class when their loops are 1 to 100,000 of some step, and nothing but rounding is between:
    a share of 1e-14, which is a millisecond after three thousand years, and of the loops' ends in time (k,). Otherwise
    see ``commensurable_classes``.
    """
    moving = np.flatnonzero(durations_s > 0)
    if len(moving) < 2:
        return commensurable_classes(durations_s)
    loops_s = durations_s[moving]
    ratios = [Fraction(float(loop_s / loops_s[0])).limit_denominator(MOST_STEPS) for loop_s in loops_s]
    common = math.lcm(*(ratio.denominator for ratio in ratios))
    parts = np.array([int(ratio * common) for ratio in ratios], np.float64)
    noise_s = SAME_STEP * loops_s + 2 * FLOAT_EPS * (ends_s[moving] + ends_s[moving[0]] * loops_s / loops_s[0])
    if parts.max() > MOST_STEPS or (np.abs(loops_s - loops_s[0] * parts / parts[0]) > noise_s).any():
        return commensurable_classes(durations_s)
    classes, whole = np.arange(1, len(durations_s) + 1), np.ones(len(durations_s), np.int64)
    classes[moving], whole[moving] = 0, parts.astype(np.int64)
    return classes, whole, np.concatenate([[loops_s[0] / parts[0]], np.ones(len(durations_s))])


def _perhaps_alike(durations_s: Floats, one_s: float) -> Flags:
    """Which durations (n,) may be p / q of another one; of the rest ``_ratio`` is None."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.maximum(durations_s, one_s) / np.minimum(durations_s, one_s)
        wholes = ratios[:, None] * np.arange(1, LARGEST_DENOMINATOR + 1)
        off = np.abs(wholes - np.rint(wholes)) / wholes
    return np.asarray((off <= 2 * SAME_RATIO).any(axis=1))


def _ratio(longer_s: float, shorter_s: float) -> Fraction | None:
    """``longer_s / shorter_s`` as p/q with q <= 64 (of either to the other) within 1e-9; None: there is none."""
    if longer_s <= 0 or shorter_s <= 0:
        return None
    if longer_s < shorter_s:
        inverse = _ratio(shorter_s, longer_s)
        return None if inverse is None else 1 / inverse
    ratio = longer_s / shorter_s
    nearest = Fraction(ratio).limit_denominator(LARGEST_DENOMINATOR)
    return nearest if abs(ratio - float(nearest)) <= SAME_RATIO * ratio else None


def sensors_of(plan: Plan) -> tuple[Floats, Flags]:
    """Radius or half side (k,) in metres, and whether the sensor is a square (k,), of each trajectory's robot."""
    sensors = [plan.mission.fleet.robot(trajectory.robot).sensor for trajectory in plan]
    reaches = [s.radius_m if isinstance(s, DiscSensor) else s.side_m / 2 for s in sensors]
    return np.array(reaches, np.float64), np.array([not isinstance(s, DiscSensor) for s in sensors], np.bool_)


def lines_of(legs_m: Floats) -> NDArray[np.object_]:
    """Legs (n, 4) as shapely geometries; those of no length as points, since GEOS finds no distance to such a line."""
    lines: NDArray[np.object_] = linestrings(legs_m.reshape(-1, 2, 2))
    still = (legs_m[:, :2] == legs_m[:, 2:]).all(axis=1)
    lines[still] = points(legs_m[still, :2])
    return lines


def segments_of(shape: Any) -> Floats:
    """All sides of all rings of a shapely geometry: (n, 4) x0, y0, x1, y1; sides of no length are left out.

    So are those so short that the square of their length is 0.
    """
    xy, ring = get_coordinates(get_rings(get_parts(shape)), return_index=True)
    sides = np.hstack([xy[:-1], xy[1:]])
    long = ((xy[1:] - xy[:-1]) ** 2).sum(axis=1) > 0
    return np.ascontiguousarray(sides[(ring[1:] == ring[:-1]) & long])

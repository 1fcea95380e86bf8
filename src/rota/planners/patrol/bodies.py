"""Keeping bodies apart: loops whose durations have simple ratios, and phases at which no two robots ever meet."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rota.planners.patrol.annealing.tour import Tour
from rota.planners.patrol.timetable import loop_timetable, trajectories_of

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOST_DIVISIONS = 12  # the common unit of all durations is at least this part of the shortest
MOST_SAMPLES = 6_000  # moments of one loop
MOST_STEPS = 200_000  # of the search for phases


def timed_rounds(tours: Sequence[Tour], body_radius_m: float) -> list[tuple[Floats, Floats]]:
    """Times and places of one round of every robot, tour by tour, with bodies kept apart if phases can do it.

    Without bodies, or with one robot, every tour is driven as fast as it can be. When no phases keep the bodies apart,
    the tours are timed as if there were none: the check says so.
    """
    free = trajectories_of(tours, [None] * len(tours), [0.0] * len(tours))
    if body_radius_m == 0 or sum(tour.robots for tour in tours) == 1:
        return free
    natural_s = [float(loop_timetable(tour.vertices_m, tour.robot)[0][-1]) for tour in tours]
    for durations_s, unit_s in common_durations(tours, natural_s):
        offsets_s = phases_apart(tours, durations_s, unit_s, body_radius_m)
        if offsets_s is not None:
            return trajectories_of(tours, durations_s, offsets_s)
    return free


def common_durations(tours: Sequence[Tour], natural_s: Sequence[float]) -> list[tuple[list[float | None], float]]:
    """Durations that are whole multiples of one unit, none below the natural one nor above what the periods allow.

    Each with its unit in seconds, the greatest unit first: phases matter only modulo the unit, so a great one leaves
    most freedom. A robot that stays (natural duration 0) has None.
    """
    longest_s = [tour.robots * tour.period_s * (1 - 1e-6) for tour in tours]
    moving = [k for k in range(len(tours)) if natural_s[k] > 0]
    if not moving:
        return [([None] * len(tours), 1.0)]
    found = []
    for division in range(1, MOST_DIVISIONS + 1):
        unit_s = min(longest_s[k] for k in moving) / division
        times = {k: math.floor(longest_s[k] / unit_s + 1e-9) for k in moving}
        if all(times[k] * unit_s >= natural_s[k] for k in moving):
            found.append(([times[k] * unit_s if k in times else None for k in range(len(tours))], unit_s))
    return found[:4]


def phases_apart(
    tours: Sequence[Tour], durations_s: Sequence[float | None], unit_s: float, body_radius_m: float
) -> list[float] | None:
    """An offset (seconds) for each tour such that no two robots ever touch; None when there is none on the grid."""
    speed_m_s = max(tour.robot.speed_m_s for tour in tours)
    step_s = max(0.2 * body_radius_m / speed_m_s, max(d or 0.0 for d in durations_s) / MOST_SAMPLES)
    bins = max(1, math.ceil(unit_s / step_s))
    step_s = unit_s / bins
    apart_m = 2 * body_radius_m + speed_m_s * step_s
    places = [sampled(tour, duration_s, step_s) for tour, duration_s in zip(tours, durations_s, strict=True)]
    trees = [cKDTree(p) for p in places]
    # robot a of a tour runs a * duration / robots ahead of the tour's offset
    ahead = [
        np.rint(np.arange(t.robots) * len(p) / t.robots).astype(np.int64) for t, p in zip(tours, places, strict=True)
    ]
    for k, tree in enumerate(trees):
        if len(ahead[k]) > 1 and not follows_itself(tree, ahead[k], apart_m):
            return None
    taken: list[int] = []
    meets = {(i, k): meeting_shifts(trees[i], trees[k], bins, apart_m) for k in range(len(tours)) for i in range(k)}
    allowed: list[list[int]] = []
    steps = 0
    while len(taken) < len(tours):
        k = len(taken)
        if len(allowed) == k:
            allowed.append(free_offsets(k, taken, ahead, meets, bins))
        steps += 1
        if allowed[k] and steps < MOST_STEPS:
            taken.append(allowed[k].pop())
            continue
        allowed.pop()
        if not taken or steps >= MOST_STEPS:
            return None
        taken.pop()
    return [offset * step_s for offset in taken]


def sampled(tour: Tour, duration_s: float | None, step_s: float) -> Floats:
    """Places (n, 2) of a tour's leader every ``step_s`` of one round; one place for a robot that stays."""
    times_s, places_m = loop_timetable(tour.vertices_m, tour.robot, duration_s)
    if len(times_s) == 1 or duration_s is None:
        return places_m[:1]
    moments = np.arange(round(duration_s / step_s)) * step_s
    return np.column_stack([np.interp(moments, times_s, places_m[:, axis]) for axis in (0, 1)])


def follows_itself(tree: cKDTree, ahead: NDArray[np.int64], apart_m: float) -> bool:
    """Whether the robots of one tour, each so many samples ahead, stay apart."""
    n = tree.n
    return all(
        bool((np.hypot(*(np.roll(tree.data, -int(shift), axis=0) - tree.data).T) >= apart_m).all())
        for shift in ahead[1:]
        if shift % n
    )


def meeting_shifts(one: cKDTree, other: cKDTree, bins: int, apart_m: float) -> Flags:
    """Which shifts (bins,) of the other loop's phase against the first, modulo the unit, let two robots meet."""
    meets = np.zeros(bins, dtype=bool)
    for i, near in enumerate(one.query_ball_point(other.data, apart_m)):
        shifts = (i - np.array(near, dtype=np.int64)) % bins
        meets[shifts] = True
    if one.n == 1 or other.n == 1:
        meets[:] = meets.any()  # a robot that stays is met at any phase
    return meets


def free_offsets(
    k: int,
    taken: Sequence[int],
    ahead: Sequence[NDArray[np.int64]],
    meets: dict[tuple[int, int], Flags],
    bins: int,
) -> list[int]:
    """Offsets of tour k, modulo the unit, at which none of its robots meets one of the tours before; the best last.

    Best: in the middle of the longest stretch of free offsets, where a late robot has most room.
    """
    free = np.ones(bins, dtype=bool)
    for i, offset in enumerate(taken):
        for mine in ahead[k]:
            for theirs in ahead[i]:
                # shift = (offset_k + mine) - (offset_i + theirs)
                free &= ~np.roll(meets[i, k], offset + int(theirs) - int(mine))
    if free.all():
        return [*range(bins - 1, -1, -1)]
    where = np.flatnonzero(free)
    if not len(where):
        return []
    # distance to the nearest forbidden offset, going round
    blocked = np.flatnonzero(~free)
    apart = np.abs(where[:, None] - blocked[None])
    room = np.minimum(apart, bins - apart).min(axis=1)
    order = np.lexsort((-where, room))
    return [int(offset) for offset in where[order]][-2000:]

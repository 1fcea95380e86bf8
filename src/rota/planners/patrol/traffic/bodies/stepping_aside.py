"""Stepping aside: a robot with a small loop waits where nobody comes near, and drives its round while others are away.

Robots kept to pockets of the space beside each other take turns so. Their bodies clear each other by millimetres.
Phases and waits, found on samples of time, do not tell that apart; here distances are exact.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from rota.model.arrays import Floats
from rota.planners.patrol.driving.timed_line import start_at, steady
from rota.planners.patrol.tolerances import TIE
from rota.planners.patrol.tours.timetable import line_of
from rota.planners.patrol.traffic.bodies.loops import Loop, Timed

WIDEST = 0.25  # of two bodies: a loop that fits in no circle of that radius is timed like any other


def waiting_place(loops: Sequence[Loop], k: int, apart_m: float) -> int | None:
    """The vertex of the k-th loop that is farthest from all others' lines; None unless its robot may wait there.

    It may where it is alone on a loop no wider than a body, and nobody ever comes nearer than ``apart_m`` to that
    vertex. None as well where nobody comes near the loop at all, since nobody is in its way.
    """
    loop, line = loops[k], line_of(loops[k].places_m)
    if loop.stays or not loop.may_wait or loop.robots > 1 or shapely.minimum_bounding_radius(line) > WIDEST * apart_m:
        return None
    others = shapely.geometrycollections([line_of(other.places_m) for i, other in enumerate(loops) if i != k])
    if others.is_empty or shapely.distance(others, line) >= apart_m:
        return None
    away_m = shapely.distance(others, shapely.points(loop.places_m))
    farthest = int(np.argmax(away_m))
    return farthest if away_m[farthest] >= apart_m else None


def round_between(loop: Loop, waits_at: int, others: Sequence[tuple[Loop, Timed]], apart_m: float) -> Timed | None:
    """The loop timed so that its robot waits at one of its vertices, and drives its round while all others are away.

    others: loops with their timetables. None: those who come near have headways of different lengths, or longer ones
    than the loop's period, or leave no time.
    """
    line = line_of(loop.places_m)
    near = [(other, how) for other, how in others if shapely.distance(line_of(how.line.places_m), line) < apart_m]
    headways_s = [how.line.duration_s / other.robots for other, how in near]
    if not near or min(headways_s) == 0 or max(headways_s) - min(headways_s) > TIE * max(headways_s):
        return None  # who stays is always near
    headway_s = headways_s[0]
    free = longest_free(np.vstack([near_times(how, line, apart_m) for _, how in near]), headway_s)
    if headway_s > loop.period_s or free is None or free[1] - free[0] < loop.natural_s:
        return None
    begun = start_at(loop.line, float(loop.line.times_s[waits_at]))
    if headway_s > begun.duration_s:
        begun = steady(np.append(begun.times_s, headway_s), np.vstack([begun.places_m, begun.places_m[:1]]))
    begins_s = (free[0] + free[1] - loop.natural_s) / 2
    return Timed(begun, -begins_s % headway_s)


def near_times(timed: Timed, line: shapely.Geometry, apart_m: float) -> Floats:
    """From when to when (k, 2) in seconds a robot that drives this round for ever is nearer to a line than ``apart_m``.

    At time 0 it is ``offset_s`` into its round. Each time is told once, of all rounds; it may be below 0. What is told
    is a little too long: a piece of a leg is near where any of it is.
    """
    times_s, places_m = timed.line.times_s, timed.line.places_m
    begins, ends = places_m[:-1], places_m[1:]
    # legs are told near or not in pieces no longer than this
    pieces = np.maximum(1, np.ceil(np.hypot(*(ends - begins).T) / (0.05 * apart_m))).astype(np.int64)
    legs = shapely.linestrings(np.stack([begins, ends], axis=1))
    pieces[shapely.distance(legs, line) >= apart_m] = 0
    leg = np.repeat(np.arange(len(pieces)), pieces)
    first = (np.arange(len(leg)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[leg]
    last = first + 1 / pieces[leg]
    way = (ends - begins)[leg]
    parts = np.stack([begins[leg] + first[:, None] * way, begins[leg] + last[:, None] * way], axis=1)
    near = shapely.distance(shapely.linestrings(parts), line) < apart_m
    lasts_s = np.diff(times_s)[leg]
    from_s = times_s[leg] + first * lasts_s - timed.offset_s
    to_s = times_s[leg] + last * lasts_s - timed.offset_s
    return np.asarray(np.column_stack([from_s, to_s])[near])


def longest_free(busy_s: Floats, headway_s: float) -> tuple[float, float] | None:
    """The longest time, from and to, that none of the busy ones (k, 2) takes, all of them again in every headway."""
    if not len(busy_s):
        return 0.0, headway_s
    begins = busy_s[:, 0] % headway_s
    order = np.argsort(begins, kind="stable")
    begins, ends = begins[order], (begins + busy_s[:, 1] - busy_s[:, 0])[order]
    # what is busy beyond the end of a headway is so at the beginning of the next
    latest = np.maximum.accumulate(np.append(ends.max() - headway_s, ends))[1:]
    following = np.append(begins[1:], begins[0] + headway_s)
    k = int(np.argmax(following - latest))
    return (float(latest[k]), float(following[k])) if following[k] > latest[k] else None

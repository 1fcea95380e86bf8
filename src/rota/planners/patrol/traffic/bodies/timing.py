"""One round of every robot, timed so that bodies never touch if that can be had without leaving the tours."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

import numpy as np
import shapely

from rota.model.arrays import Floats
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.tolerances import TIE
from rota.planners.patrol.tours.timetable import evenly_spaced, line_of
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies.loops import FEW_TRIED, Loop, Timed, clocks, crowds, loop_of
from rota.planners.patrol.traffic.bodies.phases import phases_apart, phases_hardly_touching
from rota.planners.patrol.traffic.bodies.waits import waits_apart

WIDEST = 0.25  # of two bodies: a loop that fits in no circle of that radius is timed like any other


def timed_rounds(tours: Sequence[Tour], body_radius_m: float) -> list[TimedLine]:
    """One round of every robot, tour by tour, with bodies kept apart if timing can do it.

    Without bodies, or with one robot, every tour is driven as fast as it can be; so is one that no other comes near.
    Where nothing keeps the bodies apart, they meet as little as phases make them: the check says where and when.
    """
    return timed_loops([loop_of(tour) for tour in tours], body_radius_m)


def timed_loops(loops: Sequence[Loop], body_radius_m: float) -> list[TimedLine]:
    """The same of loops, robot by robot."""
    timed = [at_full_speed(loop) for loop in loops]
    for crowd in crowds_of(loops, body_radius_m):
        loops_of_crowd = [loops[k] for k in crowd]
        apart = time_apart(loops_of_crowd, body_radius_m) or nearly_apart(loops_of_crowd, body_radius_m)
        for k, timing in zip(crowd, apart, strict=True):
            timed[k] = timing
    return [
        timing
        for loop, how in zip(loops, timed, strict=True)
        for timing in evenly_spaced(how.line, loop.robots, how.offset_s)
    ]


def nearly_apart(loops: Sequence[Loop], body_radius_m: float) -> list[Timed]:
    """The loops at phases at which they touch for little time; as fast as they can be driven where no clock suits."""
    for clock in clocks(loops)[:1]:
        return phases_hardly_touching(loops, clock, body_radius_m)
    return [at_full_speed(loop) for loop in loops]


def crowds_of(loops: Sequence[Loop], body_radius_m: float) -> list[list[int]]:
    """The groups of loops on which several robots come near each other, or would but for their timing."""
    if body_radius_m == 0:
        return []
    return [crowd for crowd in crowds(loops, 2 * body_radius_m) if sum(loops[k].robots for k in crowd) > 1]


def crowds_that_touch(tours: Sequence[Tour], body_radius_m: float) -> list[list[int]]:
    """The groups of tours whose robots no timing was found to keep apart."""
    loops = [loop_of(tour) for tour in tours]
    return [
        crowd
        for crowd in crowds_of(loops, body_radius_m)
        if time_apart([loops[k] for k in crowd], body_radius_m) is None
    ]


def can_be_timed(tours: Sequence[Tour], body_radius_m: float) -> bool:
    """Whether some timing keeps all robots of the tours apart."""
    return not crowds_that_touch(tours, body_radius_m)


def at_full_speed(loop: Loop) -> Timed:
    """The loop as fast as it can be driven."""
    return Timed(loop.line, 0.0)


def time_apart(loops: Sequence[Loop], body_radius_m: float, aside_tries: int = FEW_TRIED) -> list[Timed] | None:
    """The loops so timed that no two robots ever touch: by phases and directions alone, else with waits; or None.

    Robots in pockets that step aside for others are timed after these. aside_tries: so many of them are tried.
    """
    aside = time_with_one_aside(loops, body_radius_m, aside_tries)
    if aside is not None:
        return aside
    if somebody_stays_on_a_route(loops, 2 * body_radius_m):
        return None
    for how in (phases_apart, waits_apart):
        for clock in clocks(loops):
            apart = how(loops, clock, body_radius_m)
            if apart is not None:
                return apart
    return None


def time_with_one_aside(loops: Sequence[Loop], body_radius_m: float, tries: int) -> list[Timed] | None:
    """The same where one of the first loops that can wait steps aside for all others; None where none can.

    Among these others one loop alone is tried, for the time would grow as the factorial of their number.
    """
    places = ((k, waiting_place(loops, k, 2 * body_radius_m)) for k in range(len(loops)))
    can_wait = ((k, waits_at) for k, waits_at in places if waits_at is not None)
    for k, waits_at in islice(can_wait, tries):
        others = [*loops[:k], *loops[k + 1 :]]
        timed = time_apart(others, body_radius_m, 1)
        if timed is None:
            return None  # nor are they kept apart with it
        one = round_between(loops[k], waits_at, list(zip(others, timed, strict=True)), 2 * body_radius_m)
        if one is not None:
            return [*timed[:k], one, *timed[k:]]
    return None


def somebody_stays_on_a_route(loops: Sequence[Loop], apart_m: float) -> bool:
    """Whether a robot stays, for ever, where another one comes by."""
    staying = [k for k, loop in enumerate(loops) if loop.stays]
    lines = np.array([line_of(loop.places_m) for loop in loops])
    near = [(k, i) for k in staying for i in np.flatnonzero(shapely.dwithin(lines, lines[k], apart_m)) if i != k]
    return bool(near) or any(loops[k].robots > 1 for k in staying)


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

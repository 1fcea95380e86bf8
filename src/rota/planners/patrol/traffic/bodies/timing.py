"""One round of every robot, timed so that bodies never touch if that can be had without leaving the tours."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

import numpy as np
import shapely

from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.tours.timetable import evenly_spaced, line_of
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies.loops import FEW_TRIED, Loop, Timed, clocks, crowds, loop_of
from rota.planners.patrol.traffic.bodies.phases import phases_apart, phases_hardly_touching
from rota.planners.patrol.traffic.bodies.stepping_aside import round_between, waiting_place
from rota.planners.patrol.traffic.bodies.waits import waits_apart


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

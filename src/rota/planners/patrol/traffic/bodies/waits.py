"""Waits on the way: loops timed one after the other, each through the gaps that those before it leave.

With the others' timetables given, a robot's own is a monotone path through the plane of its place along the loop and
of time, round the cells where somebody else is near (K. Kant and S. W. Zucker, "Toward Efficient Trajectory Planning:
The Path-Velocity Decomposition", Int. J. Robotics Research 5(3), 1986). Everything repeats, so time goes round.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.driving.timed_line import start_at, steady
from rota.planners.patrol.tours.timetable import stretch_line
from rota.planners.patrol.traffic.bodies import kernels
from rota.planners.patrol.traffic.bodies.loops import FEW_TRIED, Clock, Grid, Loop, Timed, grid_of, near_pairs
from rota.planners.patrol.traffic.bodies.phases import follows_itself, roomy_offsets, sample

Bytes = NDArray[np.uint8]


class Placed(NamedTuple):
    """A loop that has its timetable: a tree of where its first robot is at every sample of its round."""

    tree: cKDTree
    headway: int
    timed: Timed


def waits_apart(loops: Sequence[Loop], clock: Clock, body_radius_m: float) -> list[Timed] | None:
    """Timetables with waits on the way, with which no two robots touch; None when none were found.

    Loops with the least time to spare are timed first; one for which nothing is left goes before all others, and all
    are timed anew.
    """
    grid = grid_of(loops, clock, max(loop.speed_m_s for loop in loops), body_radius_m, most_samples=2_000)
    spare = [
        1.0 - loop.natural_s / (loop.robots * multiple * clock.unit_s) if not loop.stays else -1.0
        for loop, multiple in zip(loops, clock.multiples, strict=True)
    ]
    order = sorted(range(len(loops)), key=lambda k: spare[k])
    tried: set[tuple[int, ...]] = set()
    while tuple(order) not in tried and len(tried) < 2 * len(loops):
        tried.add(tuple(order))
        placed: dict[int, Placed] = {}
        for k in order:
            fits = fit(loops[k], clock.multiples[k] * grid.bins, grid, list(placed.values()))
            if fits is None:
                order = [k, *(i for i in order if i != k)]
                break
            placed[k] = fits
        else:
            return [placed[k].timed for k in range(len(loops))]
    return None


def fit(loop: Loop, headway: int, grid: Grid, others: Sequence[Placed]) -> Placed | None:
    """The loop timed so that its robots touch neither the others nor each other; None when none was found.

    At one speed if there is a phase for that, else with waits; in its own direction before the opposite one.
    """
    # with nobody else about, one direction is as good as the other
    directed = (loop, reversed_loop(loop)) if others and not loop.is_one_way else (loop,)
    for driven in directed:
        at_speed = at_one_speed(driven, headway, grid, others)
        if at_speed is not None or loop.stays:
            return at_speed
    for driven in directed:
        timetable = timetable_through(driven, headway, grid, others)
        if timetable is not None:
            start, along_s = timetable
            timed = with_knots(driven, along_s, start, grid.step_s, loop.robots * headway * grid.step_s)
            return place_as(timed, loop.robots, headway, grid)
    return None


def reversed_loop(loop: Loop) -> Loop:
    """The loop driven backwards."""
    return replace(loop, line=loop.line.backwards())


def place_as(timed: Timed, robots: int, headway: int, grid: Grid) -> Placed:
    """The timetable as others meet it."""
    places = sample(timed.line, robots * headway)
    shift = round(timed.offset_s / grid.step_s)
    return Placed(cKDTree(np.roll(places, -shift, axis=0)), headway, timed)


def at_one_speed(loop: Loop, headway: int, grid: Grid, others: Sequence[Placed]) -> Placed | None:
    """The loop stretched to its headway, at the phase with most room; None when there is none."""
    line = stretch_line(loop.line, loop.robots * headway * grid.step_s)
    tree = cKDTree(sample(line, loop.robots * headway))
    if not follows_itself(tree, loop.robots, grid.apart_m):
        return None
    free = np.ones(headway, dtype=bool)
    for other in others:
        near = near_pairs(tree, other.tree, grid.apart_m)
        if near is None:
            return None
        if loop.stays or other.tree.n == 1:
            free &= len(near[0]) == 0
            continue
        measure = math.gcd(headway, other.headway)
        meets = np.zeros(measure, dtype=bool)
        meets[(near[0] - near[1]) % measure] = True
        free &= ~np.tile(meets, headway // measure)
    if not free.any():
        return None
    timed = Timed(line, (roomy_offsets(free) if others else [0])[-1] * grid.step_s)
    return place_as(timed, loop.robots, headway, grid)


def timetable_through(loop: Loop, headway: int, grid: Grid, others: Sequence[Placed]) -> tuple[int, Floats] | None:
    """A timetable that passes the others: the sample at which it begins, and how far along the loop (n,) it is.

    How far along is told at every sample of one round, its end included, in seconds at full speed from the loop's
    start. None: there is no such timetable.
    """
    if not loop.may_wait:
        return None
    split = math.ceil(loop.natural_s / loop.robots / grid.step_s)
    steps = min(split + 1, headway)  # within a headway: a hair slower than full speed, so that knots can be moved
    if split > headway:
        return None
    whole = steps * loop.robots
    along_s = np.arange(whole) * (loop.natural_s / whole)
    places = loop.line.at(along_s)
    blocked = blocks_by_others(cKDTree(places), headway, grid.apart_m, others)
    if blocked.all(axis=1).any():
        return None  # somebody is always there
    for base in bases(blocked, loop.robots):
        rows = np.roll(blocked, -base, axis=0)
        if loop.robots == 1:
            start_and_places = one_robot(np.vstack([rows, rows[:1]]), headway)
        else:
            start_and_places = several_robots(np.roll(places, -base, axis=0), rows, loop.robots, headway, grid.apart_m)
        if start_and_places is not None:
            start, place = start_and_places
            return start, np.asarray((base + place) * (loop.natural_s / whole), dtype=np.float64)
    return None


def blocks_by_others(tree: cKDTree, headway: int, apart_m: float, others: Sequence[Placed]) -> Bytes:
    """Where along the loop (places) at which time of its headway (columns) one of the others is near."""
    blocked = np.zeros((tree.n, headway), dtype=np.uint8)
    for other in others:
        near = near_pairs(tree, other.tree, apart_m)
        if near is None:
            return np.ones((tree.n, headway), dtype=np.uint8)
        if other.tree.n == 1:
            blocked[near[0]] = 1
            continue
        measure = math.gcd(headway, other.headway)
        once = np.zeros((tree.n, measure), dtype=np.uint8)
        once[near[0], near[1] % measure] = 1
        blocked |= np.tile(once, (1, headway // measure))
    return blocked


def bases(blocked: Bytes, robots: int) -> list[int]:
    """Places to begin a round, where others are least often: one for a robot alone, else several, evenly spread."""
    busy = blocked.sum(axis=1, dtype=np.int64)
    if robots == 1:
        return [int(np.argmin(busy))]
    between = len(busy) // robots
    busy = busy.reshape(robots, between).sum(axis=0)
    chosen = np.unique(np.linspace(0, between, FEW_TRIED, endpoint=False).astype(np.int64))
    return [int(base) for base in chosen[np.argsort(busy[chosen], kind="stable")]]


def one_robot(blocked: Bytes, headway: int) -> tuple[int, Ints] | None:
    """When a robot begins its round and at which place (headway + 1,) it is at each sample; None: it never can.

    blocked (places, headway): the last place is the first one again.
    """
    latest = np.empty((len(blocked), 2 * headway), dtype=np.int32)
    kernels.latest_starts(blocked, np.ones(2 * headway, dtype=np.uint8), latest)
    starts = np.arange(headway)
    spare = latest[-1, headway:].astype(np.int64) - starts
    hopeful = np.flatnonzero(spare >= 0)
    hopeful = hopeful[np.argsort(-spare[hopeful], kind="stable")][:24]  # moments at which a round begins
    for start in hopeful:
        place = through(np.roll(blocked, -int(start), axis=1), headway)
        if place is not None:
            return int(start), place
    return None


def through(blocked: Bytes, headway: int) -> Ints | None:
    """The place (headway + 1,) at each sample of a robot that begins at once and arrives at the end of the headway.

    blocked (places, columns): columns are times from its beginning on. None: it cannot.
    """
    if blocked[0, 0]:
        return None
    begins = np.ones(headway + 1, dtype=np.uint8)
    taken = np.flatnonzero(blocked[0, np.arange(headway + 1) % blocked.shape[1]])
    if len(taken):
        begins[taken[0] :] = 0  # it cannot wait any longer
    latest = np.empty((len(blocked), headway + 1), dtype=np.int32)
    kernels.latest_starts(blocked, begins, latest)
    if latest[-1, headway] < 0:
        return None
    place = np.zeros(headway + 1, dtype=np.int64)
    kernels.places_until(latest, headway, place)
    return place


def several_robots(
    places_m: Floats, blocked: Bytes, robots: int, headway: int, apart_m: float
) -> tuple[int, Ints] | None:
    """The same for robots that share a loop: each within a headway, one after the other.

    In every headway each goes on to where the next one was; so the loop is cut into as many equal stretches, which are
    timed like loops of their own. Returns when they begin, and the place at each sample of a whole round.
    """
    steps = len(places_m) // robots
    ends = places_m[np.arange(robots) * steps]
    if cKDTree(ends).query_pairs(apart_m):
        return None
    stretches = [np.arange(i * steps, (i + 1) * steps + 1) % len(places_m) for i in range(robots)]
    trees = [cKDTree(places_m[stretch]) for stretch in stretches]
    columns = np.arange(headway + 1)
    moments = 8 if blocked.any() else 1  # for robots that share a loop
    for start in np.unique(np.linspace(0, headway, moments, endpoint=False).astype(np.int64)):
        gone: list[Ints] = []
        for i, stretch in enumerate(stretches):
            barred = np.ascontiguousarray(blocked[stretch][:, (start + columns) % headway])
            for other, place in enumerate(gone):
                near = near_pairs(trees[i], cKDTree(places_m[stretches[other]][place]), apart_m)
                if near is None:
                    return None
                barred[near] = 1
            places = through(barred, headway)
            if places is None:
                break
            gone.append(places)
        else:
            whole = [places[:-1] + i * steps for i, places in enumerate(gone)]
            return int(start), np.concatenate([*whole, [len(places_m)]])
    return None


def with_knots(loop: Loop, along_s: Floats, start: int, step_s: float, duration_s: float) -> Timed:
    """The timetable of a round that is so far along (n,) the loop at every sample, begun at sample ``start``."""
    first_s = along_s[0] % loop.natural_s
    begun = start_at(loop.line, first_s)
    times_s = begun.times_s
    whole_s = along_s - along_s[0]
    whole_s[-1] = times_s[-1]
    bends = np.flatnonzero(np.abs(np.diff(whole_s, 2)) > 1e-6 * step_s) + 1
    knots = np.concatenate([[0], bends, [len(whole_s) - 1]])
    at_s, along_s = knots * step_s, whole_s[knots]
    # a knot hardly off a corner is moved there: no leg of hardly any length; so little that it never shows as speeding
    nearest = times_s[np.abs(along_s[:, None] - times_s[None]).argmin(axis=1)]
    along_s = np.where(np.abs(along_s - nearest) < step_s / (2 * len(whole_s)), nearest, along_s)
    corners_s = times_s[~np.isin(times_s, along_s)]
    before = np.searchsorted(along_s, corners_s) - 1
    share = (corners_s - along_s[before]) / (along_s[before + 1] - along_s[before])
    corners_at_s = at_s[before] + share * (at_s[before + 1] - at_s[before])
    order = np.argsort(np.concatenate([at_s, corners_at_s]), kind="stable")
    all_s = np.concatenate([at_s, corners_at_s])[order]
    along_s = np.concatenate([along_s, corners_s])[order]
    places = begun.at(along_s)
    places[-1] = places[0]
    all_s[-1] = duration_s
    return Timed(steady(all_s, places), -start * step_s % duration_s)

"""Which legs of different robots come so near each other that bodies might touch, in about linear time.

One tree of all legs would give each robot's legs as pairs with themselves: a robot that trembles on a spot, or goes
round a short way very often, has as many of those as the square of its legs. So legs before the loops are looked at in
slices of time, and so are loops that take equally long, whose robots are side by side at the same moments for ever; of
robots that take turns at one way, all legs are near all others. Robots that hold are looked at as one leg each, and
other loops robot by robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.check.arrays import Flags, Floats, Ints
from rota.check.distances import segment_distances
from rota.check.routes import HOLD, LOOP, TRANSIENT, Routes, lines_of
from rota.check.tolerances import SAME_TURN, TOUCH_M

FEWEST_IN_SLICE = 128
MOST_AT_ONCE = 2_000_000  # pairs of legs that one question to a tree may give


class _Lines(NamedTuple):
    """The w different lines of n legs: as geometries (w,), as rows (w, 4) in metres, and which (n,) each leg goes.

    They stand in the order in which legs first go them.
    """

    shapes: NDArray[np.object_]
    ends_m: Floats
    of_leg: Ints


def _lines(routes: Routes) -> _Lines:
    """The lines of all legs."""
    _, first, of_leg = np.unique(routes.legs_m, axis=0, return_index=True, return_inverse=True)
    ends_m = routes.legs_m[np.sort(first)]
    return _Lines(lines_of(ends_m), ends_m, np.argsort(np.argsort(first))[of_leg.ravel()])


def near_legs(routes: Routes, bodies_m: Floats) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of legs whose lines come nearer than the two bodies allow, less the tolerance; the lower robot's leg first.

    bodies_m: (k,) radii. No pair is given twice. Pairs before the loops, and of loops that take equally long, are only
    those that meet in time.
    """
    if len(routes.legs_m):
        reach_m = float(np.sort(bodies_m)[-2:].sum())
        for a, b, distance in _candidates(routes, _lines(routes), reach_m):
            swap = routes.robots[a] > routes.robots[b]
            a, b = np.where(swap, b, a), np.where(swap, a, b)
            close = distance < bodies_m[routes.robots[a]] + bodies_m[routes.robots[b]] - TOUCH_M
            if close.any():
                yield a[close], b[close]


def _candidates(routes: Routes, lines: _Lines, reach_m: float) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Pairs of legs of different robots within a distance as lines, and that distance of each."""
    before, holds, loops = (np.flatnonzero(routes.kinds == kind) for kind in (TRANSIENT, HOLD, LOOP))
    for in_turn, after_s, _ in _slices(routes.times_s[before], len(routes.durations_s)):
        for a, b, distance in _near_pairs(routes, lines, before[in_turn], before[in_turn], reach_m):
            # the slice in which the later of two legs begins has both
            start = np.maximum(routes.times_s[a, 0], routes.times_s[b, 0])
            in_slice = (a < b) & (start > after_s) & (start <= np.minimum(routes.times_s[a, 1], routes.times_s[b, 1]))
            yield a[in_slice], b[in_slice], distance[in_slice]
    yield from ((a[a < b], b[a < b], far[a < b]) for a, b, far in _near_pairs(routes, lines, holds, holds, reach_m))
    yield from _near_pairs(routes, lines, before, holds, reach_m)
    _, in_step = np.unique(np.column_stack([routes.classes, routes.parts]), axis=0, return_inverse=True)
    turns = np.where(routes.kinds == LOOP, in_step.ravel()[routes.robots], -1)
    for turn in np.unique(turns[loops]):
        yield from _meeting_in_loops(routes, lines, np.flatnonzero(turns == turn), reach_m)
    for robot in np.unique(routes.robots[loops]):
        own = loops[routes.robots[loops] == robot]
        others = (routes.robots > robot) & (turns != turns[own[0]])
        others |= (routes.robots < robot) & (routes.kinds != LOOP)
        yield from _near_pairs(routes, lines, own, _beside(routes, own, others, reach_m), reach_m)


def _meeting_in_loops(routes: Routes, lines: _Lines, legs: Ints, reach_m: float) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Pairs as ``_candidates`` gives them, of legs (n,) of loops that take equally long, that meet in any turn."""
    robots = np.unique(routes.robots[legs])
    if len(robots) < 2:
        return
    turn_s = float(routes.parts[robots[0]] * routes.units_s[routes.classes[robots[0]]])
    from_s = np.mod(routes.times_s[legs, 0], turn_s)
    lasts_s = np.diff(routes.times_s[legs], axis=1)[:, 0] + 2 * SAME_TURN * turn_s
    over = np.flatnonzero(from_s + lasts_s >= turn_s)  # it ends after the next turn has begun
    leg = np.concatenate([np.arange(len(legs)), over])
    begin_s = np.concatenate([from_s, from_s[over] - turn_s])
    for in_turn, after_s, until_s in _slices(np.column_stack([begin_s, begin_s + lasts_s[leg]]), len(robots)):
        own = legs[np.unique(leg[in_turn])]
        begins = (from_s > after_s) & (from_s <= until_s)
        for a, b, distance in _near_pairs(routes, lines, own, own, reach_m):
            i, j = np.searchsorted(legs, a), np.searchsorted(legs, b)
            # the slice has both in which one begins while the other lasts
            later = np.mod(from_s[j] - from_s[i], turn_s) <= lasts_s[i]
            sooner = ~later & (np.mod(from_s[i] - from_s[j], turn_s) <= lasts_s[j])
            in_slice = (a < b) & np.where(later, begins[j], sooner & begins[i])
            yield a[in_slice], b[in_slice], distance[in_slice]


def near_ways(routes: Routes, reach_m: float) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of legs of different robots within a distance as lines, whatever their times; the lower robot's leg first.

    No pair is given twice.
    """
    lines = _lines(routes)
    for robot in np.unique(routes.robots):
        own = np.flatnonzero(routes.robots == robot)
        beside = _beside(routes, own, routes.robots > robot, reach_m)
        yield from ((a, b) for a, b, _ in _near_pairs(routes, lines, own, beside, reach_m))


def _beside(routes: Routes, own: Ints, others: Flags, reach_m: float) -> Ints:
    """Those of other legs whose boxes come within a distance of the box round one's own."""
    low = np.minimum(routes.legs_m[:, :2], routes.legs_m[:, 2:])
    high = np.maximum(routes.legs_m[:, :2], routes.legs_m[:, 2:])
    left, right = low[own].min(axis=0) - reach_m, high[own].max(axis=0) + reach_m
    return np.flatnonzero(others & (low <= right).all(axis=1) & (high >= left).all(axis=1))


def _slices(times_s: Floats, robots: int) -> Iterator[tuple[Ints, float, float]]:
    """Times (n, 2) from, to of legs in slices: the legs of each, the time after which it begins, and its last one.

    As many legs begin in a slice as there are robots, or some more; each robot is on one leg more as it begins. So all
    slices together have not much more than 2 n legs.
    """
    starts = np.sort(times_s[:, 0])
    size = max(FEWEST_IN_SLICE, robots)
    edges = np.concatenate([[-np.inf], np.unique(starts[size::size]), [np.inf]])
    first = np.searchsorted(edges, times_s[:, 0]) - 1
    last = np.maximum(first, np.searchsorted(edges, times_s[:, 1]) - 1)
    count = last - first + 1
    leg = np.repeat(np.arange(len(times_s)), count)
    piece = np.arange(len(leg)) - np.repeat(np.cumsum(count) - count, count) + first[leg]
    order = np.argsort(piece, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(piece[order])) + 1):
        if len(members):
            k = int(piece[members[0]])
            yield leg[members], float(edges[k]), float(edges[k + 1])


def _near_pairs(
    routes: Routes, lines: _Lines, first_legs: Ints, second_legs: Ints, reach_m: float
) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Pairs of a leg of ``first_legs`` and one of ``second_legs``, of different robots, within a distance as lines.

    first_legs, second_legs: numbers of legs. Yields (p,) numbers of legs of each, and their distances in metres.
    """
    if not len(first_legs) or not len(second_legs):
        return
    first, second = _by_line(lines, first_legs), _by_line(lines, second_legs)
    tree = shapely.STRtree(lines.shapes[first.lines])
    at_once = max(1, MOST_AT_ONCE // len(first.lines))
    for k in range(0, len(second.lines), at_once):
        near, own = tree.query(lines.shapes[second.lines[k : k + at_once]], predicate="dwithin", distance=reach_m)
        order = np.lexsort((own, near))
        near, own = near[order] + k, own[order]
        distance, _ = segment_distances(lines.ends_m[first.lines[own]], lines.ends_m[second.lines[near]])
        pairs = np.diff(first.begin)[own] * np.diff(second.begin)[near]
        for some in np.split(np.arange(len(pairs)), _cuts(pairs)):
            pair, turn = _number(pairs[some])
            pair = some[pair]
            a_turn, b_turn = np.divmod(turn, np.diff(second.begin)[near[pair]])
            a = first.legs[first.begin[own[pair]] + a_turn]
            b = second.legs[second.begin[near[pair]] + b_turn]
            different = routes.robots[a] != routes.robots[b]
            yield a[different], b[different], distance[pair[different]]


class _ByLine(NamedTuple):
    """Some legs by their lines: those of lines[k] are legs[begin[k] : begin[k + 1]]."""

    lines: Ints
    begin: Ints
    legs: Ints


def _by_line(lines: _Lines, legs: Ints) -> _ByLine:
    """Some legs, numbers (n,), by their lines."""
    order = np.argsort(lines.of_leg[legs], kind="stable")
    which, begin = np.unique(lines.of_leg[legs[order]], return_index=True)
    return _ByLine(which, np.append(begin, len(legs)), legs[order])


def _cuts(counts: Ints) -> Ints:
    """Where to cut a list so that the counts (n,) of each part are not many more than MOST_AT_ONCE."""
    return np.flatnonzero(np.diff(np.cumsum(counts) // MOST_AT_ONCE)) + 1


def _number(counts: Ints) -> tuple[Ints, Ints]:
    """Each index as often as its count (n,) says, and the number of each time, from 0 on."""
    index = np.repeat(np.arange(len(counts)), counts)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)

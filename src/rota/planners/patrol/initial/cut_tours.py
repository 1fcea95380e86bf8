"""A tour that several robots share, cut into tours of one robot each that drive all of its legs.

On a scanned floor a shared tour goes there and back through the same doors, where its robots meet whatever their
phases: their headways are all alike. Tours of one robot each can be driven in any phase and direction.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies.timing import crowds_that_touch


class Cuts(NamedTuple):
    """Where a tour may be cut: stations (s,) among its vertices, and lengths (s, s + 1).

    lengths_m[i, m]: of the closed tour that leads from station i past m - 1 others to the m-th after it, and back by
    the shortest way; inf where m is 0.
    """

    stations: Ints
    lengths_m: Floats


def cut_where_bodies_touch(problem: Problem, tours: list[Tour]) -> list[Tour]:
    """The tours, those whose robots no timing keeps apart from each other and from those of others cut.

    Each part has one robot, and there are as few as leave some of their budgets over. A loop that others are nested
    in, and a tour that cannot be cut so, stays as it is.
    """
    touching = {k for crowd in crowds_that_touch(tours, problem.robot.body_radius_m) for k in crowd}
    hubs = {tour.nest for tour in tours}
    return [
        each
        for k, tour in enumerate(tours)
        for each in (cut(problem, tour) if k in touching and tour.robots > 1 and hubs <= {-1} else [tour])
    ]


def cut(problem: Problem, tour: Tour) -> list[Tour]:
    """One tour cut; the longest of the parts is as short as it can be for so many."""
    budget_m = replace(tour, robots=1).budget_m
    cuts = possible_cuts(problem, tour, budget_m / 48)  # places to a budget where a tour may be cut
    full_m = 0.94 * budget_m  # repair leads it past more places
    parts = fewest_parts(cuts, full_m)
    if parts is None:
        return [tour]
    low, high = 0.0, full_m
    for _ in range(12):  # halvings, to less than a thousandth of the budget
        middle = (low + high) / 2
        tighter = fewest_parts(cuts, middle)
        if tighter is not None and len(tighter) <= len(parts):
            parts, high = tighter, middle
        else:
            low = middle
    ends = [cuts.stations[station] for station in [*parts, parts[0]]]
    return [part_of(problem, tour, int(a), int(b)) for a, b in pairwise(ends)]


def possible_cuts(problem: Problem, tour: Tour, apart_m: float) -> Cuts:
    """Stations about so far apart along the tour, with the lengths of all tours between two of them.

    Ways back are exact between stations within four times as far.
    """
    vertices = tour.vertices_m
    along_m = np.concatenate([[0.0], np.cumsum(np.hypot(*(np.roll(vertices, -1, axis=0) - vertices).T))])
    stations = np.unique(np.floor(along_m[:-1] / apart_m), return_index=True)[1].astype(np.int64)
    count, at_m = len(stations), along_m[stations]
    back_m = problem.paths.lengths_from_point_to_point(vertices[stations], 4 * apart_m)
    last = np.arange(count)[:, None] + np.arange(count + 1)
    driven_m = at_m[last % count] + np.where(last >= count, along_m[-1], 0.0) - at_m[:, None]
    lengths_m = driven_m + back_m[np.arange(count)[:, None], last % count]
    lengths_m[:, 0] = np.inf
    return Cuts(stations, lengths_m)


def fewest_parts(cuts: Cuts, most_m: float) -> list[int] | None:
    """The stations (k,) at which the fewest parts begin, none longer than ``most_m``; None: there is no such cut.

    From every station on, each part goes as far as it may.
    """
    count = len(cuts.stations)
    fits = cuts.lengths_m <= most_m
    if not fits.any(axis=1).all():
        return None
    reach = count - np.argmax(fits[:, ::-1], axis=1)
    begins, at = [np.arange(count)], np.arange(count) + reach
    while (at < np.arange(count) + count).all():
        begins.append(at)
        at = at + reach[at % count]
    first = int(np.argmax(at >= np.arange(count) + count))
    return [int(each[first]) % count for each in begins]


def part_of(problem: Problem, tour: Tour, a: int, b: int) -> Tour:
    """The tour from its a-th vertex to its b-th, and back by the shortest way."""
    vertices = tour.vertices_m
    some = vertices[a : b + 1] if a < b else np.vstack([vertices[a:], vertices[: b + 1]])
    back = problem.paths.paths_along(np.vstack([some[-1], some[0]]))[1:-1]
    return replace(tour, vertices_m=np.vstack([some, back]), robots=1)

"""Short closed tours by a seeded local search: the project's own way to the frame, in place of the paper's Algorithm 2.

Lin-Kernighan chains of 2-opt moves and or-opt over neighbour lists, then kicks (double bridges of two short stretches)
that are undone when the tour does not end shorter (Johnson and McGeoch, The traveling salesman problem: a case study
in local optimization, 1997: iterated Lin-Kernighan with segment insertions).
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.tours.order_kernels import nearest_neighbour_tour
from rota.planners.patrol.tours.visiting_order import nearest_places
from rota_studies.sun2019_stages.local_search_kernels import DEEPEST, Count, Search, improve, kicks

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def locally_shortest_tour(
    distance: Floats, *, kicks_per_waypoint: int, seed: int, nearness: Floats | None = None
) -> tuple[Ints, Floats]:
    """A short closed tour: its order (n,), and its length (r,) after the descent and after each hundredth of the kicks.

    distance: (n, n) symmetric and finite, in any unit. nearness: (n, n) another measure whose nearest waypoints are
    tried as well; for distances with penalties, the distance without them. kicks_per_waypoint: 0 or more; the work
    grows with it and with n. Up to 7 waypoints all orders are tried.
    """
    n = len(distance)
    distance = np.ascontiguousarray(distance, dtype=np.float64)
    if not np.isfinite(distance).all():
        raise ValueError("distance: every waypoint must be reachable from every other; it holds inf or nan")
    if kicks_per_waypoint < 0:
        raise ValueError(f"kicks_per_waypoint: {kicks_per_waypoint!r} is not allowed; must be 0 or more")
    if n < 8:  # nothing to search
        order = shortest_of_all(distance)
        return order, np.array([tour_length(distance, order)])
    search = _lay_out(distance, neighbours(distance, nearness), seed)
    eps = 1e-11 * float(distance.max())  # gains this small are rounding
    while search.ints[Count.QUEUED]:  # more than once only if there was no room to write all reversals down
        improve(eps, search)
        search.ints[0] = 0
    history = [tour_length(distance, search.order)]
    done, whole = 0, kicks_per_waypoint * n
    longest = min(30, (n - 2) // 3)  # stretches of a kick: near enough to mend in a few moves
    for share in range(1, 101):
        kicks(whole * share // 100 - done, longest, eps, search)
        done = whole * share // 100
        history.append(tour_length(distance, search.order))
    return search.order.copy(), np.array(history)


def tour_length(distance: Floats, order: Ints) -> float:
    """Length of the closed tour in the given order (n,) by the distances (n, n)."""
    return float(distance[order, np.roll(order, -1)].sum())


def neighbours(distance: Floats, nearness: Floats | None) -> Ints:
    """For each waypoint the others (n, k) worth a leg, nearest first: the eight nearest, then four by nearness."""
    n = len(distance)
    rows = np.arange(n)[:, None]
    near = nearest_places(distance, 8)
    if nearness is not None:
        apart = nearness.copy()
        np.fill_diagonal(apart, np.inf)
        apart[rows, near] = np.inf
        more = min(4, n - 1 - near.shape[1])
        near = np.hstack([near, np.argsort(apart, axis=1, kind="stable")[:, :more]])
    return np.ascontiguousarray(near[rows, np.argsort(distance[rows, near], axis=1, kind="stable")])


def shortest_of_all(distance: Floats) -> Ints:
    """The shortest of all closed tours; for a few waypoints."""
    n = len(distance)
    if n <= 3:
        return np.arange(n, dtype=np.int64)
    rest = np.array(list(itertools.permutations(range(1, n))), dtype=np.int64)
    orders = np.hstack([np.zeros((len(rest), 1), dtype=np.int64), rest])
    return np.asarray(orders[np.argmin(distance[orders, np.roll(orders, -1, axis=1)].sum(axis=1))])


def _lay_out(distance: Floats, near: Ints, seed: int) -> Search:
    """The search before its first move, from the nearest neighbour tour.

    distance: (n, n). near: (n, k) waypoints near each.
    """
    n = len(distance)
    order = nearest_neighbour_tour(distance)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    ints = np.zeros(len(Count), dtype=np.int64)
    ints[Count.QUEUED] = n
    room = 100_000  # reversals between two kicks that can be undone; a first descent takes a few per waypoint
    return Search(
        d=distance,
        near=near,
        order=order,
        place=place,
        queue=order.copy(),
        in_queue=np.ones(n, dtype=np.bool_),
        reversed=np.zeros((room, 2), dtype=np.int64),
        touched=np.zeros(2 * DEEPEST + 2, dtype=np.int64),
        ints=ints,
        rng=np.random.SeedSequence(seed).generate_state(1, np.uint64) | np.uint64(1),
    )

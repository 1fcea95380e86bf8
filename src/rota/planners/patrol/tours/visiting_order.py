"""A short closed tour over given places."""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.tolerances import SAME_PLACE_M
from rota.planners.patrol.tours.order_kernels import improve_once, nearest_neighbour_tour


def short_order(distance_m: Floats) -> Ints:
    """Order (n,) of a short closed tour over n places, given their distances (n, n) in metres, symmetric and finite.

    Nearest neighbour, then 2-opt and or-opt over the nearest places until neither helps; n <= 3 is any order.
    """
    n = len(distance_m)
    if n <= 3:
        return np.arange(n, dtype=np.int64)
    if not np.isfinite(distance_m).all():
        raise ValueError("every place must be reachable from every other: the distances hold inf or nan")
    distance_m = np.ascontiguousarray(distance_m, dtype=np.float64)
    order: Ints = nearest_neighbour_tour(distance_m)
    near = nearest_places(distance_m, 12)
    # sums of four may be off by so much; ends of a line are far below zero from each other
    least_m = max(SAME_PLACE_M, 4 * np.finfo(np.float64).eps * float(np.abs(distance_m).max()))
    while improve_once(distance_m, near, least_m, order):
        pass
    return order


def order_of_pairs(distance_m: Floats) -> list[tuple[int, bool]]:
    """The order of n lines in a short closed tour along all, each with whether it is driven backwards.

    distance_m: (2n, 2n) between their ends, those of a line one after the other; it is written to. The two ends are so
    far below zero from each other that no exchange parts them.
    """
    pairs = np.arange(0, len(distance_m), 2)
    distance_m[pairs, pairs + 1] = distance_m[pairs + 1, pairs] = -1e3 * (1 + float(distance_m.max()))
    order = short_order(distance_m)
    if order[0] // 2 != order[1] // 2:
        order = np.roll(order, 1)
    return [(int(first) // 2, bool(first % 2)) for first in order[::2]]


def nearest_places(distance: Floats, count: int) -> Ints:
    """For each of n places the nearest others (n, k), nearest first; k is the count, or n - 1. distance: (n, n).

    Of places as near as each other the first is nearer.
    """
    n = len(distance)
    k = min(count, n - 1)
    near = np.empty((n, k), dtype=np.int64)
    for first in range(0, n, 256):  # all rows at once would take two more such tables
        apart = distance[first : first + 256].copy()
        own = np.arange(len(apart))
        apart[own, first + own] = np.inf
        row, place = np.nonzero(apart <= np.partition(apart, k - 1, axis=1)[:, k - 1 : k])
        place = place[np.lexsort((apart[row, place], row))]
        near[first + own] = place[np.searchsorted(row, own)[:, None] + np.arange(k)]
    return near

"""Over all subsets of a few places: shortest round trips, and the cheapest way to share the places among robots.

A subset is a number whose bits are its places.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import kernel


@kernel
def lowest_place(subset: int) -> int:
    """The place with the lowest number in a subset that is not empty."""
    place = 0
    while not subset >> place & 1:
        place += 1
    return place


@kernel
def round_trips(leg: Any) -> tuple[Any, Any]:
    """The time of the shortest round trip through each subset (2^n,), 0 for one place; and the shortest ways.

    leg: (n, n), 0 on the diagonal. The latter are (2^n, n): from a subset's lowest place through all of it to a place.

    Source. M. Held and R. M. Karp, "A Dynamic Programming Approach to Sequencing Problems", 1962.
    """
    n = leg.shape[0]
    trip, way = np.zeros(1 << n), np.full((1 << n, n), np.inf)
    for subset in range(1, 1 << n):
        low = lowest_place(subset)
        if subset == 1 << low:
            way[subset, low] = 0.0
        trip[subset] = np.inf
        for j in range(low, n):
            if not np.isfinite(way[subset, j]):
                continue
            trip[subset] = min(trip[subset], way[subset, j] + leg[j, low])
            for k in range(low + 1, n):
                if not subset >> k & 1:
                    way[subset | 1 << k, k] = min(way[subset | 1 << k, k], way[subset, j] + leg[j, k])
    return trip, way


@kernel
def cheapest_sharing(cost: Any) -> Any:
    """The part (2^n,) of each subset that holds its lowest place in the cheapest way to cut it into parts.

    cost (2^n,): of each subset as one part; inf where it is none.
    """
    count = cost.shape[0]
    least, part = np.zeros(count), np.zeros(count, np.int64)
    for subset in range(1, count):
        low = subset & -subset
        rest = subset ^ low
        least[subset] = np.inf
        other = rest
        while True:  # all subsets of the rest: the parts without the lowest place
            whole = cost[subset ^ other] + least[other]
            if whole < least[subset]:
                least[subset], part[subset] = whole, subset ^ other
            if other == 0:
                break
            other = (other - 1) & rest
    return part

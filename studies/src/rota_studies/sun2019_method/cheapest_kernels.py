# mypy: disable-error-code="no-any-return"
"""Compiled search for the partition of a closed frame with the lowest cost of all by Eq. 28 (Sun et al. 2019)."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota_studies.sun2019_method.pso_kernels import Rules, cost_of, late_s
from rota_studies.sun2019_stages.partition_kernels import Ring


@allocation_free
def cheapest_partition(segments: int, rules: Rules, ring: Ring, price: Any, cost: Any, chosen: Any, first: Any) -> int:
    """Fill first (n,) with the first waypoints of the cheapest partition's segments; returns how many there are.

    segments: exactly so many, or 0 for as many as are cheapest. The cost is a sum over segments, whatever their routes'
    lengths are. So dynamic programming from every waypoint where a segment may begin gives the least. price: (n, n)
    room for the cost of each segment. cost, chosen: (segments + 1, n + 1) room for sums and for the last segment's
    count. Of equal partitions the first stays.
    """
    n = price.shape[0]
    for at in range(n):
        for count in range(1, n + 1):
            price[at, count - 1] = cost_of(late_s(at, count, rules.margin_s, ring), rules)
    step = 1 if segments > 0 else 0
    best, filled = math.inf, 0
    for start in range(n):
        sum_up_from(start, segments, price, cost, chosen)
        if cost[segments, n] < best:
            best, filled = cost[segments, n], 0
            at, layer = n, segments
            while at > 0:
                at -= chosen[layer, at]
                layer -= step
                first[filled] = (start + at) % n
                filled += 1
    return filled


@allocation_free
def sum_up_from(start: int, segments: int, price: Any, cost: Any, chosen: Any) -> None:
    """Fill cost's last row with the least cost of the first ``at`` waypoints from ``start`` on, for all at.

    With ``segments`` 0 there is only that row, for any number of segments. Otherwise row k is for exactly k segments.
    """
    n = price.shape[0]
    step = 1 if segments > 0 else 0
    for layer in range(segments + 1):
        for at in range(n + 1):
            cost[layer, at] = math.inf
    cost[0, 0] = 0.0
    for at in range(n):
        first = (start + at) % n
        for layer in range(segments + 1 - step):
            before = cost[layer, at]
            if before == math.inf:
                continue
            for count in range(1, n - at + 1):
                whole = before + price[first, count - 1]
                if whole < cost[layer + step, at + count]:
                    cost[layer + step, at + count] = whole
                    chosen[layer + step, at + count] = count

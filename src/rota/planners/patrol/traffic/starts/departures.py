"""When each robot leaves its start: all so as to arrive together, or one after the other where bodies would touch."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.planners.patrol.traffic.starts.approaches import Way

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOST_DELAYS = 400  # that are tried for one robot


def departures_s(ways: Sequence[Way], bodies_m: Sequence[float]) -> Floats | None:
    """When each robot leaves (k,), in seconds; None when somebody is in the way whatever the order.

    Robots stand at their starts before they leave and at their loops once they have arrived. Preferred: all arrive at
    the same moment. Otherwise they leave in an order in which nobody stands in another's way, each as early as it can.
    """
    together = together_s(ways)
    near = ways_that_meet(ways, bodies_m)
    if not near or all(apart(ways[i], ways[j], together[i], together[j], bodies_m[i] + bodies_m[j]) for i, j in near):
        return together
    order = order_of_leaving(ways, bodies_m, near)
    if order is None:
        return None
    meets: dict[int, list[int]] = {k: [] for k in range(len(ways))}
    for i, j in near:
        meets[i].append(j)
        meets[j].append(i)
    leaves = np.zeros(len(ways))
    gone: list[int] = []
    for k in order:
        others = [j for j in meets[k] if j in gone]
        surely_s = max((leaves[j] + ways[j].duration_s for j in others), default=0.0)  # when they all have arrived
        for delay_s in np.linspace(0.0, surely_s, MOST_DELAYS if surely_s else 1):
            if all(apart(ways[k], ways[j], delay_s, leaves[j], bodies_m[k] + bodies_m[j]) for j in others):
                leaves[k] = delay_s
                break
        else:
            return None
        gone.append(k)
    # nobody waits at the loop who can wait at the start, if that keeps all apart
    done_s = max(float(leaves[k]) + way.duration_s for k, way in enumerate(ways))
    for k in reversed(order):
        late = done_s - ways[k].duration_s
        if all(apart(ways[k], ways[j], late, leaves[j], bodies_m[k] + bodies_m[j]) for j in meets[k]):
            leaves[k] = late
    return leaves


def together_s(ways: Sequence[Way]) -> Floats:
    """When each robot leaves (k,), in seconds, so that all arrive at the same moment, as early as it can be."""
    latest_s = max((way.duration_s for way in ways), default=0.0)
    return np.array([latest_s - way.duration_s for way in ways])


def ways_that_meet(ways: Sequence[Way], bodies_m: Sequence[float]) -> list[tuple[int, int]]:
    """Pairs i < j of robots whose ways, as lines, come nearer to each other than their bodies allow."""
    lines = [line_of(way) for way in ways]
    widest_m = 2 * max(bodies_m, default=0.0)
    if widest_m == 0:
        return []
    a, b = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=widest_m)
    return sorted(
        (int(i), int(j))
        for i, j in zip(a, b, strict=True)
        if i < j and shapely.distance(lines[i], lines[j]) < bodies_m[i] + bodies_m[j]
    )


def line_of(way: Way) -> shapely.LineString | shapely.Point:
    """The way as a line; a point for a robot that is there already."""
    moved = (way.places_m != way.places_m[0]).any()
    return shapely.LineString(way.places_m) if moved else shapely.Point(way.places_m[0])


def order_of_leaving(
    ways: Sequence[Way], bodies_m: Sequence[float], near: Sequence[tuple[int, int]]
) -> list[int] | None:
    """An order in which nobody passes one that still stands at its start or already at its loop; None: there is none.

    Of those who may go next, the one with the longest way goes first.
    """
    lines = [line_of(way) for way in ways]
    before: dict[int, set[int]] = {k: set() for k in range(len(ways))}
    for pair in near:
        for k, j in (pair, pair[::-1]):
            apart_m = bodies_m[k] + bodies_m[j]
            if lines[k].distance(shapely.Point(ways[j].start_m)) < apart_m:
                before[k].add(j)
            if lines[k].distance(shapely.Point(ways[j].entry_m)) < apart_m:
                before[j].add(k)
    order: list[int] = []
    while len(order) < len(ways):
        free = [k for k in range(len(ways)) if k not in order and before[k] <= set(order)]
        if not free:
            return None
        order.append(max(free, key=lambda k: (ways[k].duration_s, -k)))
    return order


def apart(one: Way, other: Way, leaves_s: float, other_leaves_s: float, apart_m: float) -> bool:
    """Whether two robots that leave at these times stay so far apart for ever, standing before and after their ways."""
    mine_s, theirs_s = one.times_s + leaves_s, other.times_s + other_leaves_s
    moments = np.union1d(mine_s, theirs_s)
    gap = np.column_stack(
        [
            np.interp(moments, mine_s, one.places_m[:, axis]) - np.interp(moments, theirs_s, other.places_m[:, axis])
            for axis in (0, 1)
        ]
    )
    drift = np.diff(gap, axis=0)
    drift2 = (drift**2).sum(axis=1)
    share = np.clip(-(gap[:-1] * drift).sum(axis=1) / np.where(drift2 > 0, drift2, 1.0), 0.0, 1.0)
    nearest = gap[:-1] + share[:, None] * drift
    least_m = min([float(np.hypot(*gap[0])), *np.hypot(*nearest.T)], default=math.inf)
    return least_m >= apart_m

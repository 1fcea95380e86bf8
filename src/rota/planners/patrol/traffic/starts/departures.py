"""When each robot leaves its start: all so as to arrive together, or one after the other where bodies would touch."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely

from rota.model.arrays import Floats
from rota.planners.patrol.tours.timetable import line_of
from rota.planners.patrol.traffic.starts.approaches import Approach


def departures_s(approaches: Sequence[Approach], bodies_m: Sequence[float]) -> Floats | None:
    """When each robot leaves (k,), in seconds; None when robots block each other whatever the order.

    Robots stand at their starts before they leave and at their loops once they have arrived. They all arrive at the
    same moment if they can. Otherwise they leave in an order in which nobody blocks another's approach, each as early
    as it can.
    """
    together = together_s(approaches)
    near = approaches_that_meet(approaches, bodies_m)

    def keep_apart(i: int, j: int, leaves_i_s: float, leaves_j_s: float) -> bool:
        return apart(approaches[i], approaches[j], leaves_i_s, leaves_j_s, bodies_m[i] + bodies_m[j])

    if all(keep_apart(i, j, together[i], together[j]) for i, j in near):
        return together
    order = order_of_leaving(approaches, bodies_m, near)
    if order is None:
        return None
    meets: dict[int, list[int]] = {k: [] for k in range(len(approaches))}
    for i, j in near:
        meets[i].append(j)
        meets[j].append(i)
    leaves = np.zeros(len(approaches))
    gone: list[int] = []
    for k in order:
        others = [j for j in meets[k] if j in gone]
        all_there_s = max((leaves[j] + approaches[j].duration_s for j in others), default=0.0)
        for delay_s in np.linspace(0.0, all_there_s, 400 if all_there_s else 1):
            if all(keep_apart(k, j, delay_s, leaves[j]) for j in others):
                leaves[k] = delay_s
                break
        else:
            return None
        gone.append(k)
    # nobody waits at the loop who can wait at the start, if that keeps all apart
    done_s = max(float(leaves[k]) + approach.duration_s for k, approach in enumerate(approaches))
    for k in reversed(order):
        late = done_s - approaches[k].duration_s
        if all(keep_apart(k, j, late, leaves[j]) for j in meets[k]):
            leaves[k] = late
    return leaves


def together_s(approaches: Sequence[Approach]) -> Floats:
    """When each robot leaves (k,), in seconds, so that all arrive at the same moment, as early as it can be."""
    latest_s = max((approach.duration_s for approach in approaches), default=0.0)
    return np.array([latest_s - approach.duration_s for approach in approaches])


def approaches_that_meet(approaches: Sequence[Approach], bodies_m: Sequence[float]) -> list[tuple[int, int]]:
    """Pairs i < j of robots whose approaches, as lines, come nearer to each other than their bodies allow."""
    lines = [line_of(approach.places_m) for approach in approaches]
    widest_m = 2 * max(bodies_m, default=0.0)
    if widest_m == 0:
        return []
    a, b = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=widest_m)
    return sorted(
        (int(i), int(j))
        for i, j in zip(a, b, strict=True)
        if i < j and shapely.distance(lines[i], lines[j]) < bodies_m[i] + bodies_m[j]
    )


def order_of_leaving(
    approaches: Sequence[Approach], bodies_m: Sequence[float], near: Sequence[tuple[int, int]]
) -> list[int] | None:
    """An order in which nobody passes one that still stands at its start or already at its loop; None: there is none.

    Of those who may go next, the one with the longest approach goes first.
    """
    lines = [line_of(approach.places_m) for approach in approaches]
    before: dict[int, set[int]] = {k: set() for k in range(len(approaches))}
    for pair in near:
        for k, j in (pair, pair[::-1]):
            apart_m = bodies_m[k] + bodies_m[j]
            if lines[k].distance(shapely.Point(approaches[j].start_m)) < apart_m:
                before[k].add(j)
            if lines[k].distance(shapely.Point(approaches[j].entry_m)) < apart_m:
                before[j].add(k)
    order: list[int] = []
    while len(order) < len(approaches):
        free = [k for k in range(len(approaches)) if k not in order and before[k] <= set(order)]
        if not free:
            return None
        order.append(max(free, key=lambda k: (approaches[k].duration_s, -k)))
    return order


def apart(one: Approach, other: Approach, leaves_s: float, other_leaves_s: float, apart_m: float) -> bool:
    """Whether two robots that leave at these times stay ``apart_m`` apart for ever; they stand before and after."""
    mine_s, theirs_s = one.times_s + leaves_s, other.times_s + other_leaves_s
    moments = np.union1d(mine_s, theirs_s)
    gap = one.line.at(moments - leaves_s) - other.line.at(moments - other_leaves_s)
    drift = np.diff(gap, axis=0)
    drift2 = (drift**2).sum(axis=1)
    share = np.clip(-(gap[:-1] * drift).sum(axis=1) / np.where(drift2 > 0, drift2, 1.0), 0.0, 1.0)
    nearest = gap[:-1] + share[:, None] * drift
    least_m = min([float(np.hypot(*gap[0])), *np.hypot(*nearest.T)], default=math.inf)
    return least_m >= apart_m

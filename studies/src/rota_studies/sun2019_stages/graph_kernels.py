"""Compiled A* on the proximity graph. Steps from waypoint k are items[start[k] : start[k + 1]], with their costs."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.ground.sight_kernels import norm

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ANYWHERE = -1  # as goal: go on until all is reached; nothing is then known of the way that remains


class Steps(NamedTuple):
    """The graph: places (n,), rows of steps (n + 1,), the waypoints they lead to and what they cost (s,)."""

    x: Floats
    y: Floats
    start: Ints
    items: Ints
    cost: Floats


class Frontier(NamedTuple):
    """Room for one search: cost so far (n,), waypoint before (n,), and a binary heap of (s + 1,) entries.

    before is -1 where nothing was before, and what heap holds may be out of date: the cheaper entry comes first.
    """

    cost: Floats
    before: Ints
    closed: NDArray[np.bool_]
    key: Floats
    node: Ints


@allocation_free
def push(key: float, node: int, count: int, f: Frontier) -> int:
    """Put one entry on the heap; the number of entries after it."""
    at = count
    while at > 0:
        above = (at - 1) // 2
        if f.key[above] <= key:
            break
        f.key[at], f.node[at] = f.key[above], f.node[above]
        at = above
    f.key[at], f.node[at] = key, node
    return count + 1


@allocation_free
def pop(count: int, f: Frontier) -> int:
    """Take away the first entry of the heap, which the caller has read; returns the number of entries left."""
    count -= 1
    key, node = f.key[count], f.node[count]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= count:
            break
        if below + 1 < count and f.key[below + 1] < f.key[below]:
            below += 1
        if key <= f.key[below]:
            break
        f.key[at], f.node[at] = f.key[below], f.node[below]
        at = below
    f.key[at], f.node[at] = key, node
    return count


@allocation_free
def search(
    first: int, goal: int, tau_before: float, tau_step: float, tau_rest: float, s: Steps, f: Frontier
) -> int:  # fmt: skip
    """A* from ``first`` to ``goal`` (Eqs. 15-17) fills f.cost and f.before; returns how many waypoints left the heap.

    tau_before, tau_step, tau_rest: weights of the way so far, of the next step and of the straight line to the goal.
    """
    n = s.x.shape[0]
    for k in range(n):
        f.cost[k], f.before[k], f.closed[k] = math.inf, -1, False
    f.cost[first] = 0.0
    count = push(0.0, first, 0, f)
    taken = 0
    while count > 0:
        waypoint = f.node[0]
        count = pop(count, f)
        if f.closed[waypoint]:
            continue
        f.closed[waypoint] = True
        taken += 1
        if waypoint == goal:
            break
        for e in range(s.start[waypoint], s.start[waypoint + 1]):
            neighbour = s.items[e]
            cost = tau_before * f.cost[waypoint] + tau_step * s.cost[e]
            if f.closed[neighbour] or cost >= f.cost[neighbour]:
                continue
            f.cost[neighbour], f.before[neighbour] = cost, waypoint
            rest = norm(s.x[neighbour] - s.x[goal], s.y[neighbour] - s.y[goal]) if goal != ANYWHERE else 0.0
            count = push(cost + tau_rest * rest, neighbour, count, f)
    return taken


@allocation_free
def search_from_each(s: Steps, f: Frontier, distances: Any) -> None:
    """Fill distances (n, n) with the cost of the cheapest way from each waypoint to each; inf where none leads."""
    for k in range(s.x.shape[0]):
        search(k, ANYWHERE, 1.0, 1.0, 0.0, s, f)
        for m in range(s.x.shape[0]):
            distances[k, m] = f.cost[m]

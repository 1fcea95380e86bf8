"""Rounds that come to each place once: an order of all places, cut into rounds so that the fewest robots drive them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.compiled.kernel import kernel
from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.tolerances import SLOWER


@kernel
def split_at_best(order: Any, leg: Any, period: Any, per_load: float, least: Any, cut: Any) -> float:
    """The cost of the best rounds of places that follow each other in an order (m,); inf where some round has no way.

    A round takes the robots that come by within the shortest of its places' periods, each one, and ``per_load`` of the
    share of that time which they drive. leg (n, n), period (n,). least (m + 1,), cut (m + 1,) are written: the cost of
    the first places, and where their last round begins.

    Source. J. E. Beasley, "Route first - cluster second methods for vehicle routing", 1983.
    """
    m = order.shape[0]
    least[0] = 0.0
    for j in range(m):
        least[j + 1] = np.inf
    for i in range(m):
        way, shortest = 0.0, np.inf
        for j in range(i, m):
            if j > i:
                way += leg[order[j - 1], order[j]]
            shortest = min(shortest, period[order[j]])
            round_s = way + leg[order[j], order[i]]
            cost = least[i] + 1.0
            if round_s > 0:
                load = round_s / (SLOWER * shortest)
                cost = least[i] + math.ceil(load) + per_load * load if load < np.inf else np.inf
            if cost < least[j + 1]:
                least[j + 1], cut[j + 1] = cost, i
    return float(least[m])


@kernel
def move_some(order: Any, moved: Any, random: Any) -> None:
    """Write the order (m,) into moved (m,) with some places that follow each other turned round, or put elsewhere."""
    m = order.shape[0]
    length = 1 + int(uniform(random) * min(8, m - 1))  # places that one move takes elsewhere at most
    begin = int(uniform(random) * (m - length + 1))
    turned = uniform(random) < 0.5
    to = begin if uniform(random) < 0.3 else int(uniform(random) * (m - length + 1))
    k = 0
    for j in range(m):
        if to <= j < to + length:
            inner = j - to
            moved[j] = order[begin + (length - 1 - inner if turned else inner)]
        else:
            if k == begin:
                k += length
            moved[j] = order[k]
            k += 1


@kernel
def anneal_order(order: Any, leg: Any, period: Any, settings: Any, random: Any) -> float:
    """Improve an order (m,) of places in place by moves that cost less, or a little more at first; its cost.

    settings (4,): moves, cost that is accepted at first and at last, and ``per_load`` of ``split_at_best``.
    """
    m, moves, per_load = order.shape[0], int(settings[0]), settings[3]
    least, cut = np.zeros(m + 1), np.zeros(m + 1, np.int64)
    now, best = order.copy(), order.copy()
    moved = order.copy()
    cost = split_at_best(now, leg, period, per_load, least, cut)
    best_cost = cost
    for k in range(moves if m > 1 else 0):
        warmth = settings[1] * (settings[2] / settings[1]) ** (k / moves)
        move_some(now, moved, random)
        after = split_at_best(moved, leg, period, per_load, least, cut)
        if after - cost <= -warmth * math.log(max(uniform(random), 1e-300)):
            now, moved, cost = moved, now, after
            if cost < best_cost:
                best_cost = cost
                best[:] = now
    order[:] = best
    return float(best_cost)

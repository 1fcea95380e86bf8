"""Robots at least, since no robot can serve two of several places that are pairwise too far apart.

Statement. Let each of n places be served once in every window of its period T, and let a robot travel at speed V at
most. If the places that serve i and those that serve j are more than V (T_i + T_j) / 2 apart for all pairs, the team
has at least n robots. A group of ground that takes w robots within a window counts as w places.

Proof. Take windows of the periods with one common middle. Each place is served within its window, and two of these
times differ by at most (T_i + T_j) / 2. A robot that serves both would travel farther than it can.

Source. The heaviest clique is found by branch and bound with a colouring as the bound: E. Tomita and T. Seki, "An
Efficient Branch-and-Bound Algorithm for Finding a Maximum Clique", DMTCS 2003.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.tolerances import SURELY

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_NODES = 20_000  # of the search tree


def clique_bound(apart_m: Floats, period_s: Floats, speed_m_s: float) -> ProvedBound:
    """The bound for places (n) at least apart_m (n, n) from each other, with periods period_s (n,)."""
    apart = too_far_apart(apart_m, period_s, speed_m_s)
    robots = len(heaviest_clique(apart, np.ones(len(period_s), dtype=np.int64)))
    return ProvedBound(robots=robots, reason=too_far_apart_reason(robots))


def too_far_apart_reason(places: int) -> str:
    """The reason of a clique."""
    return f"{places} places are too far apart for one robot to serve two of them"


def too_far_apart(apart_m: Floats, period_s: Floats, speed_m_s: float) -> NDArray[np.bool_]:
    """Which pairs (n, n) no robot can serve both of, within windows of their periods that have one middle.

    apart_m: (n, n) metres; period_s: (n,).
    """
    between_s = (period_s[:, None] + period_s[None, :]) / 2
    return np.asarray(apart_m > SURELY * speed_m_s * between_s)


def heaviest_clique(joined: NDArray[np.bool_], weight: Ints) -> list[int]:
    """Pairwise joined vertices of the greatest total weight, in ascending order.

    joined: (n, n), symmetric, its diagonal ignored. weight: (n,), positive. After ``MOST_NODES`` nodes of the search
    tree the heaviest clique so far is the answer.
    """
    n = len(weight)
    neighbours = [0] * n
    for i in range(n):
        for j in np.flatnonzero(joined[i]):
            if j != i:
                neighbours[i] |= 1 << int(j)
    heavy = [int(w) for w in weight]
    best = max(
        (_greedy_clique(i, neighbours, heavy) for i in range(n)), key=lambda c: sum(heavy[v] for v in c), default=[]
    )
    nodes = 0

    def extend(clique: list[int], total: int, among: int) -> None:
        """Try to add vertices from ``among``, a bit each, to the clique, and keep the heaviest clique so far."""
        nonlocal best, nodes
        nodes += 1
        if total > sum(heavy[v] for v in best):
            best = list(clique)
        for v, bound in reversed(_colour_order(among, neighbours, heavy)):
            if nodes >= MOST_NODES or total + bound <= sum(heavy[u] for u in best):
                return
            extend([*clique, v], total + heavy[v], among & neighbours[v])
            among &= ~(1 << v)

    extend([], 0, (1 << n) - 1)
    return sorted(best)


def _greedy_clique(first: int, neighbours: list[int], weight: list[int]) -> list[int]:
    """A clique with vertex ``first`` and always the heaviest vertex that is joined to all so far."""
    clique, among = [first], neighbours[first]
    while among:
        v = max(_bits(among), key=lambda u: (weight[u], (neighbours[u] & among).bit_count(), -u))
        clique.append(v)
        among &= neighbours[v]
    return clique


def _colour_order(among: int, neighbours: list[int], weight: list[int]) -> list[tuple[int, int]]:
    """The vertices in an order, each with a bound on the weight of any clique of it and those before it.

    Vertices of one colour are not joined, so that the bound is the sum of the heaviest of each colour.
    """
    order: list[tuple[int, int]] = []
    total = 0
    while among:
        colour, left, heaviest = [], among, 0
        while left:
            v = (left & -left).bit_length() - 1
            colour.append(v)
            heaviest = max(heaviest, weight[v])
            left &= ~(1 << v) & ~neighbours[v]
        total += heaviest
        for v in colour:
            among &= ~(1 << v)
            order.append((v, total))
    return order


def _bits(mask: int) -> list[int]:
    """The numbers of the bits that are set."""
    return [k for k in range(mask.bit_length()) if mask >> k & 1]

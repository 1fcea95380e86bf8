"""Robots at least, since no robot can serve two of several groups of ground, and each group takes robots of its own.

Statement. Let each place of several groups of ground be served once in every window of its period, and let a robot
travel at speed V at most. Let T be the longest period within a group, and A its area. If the places that serve group i
and those that serve j are more than V (T_i + T_j) / 2 apart for all pairs, the team has at least the sum of
ceil(A / (sweep T + footprint)) over the groups.

Proof. Take windows of the periods with one common middle. Within a window of T all of a group comes into range, and one
robot has sweep T + footprint of ground in range at most (``area_bound``). Each place is served within its window, and
two of these times differ by at most (T_i + T_j) / 2. A robot that serves two groups would travel farther than it can.

Groups are made by joining what is near, and ground in between may be left out.

Source. The heaviest clique is found by branch and bound with a colouring as the bound: E. Tomita and T. Seki, "An
Efficient Branch-and-Bound Algorithm for Finding a Maximum Clique", DMTCS 2003.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import Robot
from rota.planners.patrol.bounds.pieces import Pieces, groupings, most_seen_m2
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.tolerances import SURELY

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def groups_bound(pieces: Pieces, robot: Robot) -> ProvedBound:
    """The best of all groupings; of equal ones that with the most groups."""
    best = (0, 0)
    for groups, gaps_m in groupings(pieces, robot):
        areas_m2 = np.array([pieces.area_m2[group].sum() for group in groups])
        periods_s = np.array([pieces.period_s[group].max() for group in groups])
        each = np.maximum(1, np.ceil(areas_m2 / most_seen_m2(robot, periods_s) / SURELY)).astype(np.int64)
        clique = heaviest_clique(too_far_apart(gaps_m, periods_s, robot.ground_speed_m_s), each)
        best = max(best, (int(each[clique].sum()), len(clique)))
    robots, groups_apart = best
    if robots == groups_apart:
        return ProvedBound(
            robots=robots, reason=f"{robots} places are too far apart for one robot to serve two of them"
        )
    return ProvedBound(
        robots=robots,
        reason=f"{groups_apart} pieces of ground are too far apart for one robot to serve two"
        " of them, and each takes robots of its own",
    )


def too_far_apart(apart_m: Floats, period_s: Floats, speed_m_s: float) -> NDArray[np.bool_]:
    """Which pairs (n, n) no robot can serve both of, within windows of their periods that have one middle.

    apart_m: (n, n) metres; period_s: (n,).
    """
    between_s = (period_s[:, None] + period_s[None, :]) / 2
    return np.asarray(apart_m > SURELY * speed_m_s * between_s)


def heaviest_clique(joined: NDArray[np.bool_], weight: Ints) -> list[int]:
    """Pairwise joined vertices of the greatest total weight, in ascending order.

    joined: (n, n), symmetric, its diagonal ignored. weight: (n,), positive. After 20,000 nodes of the search
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
            if nodes >= 20_000 or total + bound <= sum(heavy[u] for u in best):
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

"""Lower bounds on the number of robots from places that are far apart: cliques, chains, and long ways through all.

All of them look at arrays alone: ``apart_m`` (n, n) is the way from a place that serves one to a place that serves the
other, at least; each must be served at least once in every window of its period.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SURELY = 1 + 1e-6  # what must be exceeded is taken as longer by this, so that rounding never raises a bound
MOST_NODES = 20_000
ASCENTS = 60  # steps of the subgradient method
HOPELESS = (0.4, 0.85)  # of what must be exceeded: forests that are shorter, at first and later on, are given up
THINNINGS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5)  # least ways between the points kept, as shares of a window's travel


def too_far_apart(apart_m: Floats, period_s: Floats, speed_m_s: float) -> NDArray[np.bool_]:
    """Which pairs (n, n) no robot can serve both of, within windows of their periods that have one middle.

    Within such windows the two times differ by at most half the sum of the periods.
    """
    between_s = (period_s[:, None] + period_s[None, :]) / 2
    return np.asarray(apart_m > SURELY * speed_m_s * between_s)


def heaviest_clique(joined: NDArray[np.bool_], weight: Ints) -> list[int]:
    """Pairwise joined vertices of large total weight, the largest when few nodes of the search tree tell.

    joined (n, n): symmetric, diagonal ignored. weight (n,): positive. Branch and bound with a colouring as the bound
    (Tomita's method), at most ``MOST_NODES`` nodes; the answer is a clique even when that does not suffice.
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
        """Take up every heavier clique that adds some of the vertices ``among`` (a bit each) to this one."""
        nonlocal best, nodes
        nodes += 1
        if total > sum(heavy[v] for v in best):
            best = list(clique)
        for v, bound in reversed(_coloured(among, neighbours, heavy)):
            if nodes >= MOST_NODES or total + bound <= sum(heavy[u] for u in best):
                return
            extend([*clique, v], total + heavy[v], among & neighbours[v])
            among &= ~(1 << v)

    extend([], 0, (1 << n) - 1)
    return sorted(best)


def _greedy_clique(first: int, neighbours: list[int], weight: list[int]) -> list[int]:
    clique, among = [first], neighbours[first]
    while among:
        v = max(_bits(among), key=lambda u: (weight[u], (neighbours[u] & among).bit_count(), -u))
        clique.append(v)
        among &= neighbours[v]
    return clique


def _coloured(among: int, neighbours: list[int], weight: list[int]) -> list[tuple[int, int]]:
    """Vertices, each with a bound on any clique within it and those before: the sum of the heaviest of each colour."""
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
    return [k for k in range(mask.bit_length()) if mask >> k & 1]


def chain_robots(low_m: Floats, high_m: Floats, period_s: Floats, speed_m_s: float) -> tuple[int, float]:
    """Robots at least, from heights: any function of place that changes by at most a metre per metre of travel.

    Whoever serves point p stands at a height in [low_m, high_m] (n,). Number the robots at each instant from the
    lowest to the highest; the height of the k-th changes by at most the speed per second as well. If robots 1..k never
    rise above b, a point with low_m > b is served by robots of higher number only, so that robot k + 1 is at or below
    high_m of that point once in every window of its period T, and never above high_m + speed T / 2. So each step of a
    greedy chain takes a further robot. Also the height above which none of these robots ever rises.
    """
    ceiling_m = high_m + speed_m_s * period_s / 2
    robots, below_m = 0, -math.inf
    while True:
        above = low_m > below_m + (SURELY - 1) * abs(below_m) if robots else np.ones(len(low_m), dtype=bool)
        if not above.any():
            return robots, below_m
        robots, below_m = robots + 1, float(ceiling_m[above].min())


def best_chain(way_m: Floats, spread_m: Floats, period_s: Floats, speed_m_s: float) -> int:
    """Robots at least by chains whose heights are the ways from one of the centres, or their negatives.

    way_m (n, n): ways between the centres, all finite; spread_m (n,): how far from its centre a point is served.
    """
    most = 0
    for way in way_m:
        for height in (way, -way):
            most = max(most, chain_robots(height - spread_m, height + spread_m, period_s, speed_m_s)[0])
    return most


def straight_chain(xy_m: Floats, reach_m: float, period_s: Floats, speed_m_s: float, directions: int = 16) -> int:
    """Robots at least by chains whose heights are coordinates along so many directions; each way round counts."""
    most = 0
    for angle in np.pi * np.arange(directions) / directions:
        along = xy_m @ np.array([np.cos(angle), np.sin(angle)])
        for height in (along, -along):
            most = max(most, chain_robots(height - reach_m, height + reach_m, period_s, speed_m_s)[0])
    return most


def travel_robots(apart_m: Floats, window_s: float, speed_m_s: float, least: int = 1) -> tuple[int, Ints]:
    """Robots at least, since within any window their paths pass all points; also which points (m,) show it.

    All points must have periods of at most window_s. Paths of k robots are a forest of at most k trees in which no
    point has more than two neighbours, each edge as long as ``apart_m`` at least: the shortest forest of k trees, with
    prices p >= 0 on neighbours, less 2 sum p, is no longer than all of them (Held and Karp's bound). ``least``: what is
    known already, which is returned with no points when nothing better is found.
    """
    travel_m = window_s * speed_m_s * SURELY
    robots, shown = least, np.zeros(0, dtype=np.int64)
    for share in THINNINGS:
        kept = _thinned(apart_m, share * travel_m)
        if len(kept) <= robots:
            continue
        found = _forest_robots(apart_m[np.ix_(kept, kept)], travel_m, robots)
        if found > robots:
            robots, shown = found, kept
    return robots, shown


def _thinned(apart_m: Floats, least_m: float) -> Ints:
    """Points in their order, less those that are within ``least_m`` of, or not apart from, one kept before."""
    kept: list[int] = []
    for i in range(len(apart_m)):
        if not kept or apart_m[i, kept].min() > least_m:
            kept.append(i)
    return np.array(kept, dtype=np.int64)


def _forest_robots(apart_m: Floats, travel_m: float, robots: int) -> int:
    """The fewest robots, from ``robots`` on, that the forest bound does not rule out."""
    n = len(apart_m)
    price = np.zeros(n)
    cost = np.where(apart_m > travel_m, np.inf, apart_m)  # no robot goes that far within the window
    step_m = 0.1 * travel_m / max(n, 1)
    for ascent in range(ASCENTS):
        one, other, length = shortest_tree(cost + price[:, None] + price[None, :])
        sorted_m, paid = np.sort(length), 2 * float(price.sum())
        while robots < n and float(sorted_m[: n - robots].sum()) - paid > robots * travel_m:
            robots += 1
        share = (float(sorted_m[: n - robots].sum()) - paid) / (robots * travel_m)
        if share < HOPELESS[0] or (ascent >= 15 and share < HOPELESS[1]):
            break
        if robots >= n or not np.isfinite(length).any():
            break
        keep = np.isfinite(length)
        keep[np.argsort(length, kind="stable")[n - robots :]] = False
        degree = np.bincount(np.concatenate([one[keep], other[keep]]), minlength=n)
        price = np.maximum(0.0, price + step_m / (1 + ascent / 10) * (degree - 2))
    return robots


def shortest_tree(length_m: Floats) -> tuple[Ints, Ints, Floats]:
    """The minimum spanning tree of a complete graph (n, n) by Prim's method: ends and lengths of its n - 1 edges.

    Edges that are missing are infinitely long; the tree then has some.
    """
    n = len(length_m)
    away, nearest = length_m[0].copy(), np.zeros(n, dtype=np.int64)
    left = np.ones(n, dtype=bool)
    left[0] = False
    one, other, length = np.zeros(n - 1, dtype=np.int64), np.zeros(n - 1, dtype=np.int64), np.zeros(n - 1)
    for k in range(n - 1):
        rest = np.flatnonzero(left)
        v = int(rest[np.argmin(away[rest])])
        one[k], other[k], length[k] = nearest[v], v, away[v]
        left[v] = False
        closer = left & (length_m[v] < away)
        away[closer], nearest[closer] = length_m[v, closer], v
    return one, other, length

"""Robots at least, since within any window their paths pass all places that must be served in it.

Statement. Let n places have periods of at most T, and let apart(i, j) be the least way from a place that serves i to
one that serves j. A team of k robots at speed V has k V T >= F(k, p) for all prices p >= 0 on the places, where F(k, p)
is the length of the shortest forest of k trees under apart(i, j) + p_i + p_j, less 2 sum p.

Proof. In a window of T the paths of the robots, cut at the places, are a forest of at most k trees in which no place
has more than two neighbours. Its edges together are no longer than k V T, and the prices add at most 2 sum p to them.

Source. M. Held and R. M. Karp, "The Traveling-Salesman Problem and Minimum Spanning Trees", Operations Research 18,
1970; prices by subgradient ascent as in part II, Mathematical Programming 1, 1971.
"""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.tolerances import SURELY
from rota.planners.patrol.verdict import robots_in_words


def forest_bound(apart_m: Floats, window_s: float, speed_m_s: float, least: int) -> ProvedBound:
    """The bound for places at least apart_m (n, n) from each other; ``least`` is known already, as is 1."""
    robots, shown = travel_robots(apart_m, window_s, speed_m_s, least)
    return ProvedBound(
        robots=robots,
        reason=f"{len(shown)} places must be served within any {window_s:.6g} s, and the ways between them are too"
        f" long for {robots_in_words(robots - 1)}",
    )


def travel_robots(apart_m: Floats, window_s: float, speed_m_s: float, least: int = 1) -> tuple[int, Ints]:
    """Robots at least, and which of the places (m,) show it.

    apart_m: (n, n) metres between places that have periods of at most ``window_s``. least: what is known already; it is
    the answer, shown by no place, when nothing better can be proved.
    """
    travel_m = window_s * speed_m_s * SURELY
    robots, shown = least, np.zeros(0, dtype=np.int64)
    for share in (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5):  # of a window's travel: the least way between places kept
        kept = _thin(apart_m, share * travel_m)
        if len(kept) <= robots:
            continue
        proved = _forest_robots(apart_m[np.ix_(kept, kept)], travel_m, robots)
        if proved > robots:
            robots, shown = proved, kept
    return robots, shown


def _thin(apart_m: Floats, least_m: float) -> Ints:
    """The places (m,) in their order, less those within ``least_m`` of one kept before, or not apart from it."""
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
    step_m = 0.1 * travel_m / max(n, 1)  # how far prices move in the first step
    for ascent in range(60):  # steps of the subgradient method
        first, second, length = shortest_tree(cost + price[:, None] + price[None, :])
        sorted_m, paid = np.sort(length), 2 * float(price.sum())
        while robots < n and float(sorted_m[: n - robots].sum()) - paid > robots * travel_m:
            robots += 1
        share = (float(sorted_m[: n - robots].sum()) - paid) / (robots * travel_m)
        if share < (0.4 if ascent < 15 else 0.85):  # too short, though prices have hardly moved at first
            break
        if robots >= n or not np.isfinite(length).any():
            break
        keep = np.isfinite(length)
        keep[np.argsort(length, kind="stable")[n - robots :]] = False
        degree = np.bincount(np.concatenate([first[keep], second[keep]]), minlength=n)
        price = np.maximum(0.0, price + step_m / (1 + ascent / 10) * (degree - 2))
    return robots


def shortest_tree(length_m: Floats) -> tuple[Ints, Ints, Floats]:
    """The minimum spanning tree of a complete graph by Prim's method: ends (n - 1,) twice, and lengths (n - 1,).

    length_m: (n, n); inf where an edge is missing. The tree then has infinitely long edges.
    """
    n = len(length_m)
    away, nearest = length_m[0].copy(), np.zeros(n, dtype=np.int64)
    left = np.ones(n, dtype=bool)
    left[0] = False
    first, second, length = np.zeros(n - 1, dtype=np.int64), np.zeros(n - 1, dtype=np.int64), np.zeros(n - 1)
    for k in range(n - 1):
        rest = np.flatnonzero(left)
        v = int(rest[np.argmin(away[rest])])
        first[k], second[k], length[k] = nearest[v], v, away[v]
        left[v] = False
        closer = left & (length_m[v] < away)
        away[closer], nearest[closer] = length_m[v, closer], v
    return first, second, length

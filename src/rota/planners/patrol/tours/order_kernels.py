"""Compiled loops for a short closed tour on a distance matrix: nearest neighbour, 2-opt, or-opt."""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free, kernel


@kernel
def nearest_neighbour_tour(d: Any) -> Any:
    """Order (n,) that always goes on to the nearest place not yet visited, from place 0."""
    n = d.shape[0]
    order = np.zeros(n, dtype=np.int64)
    left = np.ones(n, dtype=np.bool_)
    left[0] = False
    for i in range(1, n):
        best, near = np.inf, -1
        for j in range(n):
            if left[j] and (near < 0 or d[order[i - 1], j] < best):
                best, near = d[order[i - 1], j], j
        order[i] = near
        left[near] = False
    return order


@kernel
def improve_once(d: Any, near: Any, least: float, order: Any) -> bool:
    """2-opt and or-opt over neighbour lists (n, k) at every place in turn; changes ``order``, or is False.

    least: the gain in metres above which an exchange counts; what rounding may feign must be less, or there is no end.
    """
    n = order.shape[0]
    place = np.empty(n, dtype=np.int64)
    for i in range(n):
        place[order[i]] = i
    shorter = False
    if n >= 4:
        for a in range(n):
            if two_opt_at(a, d, near, least, order, place) or or_opt_at(a, d, near, least, order, place):
                shorter = True
    return shorter


@allocation_free
def two_opt_at(a: int, d: Any, near: Any, least: float, order: Any, place: Any) -> bool:
    """Replace the edge after or before place a by one to a neighbour, if that gains more than ``least``."""
    n = order.shape[0]
    for way in (1, -1):
        b = order[(place[a] + way) % n]
        for m in range(near.shape[1]):
            c = near[a, m]
            gain = d[a, b] - d[a, c]
            if gain <= least:
                break
            e = order[(place[c] + way) % n]
            if gain + d[c, e] - d[b, e] > least:
                if way > 0:
                    reverse_places(place[b], place[c], order, place)
                else:
                    reverse_places(place[c], place[b], order, place)
                return True
    return False


@allocation_free
def reverse_places(first: int, last: int, order: Any, place: Any) -> None:
    """Reverse the cyclic stretch of places first..last of a tour: order (n,), and place (n,) where each of it is."""
    n = order.shape[0]
    long = last - first + 1
    if long <= 0:
        long += n
    for _ in range(long // 2):
        a, b = order[first], order[last]
        order[first], order[last] = b, a
        place[b], place[a] = first, last
        first = first + 1 if first + 1 < n else 0
        last = last - 1 if last > 0 else n - 1


@kernel
def or_opt_at(a: int, d: Any, near: Any, least: float, order: Any, place: Any) -> bool:
    """Move the one to three places that begin at a next to a neighbour of a, if that gains more than ``least``."""
    n = order.shape[0]
    for long in range(1, 4):
        if n < long + 3:
            return False
        for way in (1, -1):
            z = order[(place[a] + way * (long - 1)) % n]
            before, after = order[(place[a] - way) % n], order[(place[z] + way) % n]
            saved = d[before, a] + d[z, after] - d[before, after]
            for m in range(near.shape[1]):
                c = near[a, m]
                if saved - d[a, c] <= least:
                    break
                if (way * (place[c] - place[a])) % n < long:
                    continue  # c is in the stretch itself
                for side in (1, -1):
                    e = order[(place[c] + side) % n]
                    if (way * (place[e] - place[a])) % n < long:
                        continue
                    if saved - d[a, c] - d[z, e] + d[c, e] > least:
                        move_stretch(a, long, way, c, e, order, place)
                        return True
    return False


@kernel
def move_stretch(a: int, long: int, way: int, c: int, e: int, order: Any, place: Any) -> None:
    """Take ``long`` places from a on (in direction ``way``) and put them between c and e, a beside c."""
    n = order.shape[0]
    stretch = np.empty(long, dtype=np.int64)
    for i in range(long):
        stretch[i] = order[(place[a] + way * i) % n]
    new = np.empty(n, dtype=np.int64)
    at = (place[a] + way * long) % n
    placed = 0
    for _ in range(n - long):
        stop = order[at]
        new[placed] = stop
        placed += 1
        ahead = order[(at + way) % n]
        if stop == c and ahead == e:
            for i in range(long):
                new[placed] = stretch[i]
                placed += 1
        elif stop == e and ahead == c:
            for i in range(long - 1, -1, -1):
                new[placed] = stretch[i]
                placed += 1
        at = (at + way) % n
    if placed < n:  # c and e met where the stretch was: it stays there, turned round
        for i in range(long - 1, -1, -1):
            new[placed] = stretch[i]
            placed += 1
    for i in range(n):
        order[i] = new[i]
        place[new[i]] = i

# mypy: disable-error-code="no-any-return"
"""Compiled local search on distances: Lin-Kernighan chains of 2-opt moves, or-opt, and kicks that can be undone.

All that changes a tour is the reversal of a stretch of it, and every reversal is written down. So a chain that led to
nothing, and a kick after which the search ends worse than before, are undone by the same reversals backwards.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.tours.order_kernels import reverse_places

DEEPEST = 12  # 2-opt moves of one chain


class _Count(NamedTuple):
    """Places in ``Search.ints``."""

    REVERSALS: int = 0
    QUEUED: int = 1
    QUEUE_FIRST: int = 2


Count = _Count()


class Search(NamedTuple):
    """A tour and what may improve it. order: (n,) the waypoint at each place; place: (n,) the place of each waypoint.

    d: (n, n) distances; near: (n, k) neighbours, nearest first. queue: a ring of the waypoints yet to be tried; the
    others need no look. reversed: (room, 2) first and last place of each reversal since the last kick. touched: (2 *
    DEEPEST + 2,) the waypoints whose legs the chain at work has changed.
    """

    d: Any
    near: Any
    order: Any
    place: Any
    queue: Any
    in_queue: Any
    reversed: Any
    touched: Any
    ints: Any
    rng: NDArray[Any]


@allocation_free
def beside(waypoint: int, way: int, s: Search) -> int:
    """The waypoint after (way 1) or before (way -1) this one."""
    n = s.order.shape[0]
    at = s.place[waypoint] + way
    return s.order[0 if at == n else at if at >= 0 else n - 1]


@allocation_free
def reverse_path(u: int, v: int, s: Search) -> bool:
    """Reverse the way from u forward to v, or the rest of the tour where that is shorter; True for the rest.

    Both give the same closed tour, but the rest runs the other way round: what was before is then after.
    """
    n = s.order.shape[0]
    first, last = s.place[u], s.place[v]
    long = last - first + 1
    if long <= 0:
        long += n
    rest = 2 * long > n
    if rest:
        first, last = last + 1 if last + 1 < n else 0, first - 1 if first > 0 else n - 1
    at = s.ints[Count.REVERSALS]
    s.reversed[at, 0], s.reversed[at, 1] = first, last
    s.ints[Count.REVERSALS] = at + 1
    if long < n:
        reverse_places(first, last, s.order, s.place)
    return rest


@allocation_free
def undo_to(mark: int, s: Search) -> None:
    """Undo all reversals but the first ``mark``."""
    n = s.order.shape[0]
    for at in range(s.ints[Count.REVERSALS] - 1, mark - 1, -1):
        first, last = s.reversed[at, 0], s.reversed[at, 1]
        if (last + 1) % n != first:
            reverse_places(first, last, s.order, s.place)
    s.ints[Count.REVERSALS] = mark


@allocation_free
def swap_stretches(first: int, last: int, b0: int, b1: int, s0: int, s1: int, turned: bool, s: Search) -> None:
    """Swap the stretches b0..b1 and s0..s1 that make up first..last; ``turned`` leaves s0..s1 reversed."""
    mirrored = reverse_path(first, last, s)
    mirrored = not reverse_path(b0, b1, s) if mirrored else reverse_path(b1, b0, s)
    if turned:
        return
    if mirrored:
        reverse_path(s0, s1, s)
    else:
        reverse_path(s1, s0, s)


@allocation_free
def enqueue(waypoint: int, s: Search) -> None:
    """A waypoint whose legs have changed is worth another look."""
    if s.in_queue[waypoint]:
        return
    n = s.order.shape[0]
    s.in_queue[waypoint] = True
    s.queue[(s.ints[Count.QUEUE_FIRST] + s.ints[Count.QUEUED]) % n] = waypoint
    s.ints[Count.QUEUED] += 1


@allocation_free
def chain_of_two_opts(t1: int, way: int, eps: float, s: Search) -> float:
    """Lin-Kernighan: 2-opt moves in a row, each of which takes away the leg that the move before closed with.

    The first move takes away the leg from t1 in direction ``way``. All its neighbours are tried, after it only the most
    promising neighbour. Returns the gain, with the tour left where it was best; 0.0, with the tour as before, for no
    gain.
    """
    mark = s.ints[Count.REVERSALS]
    for start in range(s.near.shape[1]):
        toward = way
        t2 = beside(t1, toward, s)
        open_gain = s.d[t1, t2]
        if open_gain - s.d[t2, s.near[t2, start]] <= eps:
            break
        best, best_mark, best_touched = eps, mark, 0
        s.touched[0], s.touched[1] = t1, t2
        for depth in range(DEEPEST):
            x, y, most = -1, -1, -1e300
            for m in range(start if depth == 0 else 0, s.near.shape[1]):
                c = s.near[t2, m]
                kept = open_gain - s.d[t2, c]
                if kept <= eps:
                    break
                e = beside(c, -toward, s)
                if c != t1 and e != t2 and kept + s.d[c, e] > most:
                    x, y, most = c, e, kept + s.d[c, e]
                if depth == 0:
                    break
            if x < 0:
                break
            # t1 -> t2 ... y -> x becomes t1 -> y ... t2 -> x
            if reverse_path(t2, y, s) if toward > 0 else reverse_path(y, t2, s):
                toward = -toward
            open_gain = most
            t2 = y
            s.touched[2 * depth + 2], s.touched[2 * depth + 3] = x, y
            if open_gain - s.d[t1, y] > best:
                best, best_mark, best_touched = open_gain - s.d[t1, y], s.ints[Count.REVERSALS], 2 * depth + 4
        if best > eps:
            undo_to(best_mark, s)
            for k in range(best_touched):
                enqueue(s.touched[k], s)
            return best
        undo_to(mark, s)
    return 0.0


@allocation_free
def or_opt(a: int, eps: float, s: Search) -> float:
    """Move the stretch of one to three waypoints from ``a`` on next to a neighbour of a; returns the gain, or 0.0."""
    n = s.order.shape[0]
    for way in (1, -1):
        z = a
        for long in range(1, 4):
            if long > 1:
                z = beside(z, way, s)
            before, after = beside(a, -way, s), beside(z, way, s)
            saved = s.d[before, a] + s.d[z, after] - s.d[before, after]
            for m in range(s.near.shape[1]):
                c = s.near[a, m]
                if saved - s.d[a, c] <= eps:
                    break
                if (way * (s.place[c] - s.place[a])) % n < long:
                    continue  # c is in the stretch itself
                for side in (way, -way):
                    e = beside(c, side, s)
                    if (way * (s.place[e] - s.place[a])) % n < long:
                        continue
                    gain = saved - s.d[a, c] - s.d[z, e] + s.d[c, e]
                    if gain > eps:
                        move_stretch(a, z, way, c, e, side, s)
                        for waypoint in (a, z, before, after, c, e):
                            enqueue(waypoint, s)
                        return gain
    return 0.0


@allocation_free
def move_stretch(a: int, z: int, way: int, c: int, e: int, side: int, s: Search) -> None:
    """Put the stretch a..z (in direction ``way``) between c and e; e is beside c on ``side``, a comes beside c.

    The stretch and all between it and the gap change places, on the side of the tour where less lies between.
    """
    n = s.order.shape[0]
    s0, s1 = (a, z) if way > 0 else (z, a)
    near_gap, far_gap = (c, e) if side > 0 else (e, c)  # forward: near_gap, then far_gap
    # as the first stretch s0..s1 ends up between near_gap and far_gap, a must be next to c
    turned = (s0 == a) != (near_gap == c) if a != z else False
    ahead = s.place[near_gap] - s.place[s1]
    ahead = ahead + n if ahead < 0 else ahead
    back = s.place[s0] - s.place[far_gap]
    back = back + n if back < 0 else back
    if ahead <= back:
        swap_stretches(s0, near_gap, beside(s1, 1, s), near_gap, s0, s1, turned, s)
    else:
        swap_stretches(far_gap, s1, far_gap, beside(s0, -1, s), s0, s1, turned, s)


@allocation_free
def improve(eps: float, s: Search) -> float:
    """Try the queued waypoints until none is left or there is no room to write reversals down; returns the gain."""
    n = s.order.shape[0]
    room = s.reversed.shape[0] - 2 * DEEPEST - 8
    total = 0.0
    while s.ints[Count.QUEUED] > 0:
        a = s.queue[s.ints[Count.QUEUE_FIRST]]
        s.ints[Count.QUEUE_FIRST] = (s.ints[Count.QUEUE_FIRST] + 1) % n
        s.ints[Count.QUEUED] -= 1
        s.in_queue[a] = False
        while s.ints[Count.REVERSALS] < room:
            gain = chain_of_two_opts(a, 1, eps, s)
            if gain == 0.0:
                gain = chain_of_two_opts(a, -1, eps, s)
            if gain == 0.0:
                gain = or_opt(a, eps, s)
            if gain == 0.0:
                break
            total += gain
    return total


@allocation_free
def kick(longest: int, s: Search) -> float:
    """Swap neighbouring stretches of at most ``longest`` waypoints (a double bridge); returns the change of length."""
    n = s.order.shape[0]
    first = int(n * uniform(s.rng))
    first_length, second_length = 1 + int(longest * uniform(s.rng)), 1 + int(longest * uniform(s.rng))
    s0, s1 = s.order[first], s.order[(first + first_length - 1) % n]
    b0, b1 = s.order[(first + first_length) % n], s.order[(first + first_length + second_length - 1) % n]
    before, after = beside(s0, -1, s), beside(b1, 1, s)
    taken = s.d[before, s0] + s.d[s1, b0] + s.d[b1, after]
    swap_stretches(s0, b1, b0, b1, s0, s1, False, s)
    for waypoint in (before, b0, b1, s0, s1, after):
        enqueue(waypoint, s)
    return s.d[before, b0] + s.d[b1, s0] + s.d[s1, after] - taken


@allocation_free
def kicks(count: int, longest: int, eps: float, s: Search) -> float:
    """Kick and improve ``count`` times and undo whatever left the tour longer; returns the gain of all kicks."""
    total = 0.0
    for _ in range(count):
        s.ints[Count.REVERSALS] = 0
        change = kick(longest, s)
        gain = improve(eps, s) - change
        if gain < 0.0:
            undo_to(0, s)
        else:
            total += gain
    return total

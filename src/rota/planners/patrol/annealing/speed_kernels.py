"""Compiled times of tours whose robots speed up and brake: speeds at corners, of a whole ring or round a change of it.

Metres of way say little where braking takes longer than a leg: a corner's speed depends on its neighbours. A change is
weighed in a window of some vertices at either side, at whose ends speeds stay as they are.
"""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import allocation_free, noinline
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.driving.speed_kernels import BESIDE, Row, across_m_s2, weighed_m


@allocation_free
def has_speeds(t: Tours) -> bool:
    """Whether the tours' robots speed up and brake by limits, so that this module tells their lengths."""
    return bool(t.limits.shape[0] > 0)


@allocation_free
def put(i: int, x: float, y: float, t: Tours) -> int:
    """Put a place into the window; returns the number of the next."""
    t.window[Row.X, i], t.window[Row.Y, i] = x, y
    return i + 1


@allocation_free
def put_way(i: int, v: int, count: int, ahead: bool, t: Tours) -> int:
    """Put so many vertices of a ring into the window, from v on, ahead or back."""
    for _ in range(count):
        i = put(i, t.x[v], t.y[v], t)
        v = t.after[v] if ahead else t.before[v]
    return i


@allocation_free
def put_new(i: int, added: int, t: Tours) -> int:
    """Put the new places of a move into the window."""
    for j in range(added):
        i = put(i, t.new_x[j], t.new_y[j], t)
    return i


@allocation_free
def end_like(i: int, v: int, t: Tours) -> None:
    """Let an end of the window be passed as vertex v is now."""
    t.window[Row.SINE, i], t.window[Row.SPEED2, i] = t.sine[v], t.speed2[v]


@noinline
def ring_m(k: int, t: Tours) -> float:
    """What tour k costs, with its speeds and costs noted at all of its vertices."""
    v, n = t.anchor[k], t.n[k]
    put_way(0, v, n, True, t)
    total = weighed_m(n, True, t.window, t.limits)
    for i in range(n):
        note(v, i, t)
        v = t.after[v]
    return float(total)


@allocation_free
def note(v: int, i: int, t: Tours) -> None:
    """Note at vertex v what the window has of its place i, with the leg after it."""
    t.sine[v], t.speed2[v] = t.window[Row.SINE, i], t.window[Row.SPEED2, i]
    t.leg_cost[v], t.corner_cost[v] = t.window[Row.LEG, i], t.window[Row.CORNER, i]


@allocation_free
def steps(v: int, count: int, ahead: bool, t: Tours) -> int:
    """The vertex so many steps from v on, ahead or back."""
    for _ in range(count):
        v = t.after[v] if ahead else t.before[v]
    return int(v)


@allocation_free
def noted_m(first: int, last: int, t: Tours) -> float:
    """What is noted of the way from a vertex on to another, without the corners there."""
    total, v = 0.0, first
    while v != last:
        total += t.leg_cost[v]
        v = t.after[v]
        if v != last:
            total += t.corner_cost[v]
    return total


@allocation_free
def trim_of(sine: float, speed2: float, t: Tours) -> float:
    """Metres of the legs' ends at a corner from which nothing counts as seen, since it is cut there.

    So far from the corner one is as far inside of it as the way past it is.
    """
    return float(speed2 * sine / (2 * across_m_s2(sine, t.limits)))


@allocation_free
def note_trims(first: int, count: int, t: Tours) -> None:
    """Note what is cut at so many places of the window, from one on."""
    for i in range(count):
        t.trims[i] = trim_of(t.window[Row.SINE, first + i], t.window[Row.SPEED2, first + i], t)


@noinline
def change_m(p: int, q: int, removed: int, added: int, k: int, t: Tours) -> float:
    """What tour k costs more if it leads from vertex p past the new places to q, in place of the vertices between."""
    if t.n[k] - removed <= 2 * BESIDE + 2:
        i = put_new(put(0, t.x[p], t.y[p], t), added, t)
        left = t.n[k] - removed - 1
        total = weighed_m(put_way(i, q, left, True, t), True, t.window, t.limits)
        note_trims(0, min(added + 2, added + 1 + left), t)
        if left == 0:  # back to where it begins
            t.trims[added + 1] = t.trims[0]
        return float(total - t.length[k])
    b, e = steps(p, BESIDE, False, t), steps(q, BESIDE, True, t)
    n = put_way(put_new(put_way(0, b, BESIDE + 1, True, t), added, t), q, BESIDE + 1, True, t)
    total = open_m(n, b, e, t) - noted_m(b, e, t)
    note_trims(BESIDE, added + 2, t)
    return float(total)


@noinline
def crossed_m(a: int, c: int, t: Tours) -> float:
    """What the tour costs more if vertex a leads to c, the way between is reversed, and leads on to who follows c.

    What is cut at a, c, b and d, who follow them, is noted in this order.
    """
    k = t.tour[a]
    b, d = t.after[a], t.after[c]
    inner, outer = 1, 1  # vertices from b to c and from d to a
    v, u = b, d
    while v != c and inner <= BESIDE:
        v, inner = t.after[v], inner + 1
    while u != a and outer <= BESIDE:
        u, outer = t.after[u], outer + 1
    if t.n[k] <= 4 * BESIDE + 4:
        n, v = put(0, t.x[a], t.y[a], t), c
        while True:
            n = put(n, t.x[v], t.y[v], t)
            if v == b:
                break
            v = t.before[v]
        end = n - 1
        total = weighed_m(put_way(n, d, t.n[k] - n, True, t), True, t.window, t.limits)
        keep_trims(end, 0, t)
        return float(total - t.length[k])
    if inner <= BESIDE:
        first, last = steps(a, BESIDE, False, t), steps(d, BESIDE, True, t)
        n = put_way(put_way(0, first, BESIDE + 1, True, t), c, inner, False, t)
        total = open_m(put_way(n, d, BESIDE + 1, True, t), first, last, t) - noted_m(first, last, t)
        keep_trims(n - 1, BESIDE, t)
        return float(total)
    if outer <= BESIDE:
        first, last = steps(b, BESIDE, True, t), steps(c, BESIDE, False, t)
        n = put_way(put_way(0, first, BESIDE + 1, False, t), d, outer, True, t)
        total = open_m(put_way(n, c, BESIDE + 1, False, t), first, last, t) - noted_m(last, first, t)
        keep_trims(BESIDE, n - 1, t)
        return float(total)
    first, second = steps(a, BESIDE, False, t), steps(c, BESIDE, False, t)
    third, last = steps(b, BESIDE, True, t), steps(d, BESIDE, True, t)
    n = put_way(put_way(0, first, BESIDE + 1, True, t), c, BESIDE + 1, False, t)
    total = open_m(n, first, second, t) - noted_m(first, third, t) - noted_m(second, last, t)
    note_trims(BESIDE, np.int64(2), t)
    ends = t.trims[0], t.trims[1]
    n = put_way(put_way(0, third, BESIDE + 1, False, t), d, BESIDE + 1, True, t)
    total += open_m(n, third, last, t)
    keep_trims(BESIDE, BESIDE, t)
    t.trims[0], t.trims[1] = ends
    return float(total)


@allocation_free
def keep_trims(b: int, a: int, t: Tours) -> None:
    """Note what is cut at places a, a + 1 of the window, then at b, b + 1."""
    note_trims(b, np.int64(2), t)
    t.trims[2], t.trims[3] = t.trims[0], t.trims[1]
    note_trims(a, np.int64(2), t)


@allocation_free
def open_m(n: int, first: int, last: int, t: Tours) -> float:
    """What the n places of the window cost, whose ends are these vertices."""
    end_like(0, first, t)
    end_like(n - 1, last, t)
    return float(weighed_m(n, False, t.window, t.limits))


@noinline
def settle(p: int, q: int, added: int, t: Tours) -> None:
    """Note speeds and costs anew round what has changed between vertex p and q, with so many vertices between them."""
    k = t.tour[p]
    if t.n[k] <= 2 * BESIDE + 2 + added:
        t.length[k] = ring_m(k, t)
        return
    b, e = steps(p, BESIDE, False, t), steps(q, BESIDE, True, t)
    n = put_way(0, b, 2 * BESIDE + 2 + added, True, t)
    t.length[k] += open_m(n, b, e, t) - noted_m(b, e, t)
    t.leg_cost[b] = t.window[Row.LEG, 0]
    v = b
    for i in range(1, n - 1):
        v = t.after[v]
        note(v, i, t)

"""Compiled simulated annealing over all tours at once: each move is applied, weighed, then kept or undone.

Numbers that callers write as literals are passed as ``np.int64``: numba would compile a function anew for each literal.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from rota.geometry.kernels import EdgeGrid, point_in_space, segment_is_free
from rota.planners.patrol.kernels import Samples, norm
from rota.planners.patrol.tour_kernels import (
    MOST_REMOVED,
    Tours,
    count_leg,
    free_leg,
    make_leg,
    open_gap,
    splice_is_free,
    splice_length,
    tour_cost,
    tour_length,
    uniform,
)


@njit(cache=True, error_model="numpy")
def take_out(
    k: int, at: int, removed: int, new_x: Any, new_y: Any, added: int, level: int, s: Samples, t: Tours
) -> bool:
    """Replace ``removed`` vertices of tour k from ``at`` on by new ones; remembered at ``level`` for ``put_back``.

    ``at + removed`` may not pass the end. False, with nothing changed, when there is no room for a new leg's samples.
    """
    n = t.n[k]
    before = at - 1 if at > 0 else n - 1
    alone = removed == n  # only a tour of one vertex is replaced whole
    legs = removed if alone else removed + 1
    for i in range(removed):
        t.removed_x[level, i], t.removed_y[level, i] = t.x[k, at + i], t.y[k, at + i]
    for i in range(legs):
        leg = at + i if alone else (before if i == 0 else at + i - 1)
        t.removed_slot[level, i] = t.slot[k, leg]
        count_leg(t.slot[k, leg], np.int64(-1), s, t)
    open_gap(k, at, removed, added, t)
    n = t.n[k]
    for i in range(added):
        t.x[k, at + i], t.y[k, at + i] = new_x[i], new_y[i]
    before = at - 1 if at > 0 else n - 1
    made = added if alone else added + 1
    for i in range(made):
        leg = at + i if alone else (before if i == 0 else at + i - 1)
        j = leg + 1 if leg + 1 < n else 0
        slot = make_leg(t.x[k, leg], t.y[k, leg], t.x[k, j], t.y[k, j], k, s, t)
        if slot < 0:
            put_back(k, at, removed, added, level, i, s, t)
            return False
        t.slot[k, leg] = slot
    return True


@njit(cache=True, error_model="numpy")
def put_back(k: int, at: int, removed: int, added: int, level: int, made: int, s: Samples, t: Tours) -> None:
    """Undo ``take_out`` of which ``made`` new legs exist."""
    n = t.n[k]
    alone = added == n and removed == n
    before = at - 1 if at > 0 else n - 1
    for i in range(made):
        leg = at + i if alone else (before if i == 0 else at + i - 1)
        count_leg(t.slot[k, leg], np.int64(-1), s, t)
        free_leg(t.slot[k, leg], t)
    open_gap(k, at, added, removed, t)
    n = t.n[k]
    before = at - 1 if at > 0 else n - 1
    for i in range(removed):
        t.x[k, at + i], t.y[k, at + i] = t.removed_x[level, i], t.removed_y[level, i]
    for i in range(removed if alone else removed + 1):
        leg = at + i if alone else (before if i == 0 else at + i - 1)
        t.slot[k, leg] = t.removed_slot[level, i]
        count_leg(t.slot[k, leg], np.int64(1), s, t)


@njit(cache=True, error_model="numpy")
def forget(removed: int, alone: bool, level: int, t: Tours) -> None:
    """Give back the slots of the legs that ``take_out`` took away."""
    for i in range(removed if alone else removed + 1):
        free_leg(t.removed_slot[level, i], t)


@njit(cache=True, error_model="numpy")
def try_splice(
    k: int, at: int, removed: int, new_x: Any, new_y: Any, added: int, limit: float, most_m: float,
    space: EdgeGrid, s: Samples, t: Tours,
) -> bool:  # fmt: skip
    """Replace vertices of tour k if that raises the cost by at most ``limit``."""
    if t.n[k] + added - removed > t.x.shape[1]:
        return False
    alone = t.n[k] == removed
    change = 0.0 if alone else splice_length(k, at, removed, new_x, new_y, added, most_m, t)
    if change == math.inf:
        return False
    old_cost = tour_cost(k, t.length[k], t)
    # nothing gains more than all that is unseen: most hopeless moves end here, before any geometry
    if t.turn_m[k] == 0 and tour_cost(k, t.length[k] + change, t) - old_cost - t.unseen[0] > limit:
        return False
    if not splice_is_free(k, at, removed, new_x, new_y, added, space, t):
        return False
    unseen = t.unseen[0]
    level = np.int64(0)
    if not take_out(k, at, removed, new_x, new_y, added, level, s, t):
        return False
    length = tour_length(k, t) if t.turn_m[k] > 0 else t.length[k] + change
    if tour_cost(k, length, t) - old_cost + t.unseen[0] - unseen <= limit:
        forget(removed, alone, level, t)
        t.length[k] = length
        return True
    put_back(k, at, removed, added, level, added if alone else added + 1, s, t)
    t.unseen[0] = unseen
    return False


@njit(cache=True, error_model="numpy")
def try_two_opt(k: int, i: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Reverse the part of tour k after vertex i that shortens it most."""
    n = t.n[k]
    if n < 4:
        return False
    ax, ay = t.x[k, i], t.y[k, i]
    i1 = i + 1 if i + 1 < n else 0
    bx, by = t.x[k, i1], t.y[k, i1]
    ab = norm(bx - ax, by - ay)
    best, j = math.inf, -1
    for m in range(n):
        m1 = m + 1 if m + 1 < n else 0
        if m in (i, i1) or m1 == i:
            continue
        cx, cy, dx, dy = t.x[k, m], t.y[k, m], t.x[k, m1], t.y[k, m1]
        ac, bd = norm(cx - ax, cy - ay), norm(dx - bx, dy - by)
        change = ac + bd - ab - norm(dx - cx, dy - cy)
        if change < best and ac <= most_m and bd <= most_m:
            best, j = change, m
    if j < 0:
        return False
    first, last = (i, j) if i < j else (j, i)
    after = last + 1 if last + 1 < n else 0
    old_cost = tour_cost(k, t.length[k], t)
    if t.turn_m[k] == 0 and tour_cost(k, t.length[k] + best, t) - old_cost - t.unseen[0] > limit:
        return False
    x, y = t.x[k], t.y[k]
    if not segment_is_free(x[first], y[first], x[last], y[last], space):
        return False
    if not segment_is_free(x[first + 1], y[first + 1], x[after], y[after], space):
        return False
    unseen = t.unseen[0]
    old_a, old_b = t.slot[k, first], t.slot[k, last]
    count_leg(old_a, np.int64(-1), s, t)
    count_leg(old_b, np.int64(-1), s, t)
    new_a = make_leg(x[first], y[first], x[last], y[last], k, s, t)
    new_b = make_leg(x[first + 1], y[first + 1], x[after], y[after], k, s, t)
    if new_a >= 0 and new_b >= 0:
        reverse(k, first + 1, last, t)
        length = tour_length(k, t) if t.turn_m[k] > 0 else t.length[k] + best
        if tour_cost(k, length, t) - old_cost + t.unseen[0] - unseen <= limit:
            t.slot[k, first], t.slot[k, last] = new_a, new_b
            free_leg(old_a, t)
            free_leg(old_b, t)
            t.length[k] = length
            return True
        reverse(k, first + 1, last, t)
    for slot in (new_b, new_a):
        if slot >= 0:
            count_leg(slot, np.int64(-1), s, t)
            free_leg(slot, t)
    count_leg(old_a, np.int64(1), s, t)
    count_leg(old_b, np.int64(1), s, t)
    t.unseen[0] = unseen
    return False


@njit(cache=True, error_model="numpy")
def reverse(k: int, first: int, last: int, t: Tours) -> None:
    """Reverse the vertices first..last of tour k, and the slots of the legs between them."""
    i, j = first, last
    while i < j:
        t.x[k, i], t.x[k, j] = t.x[k, j], t.x[k, i]
        t.y[k, i], t.y[k, j] = t.y[k, j], t.y[k, i]
        i += 1
        j -= 1
    i, j = first, last - 1
    while i < j:
        t.slot[k, i], t.slot[k, j] = t.slot[k, j], t.slot[k, i]
        i += 1
        j -= 1


@njit(cache=True, error_model="numpy")
def cheapest_leg(
    px: float, py: float, qx: float, qy: float, tour: int, serves: int, t: Tours
) -> tuple[int, int, int, float]:
    """Tour, leg and direction (1: p first) where the way p-q adds least; tour -1 means any that serves that class."""
    best, best_k, best_i, best_way = math.inf, -1, -1, 1
    inner = norm(qx - px, qy - py)
    for k in range(t.n.shape[0]):
        if (tour >= 0 and k != tour) or t.serves[k] > serves:
            continue
        n = t.n[k]
        price = t.price[k] + (t.over_price[k] if t.length[k] > t.budget_m[k] else 0.0)
        for i in range(n):
            j = i + 1 if i + 1 < n else 0
            ax, ay, bx, by = t.x[k, i], t.y[k, i], t.x[k, j], t.y[k, j]
            ab = norm(bx - ax, by - ay)
            ahead = norm(px - ax, py - ay) + norm(qx - bx, qy - by)
            back = norm(qx - ax, qy - ay) + norm(px - bx, py - by)
            added = (min(ahead, back) + inner - ab) * price
            if added < best:
                best, best_k, best_i, best_way = added, k, i, 1 if ahead <= back else -1
    return best_k, best_i, best_way, best


@njit(cache=True, error_model="numpy")
def try_or_opt(
    k: int, at: int, m: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours, new_x: Any, new_y: Any
) -> bool:
    """Move m vertices of tour k to the place, in any tour, where they add least."""
    n = t.n[k]
    none, first, second = np.int64(0), np.int64(0), np.int64(1)
    if n <= m or at + m > n:
        return False
    out = splice_length(k, at, m, new_x, new_y, none, most_m, t)
    if out == math.inf or not splice_is_free(k, at, m, new_x, new_y, none, space, t):
        return False
    unseen, old_length = t.unseen[0], t.length[k]
    old_cost = tour_cost(k, old_length, t)
    if not take_out(k, at, m, new_x, new_y, none, first, s, t):
        return False
    t.length[k] = tour_length(k, t) if t.turn_m[k] > 0 else old_length + out
    for i in range(m):
        new_x[i], new_y[i] = t.removed_x[0, i], t.removed_y[0, i]
    to, leg, way, _ = cheapest_leg(new_x[0], new_y[0], new_x[m - 1], new_y[m - 1], np.int64(-1), np.int64(1 << 30), t)
    if way < 0:
        for i in range(m // 2):
            new_x[i], new_x[m - 1 - i] = new_x[m - 1 - i], new_x[i]
            new_y[i], new_y[m - 1 - i] = new_y[m - 1 - i], new_y[i]
    if t.n[to] + m <= t.x.shape[1]:
        into = splice_length(to, leg + 1, none, new_x, new_y, m, most_m, t)
        to_length = t.length[to]
        to_cost = tour_cost(to, to_length, t)
        fair = into < math.inf
        if fair and t.turn_m[k] == 0 and t.turn_m[to] == 0:
            added = tour_cost(to, to_length + into, t) - to_cost + tour_cost(k, t.length[k], t) - old_cost
            fair = added - unseen <= limit
        if (
            fair
            and splice_is_free(to, leg + 1, none, new_x, new_y, m, space, t)
            and take_out(to, leg + 1, none, new_x, new_y, m, second, s, t)
        ):
            length = tour_length(to, t) if t.turn_m[to] > 0 else to_length + into
            change = tour_cost(to, length, t) - to_cost + t.unseen[0] - unseen
            change += tour_cost(k, t.length[k], t) - old_cost
            if change <= limit:
                t.length[to] = length
                forget(m, none > 0, first, t)
                forget(none, none > 0, second, t)
                return True
            put_back(to, leg + 1, none, m, second, m + 1, s, t)
    put_back(k, at, m, none, first, second, s, t)
    t.unseen[0] = unseen
    t.length[k] = old_length
    return False


@njit(cache=True, error_model="numpy")
def propose_insert(space: EdgeGrid, s: Samples, t: Tours, new_x: Any, new_y: Any) -> tuple[int, int]:
    """A place from where an unseen sample may be seen, and the tour and leg to lead there; tour -1: none this time."""
    i = t.unseen_item[int(uniform(t.rng) * t.ints[1])]
    cx, cy = s.x[i], s.y[i]
    tour = np.int64(-1)
    if uniform(t.rng) < 0.3:
        tour = int(uniform(t.rng) * t.n.shape[0])
    k, leg, _, _ = cheapest_leg(cx, cy, cx, cy, tour, s.period[i], t)
    if k < 0:
        return k, leg
    reach = s.visit_m[i] if s.visit_m[i] > 0 else t.reach_m[k] - s.shrink_m[i]
    j = leg + 1 if leg + 1 < t.n[k] else 0
    ax, ay = t.x[k, leg], t.y[k, leg]
    dx, dy = t.x[k, j] - ax, t.y[k, j] - ay
    long = dx * dx + dy * dy
    at = 0.0 if long < 1e-18 else min(1.0, max(0.0, ((cx - ax) * dx + (cy - ay) * dy) / long))
    px, py = ax + at * dx - cx, ay + at * dy - cy
    far = norm(px, py)
    if far <= reach or uniform(t.rng) < 0.3:  # already near, so hidden: look from elsewhere
        angle, r = 2 * math.pi * uniform(t.rng), reach * math.sqrt(uniform(t.rng))
        qx, qy = cx + r * math.cos(angle), cy + r * math.sin(angle)
    else:
        # just near enough: a bend that goes no further uncovers least on its other side
        r = reach * (1 - 0.5 * uniform(t.rng) ** 4) / far
        qx, qy = cx + px * r, cy + py * r
    new_x[0], new_y[0] = qx, qy
    return (k if point_in_space(qx, qy, space) else -1), leg


@njit(cache=True, error_model="numpy")
def pick_tour(t: Tours) -> int:
    """A tour, in proportion to its vertices."""
    total = 0
    for k in range(t.n.shape[0]):
        total += t.n[k]
    place = int(uniform(t.rng) * total)
    for k in range(t.n.shape[0]):
        if place < t.n[k]:
            return k
        place -= t.n[k]
    return t.n.shape[0] - 1


@njit(cache=True, error_model="numpy")
def mend(tries: int, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> None:
    """Bend legs towards unseen samples, as long as each bend gains more than it costs; nothing else moves."""
    new_x, new_y = np.empty(MOST_REMOVED), np.empty(MOST_REMOVED)
    for _ in range(tries):
        if t.ints[1] == 0:
            return
        k, leg = propose_insert(space, s, t, new_x, new_y)
        if k >= 0:
            t.ints[2] += try_splice(k, leg + 1, np.int64(0), new_x, new_y, np.int64(1), -1e-9, most_m, space, s, t)


@njit(cache=True, error_model="numpy")
def anneal(
    first: int, moves: int, of: int, hot: float, cold: float, step_m: float, most_m: float,
    space: EdgeGrid, s: Samples, t: Tours,
) -> None:  # fmt: skip
    """Make moves first..first+moves of a schedule of ``of`` moves cooling geometrically from hot to cold (metres).

    step_m: spread of the longest shifts. most_m: no leg grows beyond this (a slot holds what such a leg sees).
    """
    new_x, new_y = np.empty(MOST_REMOVED), np.empty(MOST_REMOVED)
    for k in range(t.n.shape[0]):
        t.length[k] = tour_length(k, t)  # rounding of many small changes ends here
    for move in range(first, first + moves):
        heat = hot * (cold / hot) ** (move / of)
        limit = -heat * math.log(1.0 - uniform(t.rng))
        kind = uniform(t.rng)
        k = pick_tour(t)
        n = t.n[k]
        i = int(uniform(t.rng) * n)
        at, removed, added = i, np.int64(0), np.int64(1)
        if t.ints[1] > 0 and kind < 0.2:
            k, leg = propose_insert(space, s, t, new_x, new_y)
            if k < 0:
                continue
            at = leg + 1
        elif kind < 0.30:
            t.ints[2] += try_two_opt(k, i, limit, most_m, space, s, t)
            continue
        elif kind < 0.40:
            m = 1 + int(uniform(t.rng) * 3)
            t.ints[2] += try_or_opt(k, i, m, limit, most_m, space, s, t, new_x, new_y)
            continue
        elif kind < 0.56:
            if n == 1:
                continue
            removed, added = np.int64(1), np.int64(0)
        else:
            if kind < 0.92:
                spread, along = step_m * (1.0, 0.3, 0.08)[int(uniform(t.rng) * 3)], 0.0
                removed = np.int64(1)
            else:
                spread, along = 0.5 * step_m, uniform(t.rng)
                at = i + 1
            j = i + 1 if i + 1 < n else 0
            new_x[0] = t.x[k, i] + along * (t.x[k, j] - t.x[k, i]) + spread * (2 * uniform(t.rng) - 1)
            new_y[0] = t.y[k, i] + along * (t.y[k, j] - t.y[k, i]) + spread * (2 * uniform(t.rng) - 1)
            if not point_in_space(new_x[0], new_y[0], space):
                continue
        t.ints[2] += try_splice(k, at, removed, new_x, new_y, added, limit, most_m, space, s, t)

"""Compiled bookkeeping of the tours: lengths, what their legs see, how often each sample is seen, and splices.

A tour is a closed polyline; leg i runs from vertex i to vertex i + 1 (the last one back to vertex 0; the only leg of a
tour of one vertex has no length). Each leg keeps the list of the samples it sees in a slot, so that taking a leg away
needs no geometry.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rota.geometry.kernels import EdgeGrid, segment_is_free
from rota.planners.patrol.kernels import Samples, leg_sees, norm

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_REMOVED = 4  # vertices that one splice takes out at most


class Tours(NamedTuple):
    """All tours, what their legs see, and how often each sample is seen; see ``annealing/search.py``."""

    x: Floats
    y: Floats
    slot: Ints
    n: Ints
    length: Floats
    reach_m: Floats
    square: Ints
    serves: Ints
    turn_m: Floats
    price: Floats
    budget_m: Floats
    over_price: Floats
    seen: NDArray[np.int32]
    seen_n: Ints
    free_slots: Ints
    times_seen: Ints
    unseen_item: Ints
    unseen_place: Ints
    ints: Ints  # [free slots, unseen samples, accepted moves]
    unseen: Floats  # [weight of the unseen samples]
    removed_x: Floats
    removed_y: Floats
    removed_slot: Ints
    rng: NDArray[np.uint64]


@njit(cache=True, error_model="numpy")
def uniform(rng: Any) -> float:
    """One number in [0, 1) of an xorshift64* sequence: the same on every machine and thread."""
    s = rng[0]
    s ^= s >> np.uint64(12)
    s ^= s << np.uint64(25)
    s ^= s >> np.uint64(27)
    rng[0] = s
    return float((s * np.uint64(2685821657736338717)) >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@njit(cache=True, error_model="numpy")
def count_leg(slot: int, step: int, s: Samples, t: Tours) -> None:
    """Count a leg's samples once more (step 1) or once less (step -1); keep the list of the unseen."""
    count, seen, weight, item, place = t.times_seen, t.seen, s.weight, t.unseen_item, t.unseen_place
    unseen, change = t.ints[1], 0.0
    for j in range(t.seen_n[slot]):
        i = seen[slot, j]
        before = count[i]
        count[i] = before + step
        if step > 0 and before == 0:
            unseen -= 1
            item[place[i]] = item[unseen]
            place[item[unseen]] = place[i]
            change -= weight[i]
        elif step < 0 and before == 1:
            item[unseen] = i
            place[i] = unseen
            unseen += 1
            change += weight[i]
    t.ints[1] = unseen
    t.unseen[0] += change


@njit(cache=True, error_model="numpy")
def corner_m(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, turn_m: float) -> float:
    """Turning at b on the way a-b-c, as metres of travel that take the same time."""
    ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
    if turn_m == 0 or (ux == 0 and uy == 0) or (vx == 0 and vy == 0):
        return 0.0
    return turn_m * abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))


@njit(cache=True, error_model="numpy")
def tour_length(k: int, t: Tours) -> float:
    """Length of tour k in metres, turning included as the metres that take the same time."""
    n = t.n[k]
    total = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        total += norm(t.x[k, j] - t.x[k, i], t.y[k, j] - t.y[k, i])
        if t.turn_m[k] > 0 and n > 1:
            h = j + 1 if j + 1 < n else 0
            total += corner_m(t.x[k, i], t.y[k, i], t.x[k, j], t.y[k, j], t.x[k, h], t.y[k, h], t.turn_m[k])
    return total


@njit(cache=True, error_model="numpy")
def tour_cost(k: int, length: float, t: Tours) -> float:
    """Price of a tour of this length: every metre a little, metres over budget a lot."""
    return t.price[k] * length + t.over_price[k] * max(0.0, length - t.budget_m[k])


@njit(cache=True, error_model="numpy")
def make_leg(ax: float, ay: float, bx: float, by: float, k: int, s: Samples, t: Tours) -> int:
    """Slot of a new leg of tour k with what it sees, counted; -1 when slots or a slot's room run out."""
    if t.ints[0] == 0:
        return -1
    slot = t.free_slots[t.ints[0] - 1]
    found = leg_sees(ax, ay, bx, by, t.reach_m[k], t.square[k], t.serves[k], s, t.seen[slot])
    if found < 0:
        return -1
    t.ints[0] -= 1
    t.seen_n[slot] = found
    count_leg(slot, np.int64(1), s, t)
    return slot


@njit(cache=True, error_model="numpy")
def free_leg(slot: int, t: Tours) -> None:
    """Give a slot back."""
    t.free_slots[t.ints[0]] = slot
    t.ints[0] += 1


@njit(cache=True, error_model="numpy")
def set_up(s: Samples, t: Tours) -> bool:
    """Count everything from the tours' vertices; False when slots or their room run out."""
    t.times_seen[:] = 0
    t.ints[0] = t.free_slots.shape[0]
    t.ints[1] = s.x.shape[0]
    t.ints[2] = 0
    t.unseen[0] = 0.0
    for slot in range(t.free_slots.shape[0]):
        t.free_slots[slot] = slot
    for i in range(s.x.shape[0]):
        t.unseen_item[i] = i
        t.unseen_place[i] = i
        t.unseen[0] += s.weight[i]
    for k in range(t.n.shape[0]):
        for i in range(t.n[k]):
            j = (i + 1) % t.n[k]
            t.slot[k, i] = make_leg(t.x[k, i], t.y[k, i], t.x[k, j], t.y[k, j], k, s, t)
            if t.slot[k, i] < 0:
                return False
        t.length[k] = tour_length(k, t)
    return True


@njit(cache=True, error_model="numpy")
def open_gap(k: int, at: int, removed: int, added: int, t: Tours) -> None:
    """Move the tail of tour k so that ``removed`` vertices from ``at`` on become room for ``added``."""
    n = t.n[k]
    step = added - removed
    if step > 0:
        for i in range(n - 1, at + removed - 1, -1):
            t.x[k, i + step], t.y[k, i + step], t.slot[k, i + step] = t.x[k, i], t.y[k, i], t.slot[k, i]
    elif step < 0:
        for i in range(at + removed, n):
            t.x[k, i + step], t.y[k, i + step], t.slot[k, i + step] = t.x[k, i], t.y[k, i], t.slot[k, i]
    t.n[k] = n + step


@njit(cache=True, error_model="numpy")
def splice_length(k: int, at: int, removed: int, new_x: Any, new_y: Any, added: int, most_m: float, t: Tours) -> float:
    """Change of length if ``added`` vertices replaced ``removed`` ones from ``at`` on; inf when a leg were too long."""
    n = t.n[k]
    px, py = t.x[k, (at - 1) % n], t.y[k, (at - 1) % n]
    change = 0.0
    x, y = px, py
    for i in range(removed + 1):
        j = (at + i) % n
        change -= norm(t.x[k, j] - x, t.y[k, j] - y)
        x, y = t.x[k, j], t.y[k, j]
    x, y = px, py
    for i in range(added + 1):
        j = (at + removed) % n
        qx, qy = (new_x[i], new_y[i]) if i < added else (t.x[k, j], t.y[k, j])
        leg = norm(qx - x, qy - y)
        if leg > most_m:
            return math.inf
        change += leg
        x, y = qx, qy
    return change


@njit(cache=True, error_model="numpy")
def splice_is_free(
    k: int, at: int, removed: int, new_x: Any, new_y: Any, added: int, space: EdgeGrid, t: Tours
) -> bool:
    """Whether all new legs of the splice stay in the standing space."""
    n = t.n[k]
    x, y = t.x[k, (at - 1) % n], t.y[k, (at - 1) % n]
    for i in range(added + 1):
        j = (at + removed) % n
        qx, qy = (new_x[i], new_y[i]) if i < added else (t.x[k, j], t.y[k, j])
        if not segment_is_free(x, y, qx, qy, space):
            return False
        x, y = qx, qy
    return True

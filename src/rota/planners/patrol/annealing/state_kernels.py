"""Compiled bookkeeping of the tours: their vertices, what their legs see, and trials.

A tour is a ring of vertices, linked both ways. Leg v runs from vertex v to the vertex after it (the only leg of a tour
of one vertex has no length) and keeps the list of the samples it sees in a slot, so that taking a leg away needs no
geometry. Vertices lie in buckets of the plane, so that a move finds its neighbours without a walk along the tours.

A move is tried as a whole: new legs are counted first, then old ones taken away, so that few samples pass through
being unseen; only when it is kept do the rings change.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import allocation_free, noinline
from rota.model.arrays import Ints
from rota.planners.patrol.annealing.count_kernels import count_leg
from rota.planners.patrol.annealing.speed_kernels import has_speeds, ring_m, trim_of
from rota.planners.patrol.annealing.state import Count, Tours
from rota.planners.patrol.annealing.turn_kernels import corner_m
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.sight_kernels import norm

MOST_TRIED = 64  # legs that one trial makes or takes away at most


@allocation_free
def corner_at(a: int, b: int, c: int, t: Tours) -> float:
    """What is lost at vertex b on the way from vertex a to vertex c, as metres."""
    return corner_m(t.x[a], t.y[a], t.x[b], t.y[b], t.x[c], t.y[c], t.tour[b], t)


@allocation_free
def apart(a: int, b: int, t: Tours) -> float:
    """Distance of two vertices."""
    return norm(t.x[b] - t.x[a], t.y[b] - t.y[a])


@noinline
def tour_length(k: int, t: Tours) -> float:
    """Length of tour k in metres, turning included as the metres that take the same time."""
    if has_speeds(t):
        return float(ring_m(k, t))
    first = t.anchor[k]
    total, v = 0.0, first
    while True:
        total += apart(v, t.after[v], t)
        if t.costly[k] > 0 and t.n[k] > 1:
            total += corner_at(t.before[v], v, t.after[v], t)
        v = t.after[v]
        if v == first:
            return total


@noinline
def over_budget_cost(h: int, t: Tours) -> float:
    """Price of what tour h, or the hub h with its petals, is over budget: in each of its rounds and in all of them."""
    first, last = t.petals[h, 0], t.petals[h, 1]
    if first == last:
        return t.budget_penalty[h] * max(0.0, t.length[h] - t.budget_m[h])
    over, whole = 0.0, t.more[h] * t.length[h]
    for petal in range(first, last):
        round_m = t.length[h] + t.length[petal]
        over += max(0.0, round_m - t.budget_m[h])
        whole += round_m
    return t.budget_penalty[h] * (over + max(0.0, whole - t.whole_m[h]))


@allocation_free
def over_budget_costs(hubs: Ints, t: Tours) -> float:
    """The same of all these tours and hubs (n,): what Python calls, so that it needs no form of its own."""
    total = 0.0
    for h in hubs:
        total += over_budget_cost(h, t)
    return total


@allocation_free
def length_cost(k: int, change_m: float, t: Tours) -> float:
    """What it costs if tour k becomes longer by so much: every metre a little, metres over budget a lot."""
    h = t.hub[k]
    if t.petals[h, 0] == t.petals[h, 1]:
        was, budget = t.length[k], t.budget_m[k]
        over = max(0.0, was + change_m - budget) - max(0.0, was - budget)
        return t.length_weight[k] * change_m + t.budget_penalty[k] * over
    was = over_budget_cost(h, t)
    kept = t.length[k]
    t.length[k] = kept + change_m
    now = over_budget_cost(h, t)
    t.length[k] = kept
    return t.length_weight[k] * change_m + now - was


@allocation_free
def trim_at(b: int, t: Tours) -> float:
    """How much of the legs' ends at vertex b sees nothing: as the corner is, or as at a right angle."""
    return float(trim_of(t.sine[b], t.speed2[b], t) if has_speeds(t) else t.blind_m[t.tour[b]])


@noinline
def new_leg(
    ax: float, ay: float, bx: float, by: float, trims: tuple[float, float], k: int, s: Samples, t: Tours
) -> bool:
    """Count what a new leg of tour k sees; it joins the trial. False (and FULL set) when there is no room for it.

    trims: metres of its ends that see nothing.
    """
    trim_a, trim_b = trims
    left, tried = t.ints[Count.SLOTS_LEFT], t.ints[Count.TRIED_NEW]
    if left == 0 or tried == MOST_TRIED:
        t.ints[Count.FULL] = 1
        return False
    slot = t.free_slots[left - 1]
    blind = trim_a + trim_b
    if blind > 0:
        per_m = 1 / max(blind, norm(bx - ax, by - ay))
        dx, dy = per_m * (bx - ax), per_m * (by - ay)
        ax, ay, bx, by = ax + trim_a * dx, ay + trim_a * dy, bx - trim_b * dx, by - trim_b * dy
    count = leg_sees(Leg(ax, ay, bx, by, t.reach_m[k], t.square[k]), t.period_class[k], s, t.seen[slot])
    if count < 0:
        t.ints[Count.FULL] = 1
        return False
    t.ints[Count.SLOTS_LEFT] = left - 1
    t.seen_n[slot] = count
    t.tried_new[tried] = slot
    t.ints[Count.TRIED_NEW] = tried + 1
    count_leg(slot, np.int64(1), s, t)
    return True


@allocation_free
def old_leg(slot: int, s: Samples, t: Tours) -> None:
    """Take away what a leg sees; it joins the trial."""
    count_leg(slot, np.int64(-1), s, t)
    t.tried_old[t.ints[Count.TRIED_OLD]] = slot
    t.ints[Count.TRIED_OLD] += 1


@allocation_free
def begin(t: Tours) -> None:
    """Begin a trial."""
    t.ints[Count.TRIED_NEW] = 0
    t.ints[Count.TRIED_OLD] = 0


@allocation_free
def keep(t: Tours) -> None:
    """Keep the trial: the slots of the old legs are free again, those of the new ones are the caller's to place."""
    for i in range(t.ints[Count.TRIED_OLD]):
        t.free_slots[t.ints[Count.SLOTS_LEFT]] = t.tried_old[i]
        t.ints[Count.SLOTS_LEFT] += 1
    t.ints[Count.ACCEPTED] += 1


@noinline
def undo(unseen: float, s: Samples, t: Tours) -> None:
    """Undo the trial; ``unseen`` is the weight of the unseen samples before it, to the last bit."""
    for i in range(t.ints[Count.TRIED_OLD]):
        count_leg(t.tried_old[i], np.int64(1), s, t)
    for i in range(t.ints[Count.TRIED_NEW] - 1, -1, -1):
        count_leg(t.tried_new[i], np.int64(-1), s, t)
        t.free_slots[t.ints[Count.SLOTS_LEFT]] = t.tried_new[i]
        t.ints[Count.SLOTS_LEFT] += 1
    t.unseen[0] = unseen


@allocation_free
def bucket_of(x: float, y: float, t: Tours) -> int:
    """The bucket of a place; places outside the grid belong to its nearest one."""
    i = min(max(int((x - t.grid[0]) / t.grid[2]), 0), t.grid_n[0] - 1)
    j = min(max(int((y - t.grid[1]) / t.grid[2]), 0), t.grid_n[1] - 1)
    return j * t.grid_n[0] + i


@allocation_free
def enter_bucket(v: int, t: Tours) -> None:
    """Put vertex v in the bucket of its place."""
    b = bucket_of(t.x[v], t.y[v], t)
    first = t.bucket[b]
    t.bucket_after[v], t.bucket_before[v] = first, -1 - b
    if first >= 0:
        t.bucket_before[first] = v
    t.bucket[b] = v


@allocation_free
def leave_bucket(v: int, t: Tours) -> None:
    """Take vertex v out of its bucket."""
    before, after = t.bucket_before[v], t.bucket_after[v]
    if before >= 0:
        t.bucket_after[before] = after
    else:
        t.bucket[-1 - before] = after
    if after >= 0:
        t.bucket_before[after] = before


@noinline
def new_vertex(x: float, y: float, k: int, t: Tours) -> int:
    """A vertex of tour k at a place, in its bucket, not yet linked; the caller has made sure that one is left."""
    t.ints[Count.VERTICES_LEFT] -= 1
    v = t.free_vertices[t.ints[Count.VERTICES_LEFT]]
    t.x[v], t.y[v], t.tour[v] = x, y, k
    t.leg_cost[v], t.corner_cost[v] = 0.0, 0.0
    t.in_use[t.ints[Count.VERTICES]] = v
    t.place[v] = t.ints[Count.VERTICES]
    t.ints[Count.VERTICES] += 1
    t.n[k] += 1
    enter_bucket(v, t)
    return v


@noinline
def free_vertex(v: int, t: Tours) -> None:
    """Give a vertex back; the caller has unlinked it. A tour's anchor moves on before."""
    k = t.tour[v]
    leave_bucket(v, t)
    t.n[k] -= 1
    t.length[k] -= t.leg_cost[v] + t.corner_cost[v]
    t.ints[Count.VERTICES] -= 1
    end = t.in_use[t.ints[Count.VERTICES]]
    t.in_use[t.place[v]] = end
    t.place[end] = t.place[v]
    t.free_vertices[t.ints[Count.VERTICES_LEFT]] = v
    t.ints[Count.VERTICES_LEFT] += 1


@allocation_free
def set_up(x: Any, y: Any, tour: Any, s: Samples, t: Tours) -> bool:
    """Lay out the vertices (tour by tour, each in its order) and count everything; False when there is no room."""
    t.times_seen[:] = 0
    t.bucket[:] = -1
    t.unseen_in[:] = 0
    t.n[:] = 0
    t.ints[:] = 0
    t.ints[Count.SLOTS_LEFT] = t.free_slots.shape[0]
    t.ints[Count.VERTICES_LEFT] = t.x.shape[0]
    t.ints[Count.UNSEEN] = s.x.shape[0]
    t.unseen[0] = 0.0
    for slot in range(t.free_slots.shape[0]):
        t.free_slots[slot] = slot
    for v in range(t.x.shape[0]):
        t.free_vertices[v] = t.x.shape[0] - 1 - v
    for i in range(s.x.shape[0]):
        t.unseen_item[i] = i
        t.unseen_place[i] = i
        t.unseen_in[t.bucket_of_sample[i]] += 1
        t.unseen[0] += s.weight[i]
    first = np.int64(0)
    for i in range(x.shape[0]):
        v = new_vertex(x[i], y[i], tour[i], t)
        if i == 0 or tour[i] != tour[i - 1]:
            first = v
            t.anchor[tour[i]] = v
        else:
            t.before[v] = v - 1
            t.after[v - 1] = v
        t.after[v], t.before[first] = first, v
    if has_speeds(t):
        for k in range(t.n.shape[0]):
            t.length[k] = ring_m(k, t)
    for v in range(x.shape[0]):
        w = t.after[v]
        begin(t)
        ends = trim_at(v, t), trim_at(w, t)
        if not new_leg(t.x[v], t.y[v], t.x[w], t.y[w], ends, t.tour[v], s, t):
            return False
        t.slot[v] = t.tried_new[0]
    for k in range(t.n.shape[0]):
        t.length[k] = tour_length(k, t)
        h = t.hub[k]
        if h != k:  # a petal begins at the vertex of its hub that lies where its own first one does
            a, u = t.anchor[k], t.anchor[h]
            while t.x[u] != t.x[a] or t.y[u] != t.y[a]:
                u = t.after[u]
            t.meets[k] = u
    return True

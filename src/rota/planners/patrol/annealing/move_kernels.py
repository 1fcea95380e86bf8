"""Compiled moves of the annealing: each is tried as a whole, weighed, then kept or undone.

Numbers that callers write as literals are passed as ``np.int64``: numba would compile a function anew for each literal.
"""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import allocation_free, noinline
from rota.geometry.kernels import EdgeGrid, segment_is_free
from rota.planners.patrol.annealing.chain_kernels import (
    chain_is_free,
    chain_m,
    link,
    longer_m,
    new_chain,
    old_legs,
    place_legs,
    put_between,
    range_m,
    replace_vertices,
    short_ring_m,
    take_out,
)
from rota.planners.patrol.annealing.estimate_kernels import (
    gain_at_most,
    least_loss,
    note_chain,
    note_leg,
    unseen_near,
)
from rota.planners.patrol.annealing.speed_kernels import crossed_m, has_speeds, settle
from rota.planners.patrol.annealing.state import Count, Most, Tours
from rota.planners.patrol.annealing.state_kernels import (
    apart,
    begin,
    corner_at,
    keep,
    length_cost,
    new_leg,
    old_leg,
    undo,
)
from rota.planners.patrol.ground.sample_kernels import Samples


@noinline
def change_legs(
    p: int, removed: int, added: int, limit: float, most_m: float,
    space: EdgeGrid, s: Samples, t: Tours,
) -> bool:  # fmt: skip
    """Replace the ``removed`` vertices after vertex p by ``added`` new places, if that costs at most ``limit``.

    What vertices cost is counted here alone, since other moves keep their number.

    The only vertex of a tour is replaced by ``move_only``.
    """
    k = t.tour[p]
    limit -= t.most[Most.VERTEX] * (added - removed)
    if t.ints[Count.VERTICES_LEFT] < added:
        t.ints[Count.FULL] = 1
        return False
    q = p
    for _ in range(removed + 1):
        q = t.after[q]
    paced = has_speeds(t)
    # the turning of a short ring is not a sum of its parts
    short = t.n[k] + added - removed < 4 and t.costly[k] > 0 and not paced
    change_m, spare = 0.0, math.inf
    if not short:
        change_m = longer_m(p, q, removed, added, most_m, k, t)
        if change_m == math.inf:
            return False
        spare = limit - length_cost(k, change_m, t) + gain_at_most(p, q, added, t)
        if spare < 0:
            return False
    elif chain_m(p, q, added, most_m, k, t) == math.inf:
        return False
    else:
        change_m = short_ring_m(p, removed, added, k, t) - t.length[k]
    if not short:
        note_chain(np.int64(0), p, q, added, t)
        v = p
        for _ in range(removed + 1):
            spare -= least_loss(t.slot[v], added + 1, range_m(k, t), spare, s, t)
            if spare < 0:
                return False
            v = t.after[v]
    if not chain_is_free(p, q, added, space, t):
        return False
    unseen = t.unseen[0]
    begin(t)
    counted = new_chain(p, q, added, k, s, t)
    if counted:
        old_legs(p, removed + 1, s, t)
    if not counted or length_cost(k, change_m, t) + t.unseen[0] - unseen > limit:
        undo(unseen, s, t)
        return False
    keep(t)
    replace_vertices(p, q, removed, added, k, t)
    place_legs(p, np.int64(0), added + 1, t)
    if paced:
        settle(p, q, added, t)
    else:
        t.length[k] += change_m
    return True


@noinline
def try_two_opt(a: int, c: int, limit: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Reverse the way from after a to c, both of one tour, so that a-c and after a-after c are its new legs."""
    k = t.tour[a]
    b, d = t.after[a], t.after[c]
    change_m = apart(a, c, t) + apart(b, d, t) - apart(a, b, t) - apart(c, d, t)
    paced = has_speeds(t)
    if paced:
        change_m = crossed_m(a, c, t)
    elif t.costly[k] > 0:
        change_m += corner_at(t.before[a], a, c, t) + corner_at(a, c, t.before[c], t)
        change_m += corner_at(t.after[b], b, d, t) + corner_at(b, d, t.after[d], t)
        change_m -= corner_at(t.before[a], a, b, t) + corner_at(a, b, t.after[b], t)
        change_m -= corner_at(t.before[c], c, d, t) + corner_at(c, d, t.after[d], t)
    gain = unseen_near(t.x[a], t.y[a], t.x[c], t.y[c], t) + unseen_near(t.x[b], t.y[b], t.x[d], t.y[d], t)
    spare = limit - length_cost(k, change_m, t) + gain
    if spare < 0:
        return False
    note_leg(np.int64(0), t.x[a], t.y[a], t.x[c], t.y[c], t)
    note_leg(np.int64(1), t.x[b], t.y[b], t.x[d], t.y[d], t)
    spare -= least_loss(t.slot[a], np.int64(2), range_m(k, t), spare, s, t)
    if spare < 0 or spare < least_loss(t.slot[c], np.int64(2), range_m(k, t), spare, s, t):
        return False
    if not segment_is_free(t.x[a], t.y[a], t.x[c], t.y[c], space):
        return False
    if not segment_is_free(t.x[b], t.y[b], t.x[d], t.y[d], space):
        return False
    unseen = t.unseen[0]
    begin(t)
    if not paced:
        t.trims[:4] = t.blind_m[k]
    counted = new_leg(t.x[a], t.y[a], t.x[c], t.y[c], (t.trims[0], t.trims[1]), k, s, t)
    if counted := counted and new_leg(t.x[b], t.y[b], t.x[d], t.y[d], (t.trims[2], t.trims[3]), k, s, t):
        old_leg(t.slot[a], s, t)
        old_leg(t.slot[c], s, t)
    if not counted or length_cost(k, change_m, t) + t.unseen[0] - unseen > limit:
        undo(unseen, s, t)
        return False
    keep(t)
    # the shorter of the two ways is turned round: b..c, or d..a, which comes to the same ring
    inner, outer = b, d
    while inner != c and outer != a:
        inner, outer = t.after[inner], t.after[outer]
    if inner == c:
        reverse(b, c, t)
        link(a, c, t)
        link(b, d, t)
        t.slot[a], t.slot[b] = t.tried_new[0], t.tried_new[1]
    else:
        reverse(d, a, t)
        link(c, a, t)
        link(d, b, t)
        t.slot[c], t.slot[d] = t.tried_new[0], t.tried_new[1]
        a, b, c, d = c, d, a, b
    if paced:
        settle(a, c, np.int64(0), t)
        settle(b, d, np.int64(0), t)
    else:
        t.length[k] += change_m
    return True


@allocation_free
def reverse(first: int, last: int, t: Tours) -> None:
    """Turn round the way from vertex ``first`` to vertex ``last``; the caller links its ends."""
    v = first
    slot_before, cost_before = t.slot[first], t.leg_cost[last]
    while True:
        after = t.after[v]
        slot, cost = t.slot[v], t.leg_cost[v]
        t.after[v], t.before[v] = t.before[v], after
        t.slot[v], t.leg_cost[v] = slot_before, cost_before
        slot_before, cost_before = slot, cost
        if v == last:
            return
        v = after


@noinline
def try_or_opt(v: int, m: int, e: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Move the m vertices from v on between vertex e, which is none of them, and the vertex after it, in any tour."""
    k, to = t.tour[v], t.tour[e]
    p, w = t.before[v], v
    for _ in range(m - 1):
        w = t.after[w]
    q, f = t.after[w], t.after[e]
    if f == v or t.n[k] <= m or (k == to and t.n[k] < m + 3):
        return False
    if (t.costly[k] > 0 and t.n[k] < m + 4) or (t.costly[to] > 0 and (k == to or t.n[to] < 3)):
        return False  # corners of short rings depend on each other: left to the other moves
    ahead = apart(e, v, t) + apart(w, f, t)
    back = apart(e, w, t) + apart(v, f, t)
    u = v if ahead <= back else w
    for i in range(m):
        t.new_x[i], t.new_y[i] = t.x[u], t.y[u]
        u = t.after[u] if ahead <= back else t.before[u]
    out_m = longer_m(p, q, m, np.int64(0), most_m, k, t)
    ends = t.trims[0], t.trims[1]
    into_m = longer_m(e, f, np.int64(0), m, most_m, to, t)
    if out_m == math.inf or into_m == math.inf:
        return False
    gain = unseen_near(t.x[p], t.y[p], t.x[q], t.y[q], t) + gain_at_most(e, f, m, t)
    spare = limit - moved_cost(k, out_m, to, into_m, t) + gain
    if spare < 0:
        return False
    note_chain(np.int64(0), e, f, m, t)
    note_leg(m + 1, t.x[p], t.y[p], t.x[q], t.y[q], t)
    far = max(range_m(k, t), range_m(to, t))
    u = p
    for i in range(m + 2):
        spare -= least_loss(t.slot[u if i <= m else e], m + 2, far, spare, s, t)
        if spare < 0:
            return False
        u = t.after[u]
    if not (segment_is_free(t.x[p], t.y[p], t.x[q], t.y[q], space) and chain_is_free(e, f, m, space, t)):
        return False
    unseen = t.unseen[0]
    begin(t)
    if not has_speeds(t):
        ends = t.blind_m[k], t.blind_m[k]
    if counted := new_leg(t.x[p], t.y[p], t.x[q], t.y[q], ends, k, s, t) and new_chain(e, f, m, to, s, t):
        old_legs(p, m + 1, s, t)
        old_leg(t.slot[e], s, t)
    if not counted or moved_cost(k, out_m, to, into_m, t) + t.unseen[0] - unseen > limit:
        undo(unseen, s, t)
        return False
    keep(t)
    take_out(v, m, q, t)
    link(p, q, t)
    t.slot[p] = t.tried_new[0]
    put_between(e, f, m, to, t)
    place_legs(e, np.int64(1), m + 1, t)
    if has_speeds(t):
        settle(p, q, np.int64(0), t)
        settle(e, f, m, t)
    else:
        t.length[k] += out_m
        t.length[to] += into_m
    return True


@allocation_free
def moved_cost(k: int, out_m: float, to: int, into_m: float, t: Tours) -> float:
    """What it costs if tour k becomes longer by ``out_m`` (less than 0) and tour ``to`` by ``into_m``."""
    if k == to:
        return float(length_cost(k, out_m + into_m, t))
    cost: float = length_cost(k, out_m, t)
    t.length[k] += out_m
    cost += length_cost(to, into_m, t)
    t.length[k] -= out_m
    return cost

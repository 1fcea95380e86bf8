"""Compiled changes of a stretch of a tour: how long the way past new places is, what it sees, and how it is linked.

A chain is the way from vertex p past new places (none, or some) to vertex q; see ``move_kernels.py``.
"""

from __future__ import annotations

import math

from rota.compiled.kernel import allocation_free, noinline
from rota.geometry.kernels import EdgeGrid, segment_is_free
from rota.planners.patrol.annealing.speed_kernels import change_m, has_speeds
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.annealing.state_kernels import (
    apart,
    corner_at,
    enter_bucket,
    free_vertex,
    leave_bucket,
    new_leg,
    new_vertex,
    old_leg,
)
from rota.planners.patrol.annealing.turn_kernels import corner_m
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.sight_kernels import norm


@noinline
def chain_m(p: int, q: int, added: int, most_m: float, k: int, t: Tours) -> float:
    """Length of the way from vertex p past the new places to vertex q; inf when a leg of it is too long.

    With the turning at p and q, if tour k takes time to turn, and at all places between them.
    """
    costly = t.costly[k] > 0
    total = 0.0
    ax, ay = t.x[t.before[p]], t.y[t.before[p]]
    bx, by = t.x[p], t.y[p]
    for i in range(added + 1):
        cx, cy = (t.new_x[i], t.new_y[i]) if i < added else (t.x[q], t.y[q])
        leg = norm(cx - bx, cy - by)
        if leg > most_m:
            return math.inf
        total += leg
        if costly:
            total += corner_m(ax, ay, bx, by, cx, cy, k, t)
        ax, ay, bx, by = bx, by, cx, cy
    if costly:
        total += corner_m(ax, ay, bx, by, t.x[t.after[q]], t.y[t.after[q]], k, t)
    return total


@noinline
def way_m(p: int, q: int, t: Tours) -> float:
    """Length of the tour from vertex p on to vertex q, with the turning at both and in between."""
    k = t.tour[p]
    total: float = 0.0
    v = p
    while True:
        total += apart(v, t.after[v], t)
        if t.costly[k] > 0:
            total += corner_at(t.before[v], v, t.after[v], t)
        v = t.after[v]
        if v == q:
            break
    if t.costly[k] > 0:
        total += corner_at(t.before[q], q, t.after[q], t)
    return total


@noinline
def longer_m(p: int, q: int, removed: int, added: int, most_m: float, k: int, t: Tours) -> float:
    """By how much tour k grows if it leads from vertex p past the new places to q; inf when a leg is too long."""
    new_m: float = chain_m(p, q, added, most_m, k, t)
    if new_m == math.inf:
        return new_m
    if has_speeds(t):
        return float(change_m(p, q, removed, added, k, t))
    return float(new_m - way_m(p, q, t))


@noinline
def short_ring_m(p: int, removed: int, added: int, k: int, t: Tours) -> float:
    """Length, turning included, of a ring of at most three vertices after the change; see ``change_legs``."""
    x, y = t.scratch[0], t.scratch[1]
    x[0], y[0] = t.x[p], t.y[p]
    count = 1
    for i in range(added):
        x[count], y[count] = t.new_x[i], t.new_y[i]
        count += 1
    v = t.after[p]
    for _ in range(removed):
        v = t.after[v]
    while v != p and count < 8:
        x[count], y[count] = t.x[v], t.y[v]
        count += 1
        v = t.after[v]
    total = 0.0
    for i in range(count):
        a, b, c = i, (i + 1) % count, (i + 2) % count
        total += norm(x[b] - x[a], y[b] - y[a])
        if count > 1:
            total += corner_m(x[a], y[a], x[b], y[b], x[c], y[c], k, t)
    return total


@allocation_free
def range_m(k: int, t: Tours) -> float:
    """How far tour k sees, in any direction."""
    return float(t.reach_m[k] * (1.4142135623730951 if t.square[k] else 1.0))


@noinline
def chain_is_free(p: int, q: int, added: int, space: EdgeGrid, t: Tours) -> bool:
    """Whether the way from vertex p past the new places to vertex q stays in the standing space."""
    x, y = t.x[p], t.y[p]
    for i in range(added + 1):
        cx, cy = (t.new_x[i], t.new_y[i]) if i < added else (t.x[q], t.y[q])
        if not segment_is_free(x, y, cx, cy, space):
            return False
        x, y = cx, cy
    return True


@noinline
def new_chain(p: int, q: int, added: int, k: int, s: Samples, t: Tours) -> bool:
    """Count what the legs from vertex p past the new places to vertex q see, as legs of tour k."""
    x, y, paced, blind = t.x[p], t.y[p], has_speeds(t), t.blind_m[k]
    for i in range(added + 1):
        cx, cy = (t.new_x[i], t.new_y[i]) if i < added else (t.x[q], t.y[q])
        trims = (t.trims[i], t.trims[i + 1]) if paced else (blind, blind)
        if not new_leg(x, y, cx, cy, trims, k, s, t):
            return False
        x, y = cx, cy
    return True


@allocation_free
def old_legs(p: int, count: int, s: Samples, t: Tours) -> None:
    """Take away what so many legs from vertex p on see."""
    v = p
    for _ in range(count):
        old_leg(t.slot[v], s, t)
        v = t.after[v]


@allocation_free
def place_legs(p: int, first: int, count: int, t: Tours) -> None:
    """Give the legs from vertex p on the slots of the trial's new legs, beginning with number ``first``."""
    v = p
    for i in range(count):
        t.slot[v] = t.tried_new[first + i]
        v = t.after[v]


@allocation_free
def link(a: int, b: int, t: Tours) -> None:
    """Let vertex b follow vertex a."""
    t.after[a] = b
    t.before[b] = a


@noinline
def replace_vertices(p: int, q: int, removed: int, added: int, k: int, t: Tours) -> None:
    """Lead tour k from vertex p past new places to vertex q; the ``removed`` vertices between them are used again."""
    v = t.after[p]
    last = p
    for i in range(max(removed, added)):
        if i < removed and i < added:
            leave_bucket(v, t)
            t.x[v], t.y[v] = t.new_x[i], t.new_y[i]
            enter_bucket(v, t)
            last, v = v, t.after[v]
        elif i < removed:
            gone, v = v, t.after[v]
            if t.anchor[k] == gone:
                t.anchor[k] = v
            free_vertex(gone, t)
        else:
            made = new_vertex(t.new_x[i], t.new_y[i], k, t)
            link(last, made, t)
            last = made
    link(last, q, t)


@noinline
def take_out(v: int, m: int, q: int, t: Tours) -> None:
    """Give back the m vertices from v on. If one of them is its tour's anchor, vertex q after them becomes it."""
    k = t.tour[v]
    for _ in range(m):
        if t.anchor[k] == v:
            t.anchor[k] = q
        after = t.after[v]
        free_vertex(v, t)
        v = after


@noinline
def put_between(e: int, f: int, m: int, to: int, t: Tours) -> None:
    """Link new vertices of tour ``to`` at m places between vertices e and f."""
    last = e
    for i in range(m):
        made = new_vertex(t.new_x[i], t.new_y[i], to, t)
        link(last, made, t)
        last = made
    link(last, f, t)

"""Compiled moves of a petal to another vertex of its hub, from which it then begins."""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import allocation_free, noinline
from rota.geometry.kernels import EdgeGrid, segment_is_free
from rota.planners.patrol.annealing.chain_kernels import link
from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.annealing.state_kernels import (
    apart,
    begin,
    bucket_of,
    enter_bucket,
    keep,
    leave_bucket,
    length_cost,
    new_leg,
    old_leg,
    undo,
)
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.sight_kernels import norm


@noinline
def try_meeting_near(v: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Let the petal of vertex v pass its hub, there to begin, near v and at any vertex; keep it if it costs ``limit``.

    An empty petal begins anywhere.
    """
    k = t.tour[v]
    if t.n[k] == 1:
        u = t.meets[k]
        for _ in range(1 + int(uniform(t.rng) * 8)):  # an empty petal goes so many steps along its hub
            u = t.after[u]
        return bool(meets_at(k, u, v, limit, most_m, space, s, t))
    u = hub_vertex_near(v, t)
    if u < 0:
        return False
    px, py = t.x[u], t.y[u]
    before, after = t.before[v], t.after[v]
    ahead = norm(px - t.x[after], py - t.y[after]) - apart(v, after, t)
    back = norm(px - t.x[before], py - t.y[before]) - apart(before, v, t)
    return bool(meets_at(k, u, v if ahead <= back else before, limit, most_m, space, s, t))


@allocation_free
def hub_vertex_near(v: int, t: Tours) -> int:
    """Any vertex, each as likely, of the hub of petal vertex v in its own bucket or those around; -1: none is there."""
    h = t.hub[t.tour[v]]
    vertex, count = np.int64(-1), 0
    columns, rows = t.grid_n[0], t.grid_n[1]
    b = bucket_of(t.x[v], t.y[v], t)
    ci, cj = b % columns, b // columns
    for j in range(max(cj - 1, 0), min(cj + 1, rows - 1) + 1):
        for i in range(max(ci - 1, 0), min(ci + 1, columns - 1) + 1):
            u = t.bucket[j * columns + i]
            while u >= 0:
                if t.tour[u] == h:
                    count += 1
                    if uniform(t.rng) * count < 1:
                        vertex = u
                u = t.bucket_after[u]
    return int(vertex)


@noinline
def meets_at(k: int, u: int, e: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Let petal k begin at vertex u of its hub, passed on leg e of the petal, if that costs at most ``limit``.

    Petals take no time to turn, and cut no corners.
    """
    a = t.anchor[k]
    p, q = t.before[a], t.after[a]
    stays = e in (a, p)  # between the same two vertices
    if stays:
        e = p
    f = q if stays else t.after[e]
    x, y = t.x[u], t.y[u]
    to_m, on_m = norm(x - t.x[e], y - t.y[e]), norm(t.x[f] - x, t.y[f] - y)
    if p == a:
        to_m, on_m = 0.0, 0.0
    change_m = to_m + on_m - apart(p, a, t) - apart(a, q, t)
    closed_m = 0.0 if stays else apart(p, q, t)
    if not stays:
        change_m += closed_m - apart(e, f, t)
    if max(to_m, on_m, closed_m) > most_m or length_cost(k, change_m, t) - t.unseen[0] > limit:
        return False
    if p != a:
        if not segment_is_free(t.x[e], t.y[e], x, y, space) or not segment_is_free(x, y, t.x[f], t.y[f], space):
            return False
        if not stays and not segment_is_free(t.x[p], t.y[p], t.x[q], t.y[q], space):
            return False
    unseen = t.unseen[0]
    begin(t)
    if p == a:
        counted = new_leg(x, y, x, y, (0.0, 0.0), k, s, t)
    else:
        counted = new_leg(t.x[e], t.y[e], x, y, (0.0, 0.0), k, s, t)
        counted = counted and new_leg(x, y, t.x[f], t.y[f], (0.0, 0.0), k, s, t)
        counted = counted and (stays or new_leg(t.x[p], t.y[p], t.x[q], t.y[q], (0.0, 0.0), k, s, t))
    if counted:
        old_leg(t.slot[a], s, t)
        if p != a:
            old_leg(t.slot[p], s, t)
        if not stays:
            old_leg(t.slot[e], s, t)
    if not counted or length_cost(k, change_m, t) + t.unseen[0] - unseen > limit:
        undo(unseen, s, t)
        return False
    keep(t)
    leave_bucket(a, t)
    t.x[a], t.y[a] = x, y
    enter_bucket(a, t)
    t.meets[k] = u
    t.length[k] += change_m
    if p == a:
        t.slot[a] = t.tried_new[0]
        return True
    if not stays:
        link(p, q, t)
        link(e, a, t)
        link(a, f, t)
        t.slot[p] = t.tried_new[2]
    t.slot[e], t.slot[a] = t.tried_new[0], t.tried_new[1]
    return True

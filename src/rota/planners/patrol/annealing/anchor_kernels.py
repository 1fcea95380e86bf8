"""Compiled moves of the vertices where a hub and its petals meet: all that meet there go along, or none."""

from __future__ import annotations

from rota.compiled.kernel import allocation_free, noinline
from rota.geometry.kernels import EdgeGrid, segment_is_free
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.annealing.state_kernels import (
    begin,
    enter_bucket,
    keep,
    leave_bucket,
    new_leg,
    old_leg,
    over_budget_cost,
    tour_length,
    undo,
)
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.sight_kernels import norm


@allocation_free
def is_meeting_vertex(v: int, t: Tours) -> bool:
    """Whether vertex v is where a hub and petals of it meet: it moves only with all of them."""
    k = t.tour[v]
    if t.hub[k] != k:
        return bool(t.anchor[k] == v)
    meets = False
    for petal in range(t.petals[k, 0], t.petals[k, 1]):
        meets = meets or t.meets[petal] == v
    return meets


@allocation_free
def meeting_with(k: int, meets: int, t: Tours) -> int:
    """The vertex of tour k, a hub or a petal of it, that lies at vertex ``meets`` of the hub; -1: none of it does."""
    if t.hub[k] == k:
        return meets
    return int(t.anchor[k]) if t.meets[k] == meets else -1


@noinline
def new_corner(p: int, x: float, y: float, q: int, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> bool:
    """Count what a tour sees on the way from its vertex p past a new place to vertex q, if that can be driven."""
    k = t.tour[p]
    px, py, qx, qy = t.x[p], t.y[p], t.x[q], t.y[q]
    trims = (t.blind_m[k], t.blind_m[k])
    return bool(
        norm(x - px, y - py) <= most_m
        and norm(x - qx, y - qy) <= most_m
        and segment_is_free(px, py, x, y, space)
        and segment_is_free(x, y, qx, qy, space)
        and new_leg(px, py, x, y, trims, k, s, t)
        and new_leg(x, y, qx, qy, trims, k, s, t)
    )


@noinline
def move_together(
    v: int, x: float, y: float, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours
) -> bool:
    """Move the only vertex of a tour, or one where a hub and petals of it meet, if that costs at most ``limit``."""
    h = t.hub[t.tour[v]]
    meets = v if t.tour[v] == h else t.meets[t.tour[v]]
    first, last = t.petals[h, 0], t.petals[h, 1]
    was = over_budget_cost(h, t)
    unseen = t.unseen[0]
    metres = 0.0
    kept = t.x[v], t.y[v]
    begin(t)
    fair = True
    for member in range(first - 1, last):
        k = h if member < first else member
        a = meeting_with(k, meets, t)
        if a < 0:
            continue
        p, q = t.before[a], t.after[a]
        if p == a:
            fair = fair and new_leg(x, y, x, y, (0.0, 0.0), k, s, t)
        else:
            fair = fair and new_corner(p, x, y, q, most_m, space, s, t)
        if not fair:
            undo(unseen, s, t)
            return False
    for member in range(first - 1, last):
        k = h if member < first else member
        a = meeting_with(k, meets, t)
        if a < 0:
            continue
        if t.before[a] != a:
            old_leg(t.slot[t.before[a]], s, t)
        old_leg(t.slot[a], s, t)
    for member in range(first - 1, last):
        k = h if member < first else member
        a = meeting_with(k, meets, t)
        if a < 0:
            continue
        t.x[a], t.y[a] = x, y
        now_m = tour_length(k, t)
        metres += t.length_weight[k] * (now_m - t.length[k])
        t.length[k] = now_m
    keeps = metres + over_budget_cost(h, t) - was + t.unseen[0] - unseen <= limit
    if not keeps:
        undo(unseen, s, t)
    else:
        keep(t)
    put_meeting(h, meets, kept, (x, y), keeps, t)
    return bool(keeps)


@noinline
def put_meeting(
    h: int, meets: int, kept: tuple[float, float], moved: tuple[float, float], keeps: bool, t: Tours
) -> None:
    """End the trial of ``move_together``: all that meet at vertex ``meets`` of hub h, with their legs, stay or go.

    kept, moved: where they were, and where they are tried.
    """
    first, last = t.petals[h, 0], t.petals[h, 1]
    made = 0
    for member in range(first - 1, last):
        k = h if member < first else member
        a = meeting_with(k, meets, t)
        if a < 0:
            continue
        leave_bucket(a, t)
        t.x[a], t.y[a] = moved if keeps else kept
        enter_bucket(a, t)
        if not keeps:
            t.length[k] = tour_length(k, t)
            continue
        if t.before[a] != a:
            t.slot[t.before[a]] = t.tried_new[made]
            made += 1
        t.slot[a] = t.tried_new[made]
        made += 1

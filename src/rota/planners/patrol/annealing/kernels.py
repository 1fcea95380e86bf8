"""Compiled simulated annealing over all tours at once: which moves are tried, where, and when they are kept.

Neighbours come from buckets of the plane, so that a move costs the same however long the tours are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, noinline
from rota.geometry.kernels import EdgeGrid, point_in_space
from rota.planners.patrol.annealing.anchor_kernels import is_meeting_vertex, move_together
from rota.planners.patrol.annealing.meeting_kernels import try_meeting_near
from rota.planners.patrol.annealing.move_kernels import change_legs, try_or_opt, try_two_opt
from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.annealing.state import Count, Most, Tours
from rota.planners.patrol.annealing.state_kernels import apart, tour_length
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.sight_kernels import norm


class Schedule(NamedTuple):
    """Heat in metres, falling geometrically from ``hot_m`` to ``cold_m`` over so many moves.

    vertex_price: what a vertex more costs, as a multiple of the heat: long legs move more of a lane at a time.
    """

    moves: int
    hot_m: float
    cold_m: float
    vertex_price: float


@allocation_free
def cost_of_detour(v: int, px: float, py: float, qx: float, qy: float, t: Tours) -> float:
    """What it costs to lead leg v by the way p-q (either way round), the way itself not counted."""
    k, w = t.tour[v], t.after[v]
    ax, ay, bx, by = t.x[v], t.y[v], t.x[w], t.y[w]
    ahead = norm(px - ax, py - ay) + norm(qx - bx, qy - by)
    back = norm(qx - ax, qy - ay) + norm(px - bx, py - by)
    price = t.length_weight[k] + (t.budget_penalty[k] if t.length[k] > t.budget_m[k] else 0.0)
    return (min(ahead, back) - norm(bx - ax, by - ay)) * price


@noinline
def near_leg(px: float, py: float, qx: float, qy: float, tour: int, period_class: int, t: Tours) -> int:
    """The leg, of those that begin or end near p, where the way p-q adds least; -1 when there is none near.

    tour: -1 means any that serves that period class.
    """
    best, leg = math.inf, -1
    columns, rows = t.grid_n[0], t.grid_n[1]
    ci = min(max(int((px - t.grid[0]) / t.grid[2]), 0), columns - 1)
    cj = min(max(int((py - t.grid[1]) / t.grid[2]), 0), rows - 1)
    most = last = 8  # rings of buckets
    ring = 0
    while ring <= last:
        for j in range(max(cj - ring, 0), min(cj + ring, rows - 1) + 1):
            step = 1 if abs(j - cj) == ring or ring == 0 else 2 * ring
            for i in range(ci - ring, ci + ring + 1, step):
                if i < 0 or i >= columns:
                    continue
                v = t.bucket[j * columns + i]
                while v >= 0:
                    k = t.tour[v]
                    if (tour < 0 or k == tour) and t.period_class[k] <= period_class:
                        cost = cost_of_detour(v, px, py, qx, qy, t)
                        if cost < best:
                            best, leg = cost, v
                        cost = cost_of_detour(t.before[v], px, py, qx, qy, t)
                        if cost < best:
                            best, leg = cost, t.before[v]
                    v = t.bucket_after[v]
        if leg >= 0 and last == most:
            last = min(ring + 2, most)  # a leg that passes nearer may begin farther away
        ring += 1
    return leg


@noinline
def crossing_leg(a: int, t: Tours, most_m: float) -> int:
    """The vertex c near a, of its tour, for which legs a-c and after a-after c shorten it most; -1: none is near."""
    k, b = t.tour[a], t.after[a]
    if t.n[k] < 4:
        return -1
    best, leg = math.inf, -1
    columns, rows = t.grid_n[0], t.grid_n[1]
    ci = min(max(int((t.x[a] - t.grid[0]) / t.grid[2]), 0), columns - 1)
    cj = min(max(int((t.y[a] - t.grid[1]) / t.grid[2]), 0), rows - 1)
    ab = apart(a, b, t)
    for j in range(max(cj - 2, 0), min(cj + 2, rows - 1) + 1):
        for i in range(max(ci - 2, 0), min(ci + 2, columns - 1) + 1):
            c = t.bucket[j * columns + i]
            while c >= 0:
                d = t.after[c]
                if t.tour[c] == k and c != a and c != b and d != a:
                    ac, bd = apart(a, c, t), apart(b, d, t)
                    change = ac + bd - ab - apart(c, d, t)
                    if change < best and ac <= most_m and bd <= most_m:
                        best, leg = change, c
                c = t.bucket_after[c]
    return leg


@noinline
def propose_insert(space: EdgeGrid, s: Samples, t: Tours) -> int:
    """A place from where an unseen sample may be seen; returns the leg to lead there, or -1: none this time."""
    i = t.unseen_item[int(uniform(t.rng) * t.ints[Count.UNSEEN])]
    cx, cy = s.x[i], s.y[i]
    tour = np.int64(-1)
    if uniform(t.rng) < 0.3:
        tour = int(uniform(t.rng) * t.n.shape[0])
    a = near_leg(cx, cy, cx, cy, tour, s.period[i], t)
    if a < 0:
        return -1
    k = t.tour[a]
    reach = s.visit_m[i] if s.visit_m[i] > 0 else t.reach_m[k] - s.shrink_m[i]
    ax, ay = t.x[a], t.y[a]
    dx, dy = t.x[t.after[a]] - ax, t.y[t.after[a]] - ay
    long = dx * dx + dy * dy
    at = 0.0 if long < 1e-18 else min(1.0, max(0.0, ((cx - ax) * dx + (cy - ay) * dy) / long))
    px, py = ax + at * dx - cx, ay + at * dy - cy
    far = norm(px, py)
    if far <= reach or uniform(t.rng) < 0.3:  # already near, so hidden: look from elsewhere
        angle, r = 2 * math.pi * uniform(t.rng), reach * math.sqrt(uniform(t.rng))
        t.new_x[0], t.new_y[0] = cx + r * math.cos(angle), cy + r * math.sin(angle)
    else:
        # just near enough: a bend that goes no further uncovers least on its other side
        r = reach * (1 - 0.5 * uniform(t.rng) ** 4) / far
        t.new_x[0], t.new_y[0] = cx + px * r, cy + py * r
    return a if point_in_space(t.new_x[0], t.new_y[0], space) else -1


@noinline
def see_more(tries: int, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> int:
    """Bend legs towards unseen samples, as long as each bend gains more than it costs; nothing else moves.

    Returns the number of tries made: fewer when all is seen, or FULL is set.
    """
    for tried in range(tries):
        if t.ints[Count.UNSEEN] == 0 or t.ints[Count.FULL] > 0:
            return tried
        a = propose_insert(space, s, t)
        if a >= 0:
            change_legs(a, np.int64(0), np.int64(1), -1e-9, most_m, space, s, t)
    return tries


@noinline
def try_moving_stretch(v: int, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> None:
    """Move one to three vertices from v on to where they add least, in any tour."""
    m = 1 + int(uniform(t.rng) * 3)
    k = t.tour[v]
    if t.n[k] <= m:
        return
    w = v
    for i in range(m):
        if i > 0:
            w = t.after[w]
        if is_meeting_vertex(w, t):
            return
    # its own legs, which would always be the cheapest, stand aside for the search
    length_inside = norm(t.x[w] - t.x[v], t.y[w] - t.y[v])
    leg = leg_elsewhere(v, w, t)
    if leg >= 0 and length_inside <= most_m:
        try_or_opt(v, m, leg, limit, most_m, space, s, t)


@noinline
def leg_elsewhere(v: int, w: int, t: Tours) -> int:
    """The leg near vertex v where the way v..w adds least, none of its own and neither the one before nor after it."""
    best, leg = math.inf, -1
    columns, rows = t.grid_n[0], t.grid_n[1]
    ci = min(max(int((t.x[v] - t.grid[0]) / t.grid[2]), 0), columns - 1)
    cj = min(max(int((t.y[v] - t.grid[1]) / t.grid[2]), 0), rows - 1)
    for j in range(max(cj - 2, 0), min(cj + 2, rows - 1) + 1):
        for i in range(max(ci - 2, 0), min(ci + 2, columns - 1) + 1):
            u = t.bucket[j * columns + i]
            while u >= 0:
                for which in range(2):
                    e = u if which == 0 else t.before[u]
                    own = e == t.before[v]
                    inside = v
                    while not own:
                        own = e == inside
                        if inside == w:
                            break
                        inside = t.after[inside]
                    if not own:
                        cost = cost_of_detour(e, t.x[v], t.y[v], t.x[w], t.y[w], t)
                        if cost < best:
                            best, leg = cost, e
                u = t.bucket_after[u]
    return leg


@noinline
def shift(v: int, spread: float, limit: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> None:
    """Move vertex v by up to ``spread`` in both directions."""
    t.new_x[0] = t.x[v] + spread * (2 * uniform(t.rng) - 1)
    t.new_y[0] = t.y[v] + spread * (2 * uniform(t.rng) - 1)
    if not point_in_space(t.new_x[0], t.new_y[0], space):
        return
    if t.after[v] == v or is_meeting_vertex(v, t):
        move_together(v, t.new_x[0], t.new_y[0], limit, most_m, space, s, t)
    else:
        change_legs(t.before[v], np.int64(1), np.int64(1), limit, most_m, space, s, t)


@noinline
def one_move(limit: float, step_m: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours) -> None:
    """Try one move of a random kind at a random place; keep it if it costs at most ``limit``."""
    none, one = np.int64(0), np.int64(1)
    kind = uniform(t.rng)
    v = t.in_use[int(uniform(t.rng) * t.ints[Count.VERTICES])]
    if t.ints[Count.UNSEEN] > 0 and kind < 0.2:
        a = propose_insert(space, s, t)
        if a >= 0:
            change_legs(a, none, one, limit, most_m, space, s, t)
    elif kind < 0.30:
        h = t.hub[t.tour[v]]
        # of petals that may begin anywhere on their hub, half change where they do
        if t.more[h] > 0 and h != t.tour[v] and uniform(t.rng) < 0.5:
            try_meeting_near(v, limit, most_m, space, s, t)
            return
        c = crossing_leg(v, t, most_m)
        if c >= 0:
            try_two_opt(v, c, limit, space, s, t)
    elif kind < 0.40:
        try_moving_stretch(v, limit, most_m, space, s, t)
    elif kind < 0.56:
        if t.after[v] != v and not is_meeting_vertex(v, t):
            change_legs(t.before[v], one, none, limit, most_m, space, s, t)
    elif kind < 0.92:
        spread = step_m * (1.0, 0.3, 0.08)[int(uniform(t.rng) * 3)]
        shift(v, spread, limit, most_m, space, s, t)
    else:
        along, spread, w = uniform(t.rng), 0.5 * step_m, t.after[v]
        t.new_x[0] = t.x[v] + along * (t.x[w] - t.x[v]) + spread * (2 * uniform(t.rng) - 1)
        t.new_y[0] = t.y[v] + along * (t.y[w] - t.y[v]) + spread * (2 * uniform(t.rng) - 1)
        if point_in_space(t.new_x[0], t.new_y[0], space):
            change_legs(v, none, one, limit, most_m, space, s, t)


@allocation_free
def anneal(
    first: int, count: int, schedule: Schedule, step_m: float, most_m: float, space: EdgeGrid, s: Samples, t: Tours
) -> int:
    """Make ``count`` moves of the schedule, from move ``first`` on.

    step_m: spread of the longest shifts, in metres. most_m: no leg grows beyond this. Returns the number of moves made:
    fewer when a move found no room, and FULL is set.
    """
    for k in range(t.n.shape[0]):
        t.length[k] = tour_length(k, t)  # rounding of many small changes ends here
    t.unseen[0] = 0.0
    for i in range(t.ints[Count.UNSEEN]):
        t.unseen[0] += s.weight[t.unseen_item[i]]
    for move in range(first, first + count):
        if t.ints[Count.FULL] > 0:
            return move - first
        heat = schedule.hot_m * (schedule.cold_m / schedule.hot_m) ** (move / schedule.moves)
        limit = -heat * math.log(1.0 - uniform(t.rng))
        t.most[Most.VERTEX] = schedule.vertex_price * heat
        one_move(limit, step_m, most_m, space, s, t)
    t.most[Most.VERTEX] = 0.0
    return count

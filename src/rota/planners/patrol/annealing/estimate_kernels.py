"""Compiled estimates of what a move can gain at most and loses at least, before any geometry; most end with these."""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import allocation_free, always_inline, noinline
from rota.planners.patrol.annealing.count_kernels import Word, bits_seen_once, lowest
from rota.planners.patrol.annealing.state import Most, Tours
from rota.planners.patrol.annealing.state_kernels import bucket_of
from rota.planners.patrol.ground.sample_kernels import Index, Samples
from rota.planners.patrol.tolerances import SAME_PLACE_M


@noinline
def unseen_near(ax: float, ay: float, bx: float, by: float, t: Tours) -> float:
    """No less than the weight of the unseen samples that legs can see that stay in the box with corners a and b."""
    far = t.most[Most.RANGE]
    low = bucket_of(min(ax, bx) - far, min(ay, by) - far, t)
    high = bucket_of(max(ax, bx) + far, max(ay, by) + far, t)
    columns = t.grid_n[0]
    wide = high % columns - low % columns
    unseen = 0
    for first in range(low, high - wide + 1, columns):
        for b in range(first, first + wide + 1):
            unseen += t.unseen_in[b]
    # a little more, since the weight of all is a sum of many changes
    return float(min(t.unseen[0], unseen * t.most[Most.WEIGHT])) + SAME_PLACE_M


@noinline
def gain_at_most(p: int, q: int, added: int, t: Tours) -> float:
    """What the way from vertex p past the new places to vertex q may gain: no more than is unseen near it.

    Most moves that cannot pay end with this, before any geometry.
    """
    x0, x1 = min(t.x[p], t.x[q]), max(t.x[p], t.x[q])
    y0, y1 = min(t.y[p], t.y[q]), max(t.y[p], t.y[q])
    for i in range(added):
        x0, x1 = min(x0, t.new_x[i]), max(x1, t.new_x[i])
        y0, y1 = min(y0, t.new_y[i]), max(y1, t.new_y[i])
    return float(unseen_near(x0, y0, x1, y1, t))


@allocation_free
def note_leg(number: int, ax: float, ay: float, bx: float, by: float, t: Tours) -> None:
    """Note a leg that a move would make, for ``least_loss``."""
    leg = t.new_legs[number]
    dx, dy = bx - ax, by - ay
    aa = dx * dx + dy * dy
    leg[0], leg[1], leg[2], leg[3] = ax, ay, dx, dy
    leg[4] = 1 / aa if aa > 0 else 0.0


@noinline
def note_chain(number: int, p: int, q: int, added: int, t: Tours) -> None:
    """Note the legs from vertex p past the new places to vertex q, the first with this number."""
    x, y = t.x[p], t.y[p]
    for i in range(added + 1):
        cx, cy = (t.new_x[i], t.new_y[i]) if i < added else (t.x[q], t.y[q])
        note_leg(number + i, x, y, cx, cy, t)
        x, y = cx, cy


@noinline
def least_loss(slot: int, legs: int, reach: float, most: float, s: Samples, t: Tours) -> float:
    """Weight of samples that only the leg with this slot sees, and that none of the first noted legs reaches.

    Without a look at walls, which may hide more; nor is more counted than it takes to exceed ``most``.
    """
    runs, digits = t.seen[slot], t.times_seen
    lost: float = 0.0
    for j in range(Index(0), Index(t.seen_n[slot]), Index(2)):
        first, end = Index(runs[j]), Index(runs[j + Index(1)])
        for word in range(first >> Word.DIGITS, ((end - Index(1)) >> Word.DIGITS) + Index(1)):
            once = bits_seen_once(first, end, word, digits)
            while once != Word.NONE:
                i = np.int64((word << Word.DIGITS) + lowest(once))
                once &= once - Index(1)
                if not is_in_reach_of_any(i, legs, reach, s, t):
                    lost += s.weight[i]
                    if lost > most:
                        return lost
    return lost


@always_inline
def is_in_reach_of_any(i: int, legs: int, reach: float, s: Samples, t: Tours) -> bool:
    """Whether sample i is in range of any of the first noted legs."""
    x, y = s.x[i], s.y[i]
    far = s.visit_m[i] if s.visit_m[i] > 0 else reach - s.shrink_m[i]
    far2 = far * far * (1 + SAME_PLACE_M) + SAME_PLACE_M
    for k in range(legs):
        leg = t.new_legs[k]
        px, py = x - leg[0], y - leg[1]
        along = min(1.0, max(0.0, (px * leg[2] + py * leg[3]) * leg[4]))
        px, py = px - along * leg[2], py - along * leg[3]
        if px * px + py * py <= far2:
            return True
    return False

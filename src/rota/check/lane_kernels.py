# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False
"""The compiled loop that follows a robot from leg to leg along lanes."""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import kernel


@kernel
def first_jumps(first, piece, begins_at, ends_at, order):
    """Whether (m,) at each of the legs in ``order`` (m,) no lane leads on from the leg before.

    first: (n + 1,) where each leg's pieces begin in ``piece`` (c,), the pieces of lanes along which the leg can be
    driven. begins_at, ends_at: (c,) the corner of the piece at which the leg begins and ends; -1 elsewhere. A robot
    goes on along the same piece, or from a corner that both pieces have. After a jump any piece will do.
    """
    jumps = np.zeros(order.shape[0], np.bool_)
    reached = np.zeros(piece.shape[0], np.bool_)
    for k in range(order.shape[0]):
        leg = order[k]
        leads = k == 0
        if k > 0:
            before = order[k - 1]
            for c in range(first[leg], first[leg + 1]):
                on = False
                for b in range(first[before], first[before + 1]):
                    same = piece[b] == piece[c]
                    joint = ends_at[b] >= 0 and ends_at[b] == begins_at[c]
                    if reached[b] and (same or joint):
                        on = True
                if before != leg:
                    reached[c] = on
                leads = leads or on
        if k == 0 or not leads:
            jumps[k] = not leads
            for c in range(first[leg], first[leg + 1]):
                reached[c] = True
    return jumps

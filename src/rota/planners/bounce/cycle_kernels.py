# mypy: disable-error-code="no-any-return"
"""Compiled loops over periodic states: pairs of limit cycles without contact, and teams that settle on them."""

from __future__ import annotations

from math import gcd
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Flags
from rota.planners.bounce.arrays import Floats, Ints, Longs
from rota.planners.bounce.kernels import Team, pair_touches, step_team


class SettlingRoom(NamedTuple):
    """Room to write to while robots come to their cycles.

    after, stays: (m,) scratch of a step. log: (steps, m) states from the start to the cycles; it bounds the steps that
    are tried.
    """

    after: Ints
    stays: NDArray[np.int8]
    log: Ints


@allocation_free
def compare_cycles(
    team: Team, apart2: Floats, kind: Ints, state: Ints, start: Longs, length: Longs, bad: Flags, compatible: Flags
) -> None:
    """Fill compatible[p, q]: whether robots in periodic states p and q never come in contact.

    apart2: (kinds, kinds) as in Team. start, length: (c,) of the cycles. bad: scratch as long as the longest cycle.
    """
    for a in range(len(start)):
        for b in range(a, len(start)):
            i0, j0, n, m = start[a], start[b], length[a], length[b]
            g = gcd(n, m)
            near2 = apart2[kind[i0], kind[j0]]
            for d in range(g):
                bad[d] = False
            for i in range(n):
                for j in range(m):
                    d = (j - i) % g
                    if not bad[d] and pair_touches(team, state[i0 + i], state[j0 + j], near2):
                        bad[d] = True
            for i in range(n):
                for j in range(m):
                    good = not bad[(j - i) % g]
                    compatible[i0 + i, j0 + j] = good
                    compatible[j0 + j, i0 + i] = good


@allocation_free
def steps_to_cycles(
    team: Team, kinds: Ints, node_of: Ints, compatible: Flags, states: Ints, room: SettlingRoom, free: bool
) -> int:
    """Steps until m robots, from ``states``, are on limit cycles that they follow without contact; -1: never.

    states: (m,), overwritten. kinds: (m,) of the robots. node_of: (kinds, s) number of each periodic state, -1 of
    others. compatible: (p, p) whether robots in two periodic states never come in contact. free: a contact on the way
    ends the search.
    """
    after, stays, log = room
    m = len(states)
    for t in range(len(log)):
        for i in range(m):
            log[t, i] = states[i]
        settled = True
        for i in range(m):
            p = node_of[kinds[i], states[i]]
            if p < 0:
                settled = False
                break
            for j in range(i):
                if not compatible[p, node_of[kinds[j], states[j]]]:
                    settled = False
                    break
        if settled:
            return t
        if step_team(team, states, stays, after) > 0 and free:
            return -1
        for i in range(m):
            states[i] = after[i]
    return -1

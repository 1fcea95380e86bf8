# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop of random walks on a Markov chain until all cells were entered."""

from __future__ import annotations

import numpy as np
from numba import njit

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_SHIFT_1, _SHIFT_2, _SHIFT_3, _SHIFT_DOUBLE = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@njit(cache=True, nogil=True)
def _uniform(state):
    """The next number of splitmix64 in 0..1, and the state after it."""
    state = state + _GOLDEN
    z = (state ^ (state >> _SHIFT_1)) * _MIX_1
    z = (z ^ (z >> _SHIFT_2)) * _MIX_2
    return float((z ^ (z >> _SHIFT_3)) >> _SHIFT_DOUBLE) * 2.0**-53, state


@njit(cache=True, nogil=True)
def walk_until_covered(row_start, column, cumulated, headings, starts, seeds, most_steps, seen_at, cover_steps):
    """Fill seen_at (n,) with how many walks entered each cell within each of its steps, and cover_steps (r,).

    row_start, column: the chain's rows; cumulated: the chances in each row, added up. Walk number w begins in state
    starts[w]. seen_at (most_steps + 1, n) counts walks that had entered a cell after so many steps or fewer;
    cover_steps[w]: steps after which the walk has entered all cells, -1 where it has not.
    """
    cells = seen_at.shape[1]
    seen = np.empty(cells, np.bool_)
    for w in range(len(starts)):
        seen[:] = False
        state, random, left = starts[w], seeds[w], cells
        cover_steps[w] = -1
        for step in range(most_steps + 1):
            if step > 0:
                u, random = _uniform(random)
                k = row_start[state]
                while k < row_start[state + 1] - 1 and u >= cumulated[k]:
                    k += 1
                state = column[k]
            cell = state // headings
            if not seen[cell]:
                seen[cell] = True
                left -= 1
                seen_at[step, cell] += 1
                if left == 0:
                    cover_steps[w] = step
                    break
    for step in range(1, most_steps + 1):
        for cell in range(cells):
            seen_at[step, cell] += seen_at[step - 1, cell]

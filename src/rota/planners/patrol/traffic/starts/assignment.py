"""Who takes which loop: the latest arrival as early as it can be, or so that as few approaches as possible cross."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from rota.model.arrays import Floats, Ints


def earliest_assignment(times_s: Floats) -> Ints | None:
    """For each loop (n,) the start that serves it; None when no assignment serves all.

    times_s: (m, n) seconds from start to loop, inf where no path leads. No assignment has an earlier latest arrival;
    of those that have it, none has a lesser sum of squares, which keeps equal robots from overtaking each other.
    """
    limit_s = bottleneck_s(times_s)
    if limit_s is None:
        return None
    return least_squares(np.where(times_s <= limit_s, times_s, np.inf))


def least_squares(costs: Floats) -> Ints:
    """For each loop (n,) the start that serves it, with the least sum of squared costs (m, n); inf is not allowed.

    Of lengths it gives approaches that cross little. In a corridor nobody overtakes or meets anybody; on open ground
    bodies far enough apart never touch when all go at once (Turpin, Michael and Kumar, "CAPT: Concurrent assignment and
    planning of trajectories for multiple robots", 2014). Raises ValueError when no assignment serves all loops.
    """
    start_of_loop = np.full(costs.shape[1], -1, dtype=np.int64)
    starts, loops = least_sum(np.square(costs))
    start_of_loop[loops] = starts
    return start_of_loop


def least_sum(costs: Floats) -> tuple[Ints, Ints]:
    """Rows and columns (k,), in pairs, of the assignment whose costs (m, n) have the least sum; k is min(m, n).

    Raises ValueError when every such assignment has a pair that costs inf.
    """
    from scipy.optimize import linear_sum_assignment  # a tenth of a second, which most plans do without

    rows, columns = linear_sum_assignment(costs)
    return rows, columns


def bottleneck_s(times_s: Floats) -> float | None:
    """The least latest arrival of any assignment that serves all loops; None when there is no assignment."""
    values = np.unique(times_s[np.isfinite(times_s)])
    if len(largest_matching(times_s, np.inf)) < times_s.shape[1] or not len(values):
        return None
    low, high = 0, len(values) - 1
    while low < high:
        middle = (low + high) // 2
        if len(largest_matching(times_s, float(values[middle]))) == times_s.shape[1]:
            high = middle
        else:
            low = middle + 1
    return float(values[low])


def largest_matching(times_s: Floats, limit_s: float) -> Ints:
    """The loops of a largest matching that uses no distance longer than the limit."""
    graph = csr_array((np.isfinite(times_s) & (times_s <= limit_s)).astype(np.int8))
    return np.flatnonzero(maximum_bipartite_matching(graph, perm_type="row") >= 0)

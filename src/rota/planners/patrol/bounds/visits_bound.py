"""Robots at least, since each of several places takes a share of some robot's time, and one alone may be late for ever.

Shares. Let each of n places be served once in every window of its period T_i, and let it take a robot d_ij seconds
at least from serving i to serving j. Choose times 0 <= z_i <= T_i / 2 with z_i + z_j <= d_ij for all pairs. The team
has at least the sum of 2 z_i / T_i robots.

Proof. Call a robot near i at each time that is within z_i of one at which it serves i. A robot that is near i and near
j at once serves them at most z_i + z_j apart, so that it is near two at single moments only. Some robot serves i in
every window of T_i, so that some robot is near i for a share of 2 z_i / T_i of the time, at least. The z of the
greatest sum are those of a linear program; whatever they are, the sum is a bound. Its dual program counts how often
each way between two places is driven: this is the density of pinwheel scheduling (R. Holte et al., "The Pinwheel: A
Real-Time Scheduling Problem", 1989), with travel for the work that each visit takes.

Alone. Where ``is_hopeless`` proves of some of the places that no robot can serve them for ever, the team has at least
two. A robot serves places in some order, and takes d_ij between two that follow each other, whatever it does meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.witness_points import MOST_SPREAD_OUT
from rota.planners.patrol.cycles.one_robot import is_hopeless
from rota.planners.patrol.cycles.teams import MOST_TOGETHER
from rota.planners.patrol.tolerances import SURELY


def visits_bound(apart_m: Floats, period_s: Floats, speed_m_s: float, least: int) -> Iterator[ProvedBound]:
    """The proofs for places (n) at least apart_m (n, n) from each other, periods period_s (n,); ``least`` is known."""
    if len(period_s) < 2:
        return
    some = np.argsort(period_s, kind="stable")[:MOST_SPREAD_OUT]
    apart_s, period_s = apart_m[np.ix_(some, some)] / speed_m_s, period_s[some]
    near_s = times_near(apart_s, period_s)
    share = 2 * near_s / period_s
    robots = max(1, math.ceil(float(share.sum()) / SURELY))
    yield ProvedBound(
        robots=robots,
        reason=f"to come to {int((near_s > 0).sum())} places, each within its period, takes the time of"
        f" {float(share.sum()):.3g} robots on the ways there and back",
    )
    if max(robots, least) > 1:
        return
    # places less than a hundredth of the shortest period apart are not asked about together
    few = far_from_each_other(np.argsort(-share, kind="stable"), apart_s, 0.01 * float(period_s.min()))
    if is_hopeless(apart_s[np.ix_(few, few)], period_s[few], most_states=100_000):
        yield ProvedBound(
            robots=2,
            reason=f"no robot can come to all of {len(few)} places for ever, to each within its period",
        )


def times_near(apart_s: Floats, period_s: Floats) -> Floats:
    """The times z (n,) in seconds with the greatest sum of shares; 0 for all where the program has no answer.

    apart_s: (n, n), inf where there is no way. What rounding leaves of a sum above its limit is taken off.
    """
    from scipy.optimize import linprog  # a tenth of a second, which most plans do without

    i, j = np.triu_indices(len(period_s), 1)
    binds = apart_s[i, j] < (period_s[i] + period_s[j]) / 2
    i, j = i[binds], j[binds]
    limits_s, each = apart_s[i, j], np.arange(len(i))
    rows = csr_array((np.ones(2 * len(i)), (np.r_[each, each], np.r_[i, j])), shape=(len(i), len(period_s)))
    bounds = np.column_stack([np.zeros(len(period_s)), period_s / 2])
    found = linprog(-2 / period_s, A_ub=rows, b_ub=limits_s, bounds=bounds, method="highs-ds")
    if found.x is None:
        return np.zeros(len(period_s))
    near_s = np.clip(found.x, 0.0, period_s / 2)
    over_s = np.maximum(near_s[i] + near_s[j] - limits_s, 0.0)
    np.subtract.at(near_s, i, over_s)
    return np.asarray(np.maximum(near_s, 0.0))


def far_from_each_other(order: Ints, apart_s: Floats, least_s: float) -> Ints:
    """The first ``MOST_TOGETHER`` places in this order (n,) that are ``least_s`` from all taken before."""
    taken: list[int] = []
    for place in order:
        if len(taken) < MOST_TOGETHER and all(apart_s[place, other] >= least_s for other in taken):
            taken.append(int(place))
    return np.array(taken, dtype=np.int64)

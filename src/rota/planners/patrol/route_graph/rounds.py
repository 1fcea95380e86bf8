"""Who comes to which places on lanes: rounds of each place once, cut from one order, and those that revisit places."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.cycles.in_step import with_one_less
from rota.planners.patrol.cycles.teams import Share, share_places, worth
from rota.planners.patrol.methods.cycles.search import MOST_TARGETS, ROUNDS, STATES, STATES_IN_STEP
from rota.planners.patrol.planner_settings import Effort
from rota.planners.patrol.route_graph.network import Calls
from rota.planners.patrol.route_graph.splitting_kernels import anneal_order, split_at_best
from rota.planners.patrol.tolerances import SLOWER

MOVES: dict[Effort, int] = {"quick": 120_000, "normal": 500_000, "high": 3_000_000}  # tried on the order of places
PER_LOAD = 0.3  # of a robot: what a robot's full load costs, so that rounds become shorter until one robot is spared


def fewest_shares(
    calls: Calls, *, effort: Effort, enough: int, with_step: bool, seed: int, should_stop: Callable[[], bool]
) -> list[Share]:
    """The fewest robots found that come to all places in time, in each part of the network by itself.

    with_step: robots may keep step with each other; their times then leave no room to wait for others.
    """
    shares = list[Share]()
    parts = [np.flatnonzero(calls.part == part) for part in np.unique(calls.part)]
    for own in parts:
        leg_s, period_s = calls.leg_s[np.ix_(own, own)], calls.period_s[own]
        found = plain_shares(leg_s, period_s, moves=MOVES[effort], seed=seed)
        if len(own) <= MOST_TARGETS:
            again = share_places(
                leg_s, period_s, most_states=STATES[effort], rounds=ROUNDS[effort], seed=seed,
                should_stop=should_stop, begin=found,
            )  # fmt: skip
            found = min(found, again, key=worth)
        if with_step:
            found = with_one_less(
                found, leg_s, period_s, most_states=STATES_IN_STEP * STATES[effort],
                enough=enough if len(parts) == 1 else 1, should_stop=should_stop,
            )  # fmt: skip
        shares += [share._replace(order=own[share.order]) for share in found]
    return shares


def plain_shares(leg_s: Floats, period_s: Floats, *, moves: int, seed: int) -> list[Share]:
    """Rounds that come to each place (n,) once, from an order of all of them that moves have made better."""
    order = nearest_first(leg_s)
    settings = np.array([moves, 0.3, 1e-3, PER_LOAD])
    random = np.array([2 * seed + 1], dtype=np.uint64)
    anneal_order(order, leg_s, period_s, settings, random)
    least, cut = np.zeros(len(order) + 1), np.zeros(len(order) + 1, dtype=np.int64)
    split_at_best(order, leg_s, period_s, PER_LOAD, least, cut)
    shares, end = list[Share](), len(order)
    while end:
        some, end = order[cut[end] : end], int(cut[end])
        round_s = float(leg_s[some, np.roll(some, -1)].sum()) if len(some) > 1 else 0.0
        headway_s = float(period_s[some].min())
        shares.append(Share(some, max(1, math.ceil(round_s / (SLOWER * headway_s))), round_s, headway_s))
    return shares[::-1]


def nearest_first(leg_s: Floats) -> Ints:
    """All places (n,), each followed by the nearest that is left."""
    order, left = [0], set(range(1, len(leg_s)))
    while left:
        order.append(min(left, key=lambda k: (leg_s[order[-1], k], k)))
        left.remove(order[-1])
    return np.array(order, dtype=np.int64)


def with_spare_robots(shares: list[Share], robots: int) -> list[Share]:
    """The shares with so many robots in all: each more goes where robots are the latest for their period."""
    shares = list(shares)
    for _ in range(robots - sum(share.robots for share in shares)):
        plain = [k for k, share in enumerate(shares) if share.is_plain]
        if not plain:
            plain = list(range(len(shares)))  # it stands by
        k = max(plain, key=lambda k: shares[k].round_s / shares[k].robots / shares[k].headway_s)
        shares[k] = shares[k]._replace(robots=shares[k].robots + 1)
    return shares

"""Robots that share places on rounds of equal time, where each with places of its own would be more."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from rota.model.arrays import Floats
from rota.planners.patrol.cycles.one_robot import DEAD_KEPT
from rota.planners.patrol.cycles.step_kernels import rounds_in_step
from rota.planners.patrol.cycles.teams import MOST_TOGETHER, Share


def with_one_less(
    shares: list[Share],
    leg_s: Floats,
    period_s: Floats,
    *,
    most_states: int,
    enough: int,
    should_stop: Callable[[], bool] = lambda: False,
) -> list[Share]:
    """The team with some of its shares put together and done by a robot less, again and again; the same where none are.

    leg_s (n, n), period_s (n,) as for ``share_places``. The fewest shares are put together first. It ends with
    ``enough`` robots, or where the search is to stop.
    """
    while sum(share.robots for share in shares) > enough:
        for chosen in groups_to_join(shares):
            if should_stop():
                return shares
            places = np.unique(np.concatenate([shares[k].order for k in chosen]))
            robots = sum(shares[k].robots for k in chosen) - 1
            joined = serve_in_step(leg_s[np.ix_(places, places)], period_s[places], robots, most_states=most_states)
            if joined:
                own = [share._replace(order=places[share.order]) for share in joined]
                shares = [share for k, share in enumerate(shares) if k not in chosen] + own
                break
        else:
            return shares
    return shares


def groups_to_join(shares: list[Share]) -> list[tuple[int, ...]]:
    """The numbers of shares that together have a few robots and places; those with the fewest places first."""
    most = 4  # robots
    groups = [
        chosen
        for count in range(1, most + 1)
        for chosen in itertools.combinations(range(len(shares)), count)
        if sum(shares[k].robots for k in chosen) <= most
        and sum(len(np.unique(shares[k].order)) for k in chosen) <= MOST_TOGETHER
        and all(shares[k].times_s is None for k in chosen)
    ]
    return sorted(groups, key=lambda chosen: sum(len(np.unique(shares[k].order)) for k in chosen))


def serve_in_step(leg_s: Floats, period_s: Floats, robots: int, *, most_states: int) -> list[Share]:
    """The rounds of so many robots that come to all places together; none where none were found.

    A robot that the others do not need has no round.
    """
    if not np.isfinite(leg_s).all() or robots < 2:
        return []
    n, tick_s = len(period_s), float(period_s.min()) / 1000  # coarse times make rounds of robots equal
    leg = np.vstack([np.ceil(leg_s / tick_s), np.zeros((1, n))]).astype(np.int64)
    period = np.floor(period_s / tick_s).astype(np.int64)
    most_arrivals = 4000  # before the search is given up
    arrivals = np.zeros((robots * most_arrivals, 3), dtype=np.int64)
    most = np.array([most_states, most_arrivals, DEAD_KEPT])
    count, round_ticks = rounds_in_step(leg, period, robots, most, arrivals)
    own = [arrivals[:count][arrivals[:count, 0] == r] for r in range(robots)]
    round_s = round_ticks * tick_s
    return [Share(a[:, 1].copy(), 1, round_s, round_s, a[:, 2] * tick_s) for a in own if len(a)]

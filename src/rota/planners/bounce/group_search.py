"""The periodic group that is best for a purpose: zones' periods met, the shortest worst gap."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rota.planners.bounce.group_count import TooMany, count_groups
from rota.planners.bounce.monitoring import Group, Watch

Flags = NDArray[np.bool_]
Floats = NDArray[np.float64]

MOST_NODES = 20_000  # partial teams that the search looks at
MOST_COUNTED = 20_000  # sets of states looked at to learn that there is no group


def best_group(
    watch: Watch, *, enough: float = 0.0, most_nodes: int = MOST_NODES, should_stop: Callable[[], bool] | None = None
) -> Group | None:
    """The group with the smallest worst ratio of gap to period; None when no group watches all zones.

    enough: stop at the first group whose ratio is no larger (1: all periods met). Teams are built robot by robot, those
    first that shorten the worst ratio most and leave most room to the others; a partial team is given up when even
    visits at the most frequent rate left cannot make it better than the best. After ``most_nodes`` partial teams the
    search ends; ``proved`` tells that it went on to the end.
    """
    search = _Search(watch, enough, most_nodes, should_stop or (lambda: False))
    quick = search.by_single_robots()
    if quick is None and _there_is_none(watch):
        return None
    if not search.done():
        search.extend((), np.ones(len(watch.cycles.state), np.bool_), 1)
    if search.best is None:
        return None
    ratio, nodes = search.best
    return Group(nodes=nodes, ratio=ratio, proved=not search.cut_short and (enough == 0 or ratio > enough))


def _there_is_none(watch: Watch) -> bool:
    """Whether no group watches all zones, counted; False when that takes too long to know."""
    try:
        return count_groups(watch.cycles, watch.sees, most_calls=MOST_COUNTED) == 0
    except TooMany:
        return False


class _Search:
    def __init__(self, watch: Watch, enough: float, most_nodes: int, should_stop: Callable[[], bool]) -> None:
        self.watch, self.enough, self.left, self.should_stop = watch, enough, most_nodes, should_stop
        self.best: tuple[float, tuple[int, ...]] | None = None
        self.cut_short = False
        cycles = watch.cycles
        self.robots = len(cycles.kind_of_robot)
        count = len(cycles.length)
        self.alone = (
            np.array(
                [[watch.gap_steps([int(cycles.start[c])], z) for z in range(watch.sees.shape[1])] for c in range(count)]
            ).reshape(count, -1)
            / watch.period_steps
        )
        visits = np.add.reduceat(watch.sees.astype(np.float64), cycles.start, axis=0)
        self.rate = visits / cycles.length[:, None] * watch.period_steps  # visits in a period
        self.conflicts = (~cycles.compatible).sum(axis=1)

    def by_single_robots(self) -> tuple[int, ...] | None:
        """A team in which one robot alone meets each zone's limit; the others go where they meet nobody."""
        zones = list(range(self.watch.sees.shape[1]))
        limit = self.enough if self.enough > 0 else math.inf
        budget = [self.left // 4]
        return self._single({}, np.ones(len(self.watch.cycles.state), np.bool_), zones, limit, budget)

    def _single(
        self, chosen: dict[int, int], free: Flags, zones: list[int], limit: float, budget: list[int]
    ) -> tuple[int, ...] | None:
        """chosen: robot to node. zones: those that no chosen robot watches within the limit."""
        cycles = self.watch.cycles
        budget[0] -= 1
        if len(chosen) == self.robots:
            nodes = tuple(chosen[k] for k in range(self.robots))
            if zones:
                return None
            self._note(nodes)
            return nodes
        waiting = [k for k in range(self.robots) if k not in chosen]
        room = free & np.isin(cycles.kind, [cycles.kind_of_robot[k] for k in waiting])
        candidates = np.flatnonzero(room)
        if not chosen:  # a common shift in time changes nothing
            candidates = candidates[cycles.phase[candidates] == 0]
        if zones:
            good = self.alone[cycles.cycle[candidates]][:, zones] <= limit
            rarest = int(np.argmin(good.sum(axis=0)))
            candidates, good = candidates[good[:, rarest]], good[good[:, rarest]]
            order = np.lexsort((self.conflicts[candidates], -good.sum(axis=1)))
        else:
            inside = (~cycles.compatible[np.ix_(candidates, np.flatnonzero(room))]).sum(axis=1)
            order = np.argsort(inside, kind="stable")
        for node in candidates[order]:
            if budget[0] <= 0:
                return None
            robot = next(k for k in waiting if cycles.kind_of_robot[k] == cycles.kind[node])
            left = [z for z in zones if self.alone[cycles.cycle[node], z] > limit]
            if len(left) > len(waiting) - 1:
                continue
            found = self._single({**chosen, robot: int(node)}, free & cycles.compatible[node], left, limit, budget)
            if found is not None:
                return found
        return None

    def extend(self, nodes: tuple[int, ...], free: Flags, period: int) -> None:
        """All teams that begin with these robots, as far as they may be better than the best."""
        cycles = self.watch.cycles
        if len(nodes) == self.robots:
            self._note(nodes)
            return
        self.left -= 1
        robot = len(nodes)
        candidates = np.flatnonzero(free & (cycles.kind == cycles.kind_of_robot[robot]))
        lengths = cycles.length[cycles.cycle[candidates]]
        candidates = candidates[cycles.phase[candidates] < np.gcd(period, lengths)]
        if robot and cycles.kind_of_robot[robot] == cycles.kind_of_robot[robot - 1]:
            # equal robots in the order of their cycles
            candidates = candidates[cycles.cycle[candidates] >= cycles.cycle[nodes[-1]]]
        if self.left <= 0 or self.should_stop():
            self.cut_short = True
            return
        if not self._may_improve(nodes, free):
            return
        last = len(nodes) == self.robots - 1
        worth = [self.watch.ratio((*nodes, int(node))) for node in candidates] if last else None
        order = np.argsort(worth if worth is not None else self.alone[cycles.cycle[candidates]].max(axis=1, initial=0),
                           kind="stable")  # fmt: skip
        for k in order[:1] if last else order:
            node = int(candidates[k])
            length = int(cycles.length[cycles.cycle[node]])
            self.extend((*nodes, node), free & cycles.compatible[node], math.lcm(period, length))
            if self.cut_short or self.done():
                return

    def _may_improve(self, nodes: tuple[int, ...], free: Flags) -> bool:
        """Whether visits are frequent enough for a better ratio: n visits in a period leave a gap of 1 / n of it."""
        if self.best is None:
            return True
        cycles = self.watch.cycles
        rate = self.rate[cycles.cycle[list(nodes)]].sum(axis=0) if nodes else np.zeros(self.rate.shape[1])
        for k in range(len(nodes), self.robots):
            usable = np.unique(cycles.cycle[free & (cycles.kind == cycles.kind_of_robot[k])])
            if not len(usable):
                return False
            rate = rate + self.rate[usable].max(axis=0)
        return bool((rate * self.best[0] > 1 + 1e-12).all())

    def _note(self, nodes: tuple[int, ...]) -> None:
        ratio = self.watch.ratio(nodes)
        if math.isfinite(ratio) and (self.best is None or ratio < self.best[0]):
            self.best = (ratio, nodes)

    def done(self) -> bool:
        """Whether what was found is good enough."""
        return self.best is not None and self.best[0] <= self.enough

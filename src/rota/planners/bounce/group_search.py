"""The periodic group that is best for a purpose: zones' periods met, the shortest worst gap."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rota.planners.bounce.arrays import Flags, Floats, Longs
from rota.planners.bounce.group_count import TooMany, count_groups
from rota.planners.bounce.monitoring import LONGEST_PERIOD, Group, Watch

MOST_NODES = 20_000  # partial teams that the search looks at
QUICK_SHARE, LIMITS = 4, 12  # of them for teams of one robot for each zone; limits that these are tried with
MOST_COUNTING = 1_000_000  # units of work to learn that there is no group
PERIOD_WORK = 20_000  # steps of a common period that are as much work as a partial team
NO_GAP = 1 << 40  # steps; longer than any


@dataclass(frozen=True, kw_only=True)
class Searched:
    """The outcome of a search. ``proved``: no group is better, or, where no group was found, there is none at all.

    unproved: why that is not known, in words that go on after "...;"; None where it is proved, or was not asked for.
    """

    group: Group | None
    proved: bool
    unproved: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Gaps:
    """The different gaps between visits of a zone, in steps, rising, and how often each comes in a period."""

    steps: Longs
    counts: Longs
    period: int

    def covered_share(self, limit: int) -> float:
        """The share of the time at which the last visit is no more than ``limit`` steps ago, less the visit's own."""
        return float((np.minimum(self.steps, limit) * self.counts).sum() / self.period)


def best_group(
    watch: Watch,
    *,
    enough: float = 0.0,
    most_nodes: int = MOST_NODES,
    should_stop: Callable[[], bool] | None = None,
    allowed: Flags | None = None,
    last: Flags | None = None,
) -> Searched:
    """The group with the smallest worst ratio of gap to period, of those found; see ``Searched`` for what is known.

    enough: stop at the first group whose ratio is no larger (1: all periods met). First come teams in which one robot
    alone is often enough in each zone. Then come all others, zone by zone: a robot is given to the zone that fewest can
    help, as long as the other robots may make the team better than the best. A robot that is to leave gaps of at most g
    steps covers the g steps of its round after each visit. All robots together must cover all of a zone's time. After
    ``most_nodes`` partial teams the search ends. allowed: (p,) periodic states that a group may hold; None: all. last:
    (p,) those that are tried after all others.
    """
    search = _Search(watch, enough, most_nodes, should_stop, allowed, last)
    search.by_single_robots()
    if search.best is None and allowed is None and not search.is_to_end() and _there_is_none(watch):
        return Searched(group=None, proved=True)
    if not search.is_good_enough():
        search.extend({}, search.allowed, 1)
    unproved = search.reason_of_no_proof()
    if search.best is None:
        return Searched(group=None, proved=unproved is None, unproved=unproved)
    ratio, nodes = search.best
    wants_proof = enough == 0 or ratio > enough
    return Searched(group=Group(nodes=nodes, ratio=ratio), proved=wants_proof and unproved is None,
                    unproved=unproved if wants_proof else None)  # fmt: skip


def _there_is_none(watch: Watch) -> bool:
    """Whether no group watches all zones, by counting; False when the count takes too long."""
    try:
        return count_groups(watch.cycles, watch.sees, most_work=MOST_COUNTING) == 0
    except TooMany:
        return False


class _Search:
    """Teams robot by robot, of limited work: the best so far, and whether it is proved.

    alone: (c, z) worst ratio of a robot alone on each cycle, by zone. conflicts: (p,) how many states each state cannot
    go with. left: partial teams that may still be looked at.
    """

    def __init__(
        self,
        watch: Watch,
        enough: float,
        most_nodes: int,
        should_stop: Callable[[], bool] | None,
        allowed: Flags | None,
        last: Flags | None,
    ) -> None:
        self.watch, self.enough, self.left, self._should_stop = watch, enough, most_nodes, should_stop
        self.most_nodes = most_nodes
        self.best: tuple[float, tuple[int, ...]] | None = None
        self.cut_short = False
        self.rough = False  # a common period was too long to know a gap exactly
        cycles, self.zones = watch.cycles, watch.sees.shape[1]
        self.robots = len(cycles.kind_of_robot)
        self._known: dict[tuple[int, tuple[int, ...]], _Gaps | None] = {}
        firsts = [int(start) for start in cycles.start]
        single = [[self._gaps((node,), z) for z in range(self.zones)] for node in firsts]
        worst = [[math.inf if gaps is None else float(gaps.steps[-1]) for gaps in row] for row in single]
        self.alone = np.array(worst, np.float64).reshape(len(firsts), self.zones) / watch.period_steps
        self._single = single
        self._covers: tuple[float, Floats] = (math.nan, np.empty(0))
        self.allowed = np.ones(len(cycles.state), np.bool_) if allowed is None else allowed
        self.last = np.zeros(len(cycles.state), np.bool_) if last is None else last
        self.conflicts = (~cycles.compatible).sum(axis=1)

    # ---------------------------------------------------------------- one robot alone for each zone

    def by_single_robots(self) -> None:
        """Teams in which one robot alone meets each zone's limit; the others go where they meet nobody.

        Where no limit is given, or it cannot be met, limits are tried between the least that each zone allows and the
        best so far.
        """
        budget = self.left // QUICK_SHARE
        if self.enough > 0 and self._team_within(self.enough, budget):
            return
        limits = np.unique(self.alone[np.isfinite(self.alone)])
        least = float(self.alone.min(axis=0, initial=math.inf).max(initial=0.0))
        limits = limits[limits >= max(least, self.enough)]
        low, high = 0, len(limits) - 1
        if high < 0 or not self._team_within(float(limits[-1]), budget):
            return
        for _ in range(LIMITS):
            assert self.best is not None
            high = min(high, int(np.searchsorted(limits, self.best[0]))) - 1
            if low > high:
                return
            middle = (low + high) // 2
            if self._team_within(float(limits[middle]), budget // LIMITS):
                high = middle
            else:
                low, high = middle + 1, high + 1

    def _team_within(self, limit: float, most: int) -> bool:
        """Whether ``most`` partial teams or fewer lead to a team in which single robots keep the limit in each zone."""
        budget = [most]
        return self._give({}, self.allowed, list(range(self.zones)), limit, budget)

    def _give(self, chosen: dict[int, int], free: Flags, zones: list[int], limit: float, budget: list[int]) -> bool:
        """Whether a team is found, which is then noted. zones: those that no chosen robot watches within the limit.

        chosen: a node by robot. free: (p,) nodes that meet none of them. budget: a list with the partial teams left.
        """
        cycles = self.watch.cycles
        budget[0] -= 1
        self.left -= 1
        if len(chosen) == self.robots:
            self._note(chosen)
            return not zones
        waiting = [k for k in range(self.robots) if k not in chosen]
        room = free & np.isin(cycles.kind, [cycles.kind_of_robot[k] for k in waiting])
        candidates = self._distinct(np.flatnonzero(room), self._period(chosen))
        if zones:
            good = self.alone[cycles.cycle[candidates]][:, zones] <= limit
            rarest = int(np.argmin(good.sum(axis=0)))
            candidates, good = candidates[good[:, rarest]], good[good[:, rarest]]
            order = np.lexsort((self.conflicts[candidates], -good.sum(axis=1), self.last[candidates]))
        else:
            order = self._roomiest(candidates, room)
        for node in candidates[order]:
            if budget[0] <= 0 or (self.best is not None and self.is_to_end()):  # a first team is soon found or given up
                return False
            robot = self._robot_for(node, chosen)
            left = [z for z in zones if self.alone[cycles.cycle[node], z] > limit]
            if len(left) > len(waiting) - 1:
                continue
            if self._give({**chosen, robot: int(node)}, free & cycles.compatible[node], left, limit, budget):
                return True
        return False

    def _robot_for(self, node: int, chosen: dict[int, int]) -> int:
        """The first robot of the node's kind that has none yet."""
        cycles = self.watch.cycles
        return next(k for k, kind in enumerate(cycles.kind_of_robot) if k not in chosen and kind == cycles.kind[node])

    def _roomiest(self, candidates: Longs, room: Flags) -> Longs:
        """The order in which candidates leave most room to others."""
        compatible = self.watch.cycles.compatible
        inside = (~compatible[np.ix_(candidates, np.flatnonzero(room))]).sum(axis=1)
        return np.lexsort((inside, self.last[candidates]))

    # ---------------------------------------------------------------- all teams

    def extend(self, chosen: dict[int, int], free: Flags, period: int) -> None:
        """Try all teams with the chosen robots that may beat the best. free: (p,) nodes that meet none of them."""
        nodes = tuple(chosen[k] for k in sorted(chosen))
        self.left -= 1 + period * self.zones // PERIOD_WORK
        if len(chosen) == self.robots:
            self._note(chosen)
            return
        cycles = self.watch.cycles
        kinds = [cycles.kind_of_robot[k] for k in range(self.robots) if k not in chosen]
        free = free & np.isin(cycles.kind, kinds)
        gaps = [self._gaps(nodes, z) for z in range(self.zones)]
        order: Longs | None = None
        while True:
            if self.left <= 0 or self.is_to_end():
                self.cut_short = True
                return
            candidates = self._distinct(np.flatnonzero(free), period)
            if len(candidates) == 0:
                return
            options, lacking = self._options(candidates, gaps, len(kinds))
            if len(options) == 0:
                return
            if not lacking:  # whoever meets nobody will do
                if order is None:
                    order = candidates[self._roomiest(candidates, free)]
                options = order[free[order]]
            node = int(options[0])
            robot = self._robot_for(node, chosen)
            length = int(cycles.length[cycles.cycle[node]])
            self.extend({**chosen, robot: node}, free & cycles.compatible[node], math.lcm(period, length))
            if self.is_good_enough():
                return
            # all teams with it were looked at, and so with what is the same at another time
            free[self._same(node, period)] = False

    def _options(self, candidates: Longs, gaps: list[_Gaps | None], robots: int) -> tuple[Longs, bool]:
        """Candidates (k,) of which any better team has at least one, the most helpful first, and whether one must come.

        robots: how many are still to come. gaps: by zone, of the robots so far. Of the zones whose gaps are too long,
        the one counts that fewest candidates help.
        """
        limits = self._limits()
        late = [z for z in range(self.zones) if gaps[z] is None or gaps[z].steps[-1] > limits[z]]  # type: ignore[union-attr]
        if not late:
            return candidates, False
        covers = self._covered_shares(limits)[self.watch.cycles.cycle[candidates]][:, late]
        missing = np.array([1.0 if (g := gaps[z]) is None else 1 - g.covered_share(int(limits[z])) for z in late])
        helps = np.minimum(covers, missing)
        if robots * helps.sum(axis=1).max() < missing.sum() - 1e-9:
            return candidates[:0], True
        enough = covers >= missing / robots - 1e-9
        enough &= covers > 0
        usable = enough.all(axis=1) if robots == 1 else enough[:, int(np.argmin(enough.sum(axis=0)))]
        chosen = np.flatnonzero(usable)
        worth = helps[chosen].sum(axis=1)
        order = np.lexsort((self.conflicts[candidates[chosen]], -worth, self.last[candidates[chosen]]))
        return candidates[chosen[order]], True

    def _limits(self) -> Longs:
        """(z,) steps that a gap may have in a team better than the best."""
        if self.best is None:
            return np.full(self.zones, NO_GAP)
        return np.ceil(self.best[0] * self.watch.period_steps - 1e-9).astype(np.int64) - 1

    def _covered_shares(self, limits: Longs) -> Floats:
        """(c, z) shares of a zone's time that a robot covers on each cycle."""
        ratio = math.inf if self.best is None else self.best[0]
        if self._covers[0] != ratio:
            shares = [
                [0.0 if gaps is None else gaps.covered_share(int(limits[z])) for z, gaps in enumerate(row)]
                for row in self._single
            ]
            self._covers = (ratio, np.array(shares, np.float64).reshape(len(self._single), self.zones))
        return self._covers[1]

    # ---------------------------------------------------------------- what both need

    def _period(self, chosen: dict[int, int]) -> int:
        """The common period, in steps, of the robots chosen so far."""
        return self.watch.cycles.common_period(list(chosen.values()))

    def _distinct(self, nodes: Longs, period: int) -> Longs:
        """The nodes that are no earlier node's state some multiple of ``period`` steps later."""
        cycles = self.watch.cycles
        return nodes[cycles.phase[nodes] < np.gcd(period, cycles.length[cycles.cycle[nodes]])]

    def _same(self, node: int, period: int) -> Longs:
        """The nodes of the same cycle that make the same team with robots of this common period, at other times."""
        cycles = self.watch.cycles
        cycle = int(cycles.cycle[node])
        start, length = int(cycles.start[cycle]), int(cycles.length[cycle])
        step = math.gcd(period, length)
        return start + np.arange(int(cycles.phase[node]) % step, length, step)

    def _gaps(self, nodes: tuple[int, ...], zone: int) -> _Gaps | None:
        """The gaps that robots leave in a zone, exact up to LONGEST_PERIOD; None when none of them enters it."""
        visiting = self.watch.visiting(nodes, zone)
        key = (zone, visiting)
        if key not in self._known:
            self._known[key] = self._new_gaps(visiting, zone)
        return self._known[key]

    def _new_gaps(self, visiting: tuple[int, ...], zone: int) -> _Gaps | None:
        """The gaps that these nodes leave in a zone; a lower estimate where their common period is too long."""
        if not visiting:
            return None
        period = self.watch.cycles.common_period(visiting)
        if period > LONGEST_PERIOD:  # as good as their best pair, and everything may be covered
            self.rough = True
            steps = np.array([1, int(self.watch.gap_steps(visiting, zone))])
            return _Gaps(steps=steps, counts=np.array([int(steps[1]), 0]), period=int(steps[1]))
        steps, counts = np.unique(self.watch.gaps_of(visiting, zone), return_counts=True)
        return _Gaps(steps=steps, counts=counts, period=period)

    def _note(self, chosen: dict[int, int]) -> None:
        """Keep a whole team if it is better than the best so far."""
        nodes = tuple(chosen[k] for k in range(self.robots))
        worst = 0.0
        for z, period in enumerate(self.watch.period_steps):
            gaps = self._gaps(nodes, z)
            worst = max(worst, math.inf if gaps is None else float(gaps.steps[-1] / period))
        if math.isfinite(worst) and (self.best is None or worst < self.best[0]):
            self.best = (worst, nodes)

    def is_to_end(self) -> bool:
        """Whether the search is to end, whatever it has come to."""
        return self._should_stop is not None and self._should_stop()

    def reason_of_no_proof(self) -> str | None:
        """Why something better may have been left out; None when it was not."""
        if not self.cut_short and not self.rough:
            return None
        if self.is_to_end():
            return "the search was stopped"
        if self.cut_short:
            return f"the search ended after {self.most_nodes:,} partial team" + "s" * (self.most_nodes != 1)
        return "the robots' common period is too long to know all gaps"

    def is_good_enough(self) -> bool:
        """Whether what was found is good enough."""
        return self.best is not None and self.best[0] <= self.enough

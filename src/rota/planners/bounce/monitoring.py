"""Algorithm 2 of Alam & Bobadilla 2020: all periodic groups of a team that watch target zones without contact.

A group without contact is a product of single robots' limit cycles, so none of this needs the joint map, all of which
``enumeration.py`` goes through, as published.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.planners.bounce.limit_cycles import LimitCycles

Flags = NDArray[np.bool_]
Floats = NDArray[np.float64]
Longs = NDArray[np.int64]

LONGEST_PERIOD = 200_000  # steps over which gaps are computed exactly; beyond it pairs of robots bound them


@dataclass(frozen=True, kw_only=True)
class Group:
    """A periodic group: one periodic state per robot, at a common time. ``ratio``: zones' worst gap over period."""

    nodes: tuple[int, ...]
    ratio: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Watch:
    """What a team is to watch: ``sees`` (p, z), the periodic states in each zone; ``period_steps`` (z,)."""

    cycles: LimitCycles
    sees: Flags
    period_steps: Floats

    def ratio(self, nodes: Sequence[int]) -> float:
        """The worst gap between visits of a zone, over its period, of robots in these periodic states; inf: unseen."""
        worst = 0.0
        for z, period in enumerate(self.period_steps):
            worst = max(worst, self.gap_steps(nodes, z) / period)
        return worst

    def gap_steps(self, nodes: Sequence[int], zone: int) -> float:
        """The most steps between two visits of a zone; inf when it has none.

        Exact unless the visiting robots' common period is longer than LONGEST_PERIOD: then the least of all pairs'.
        """
        visiting = self.visiting(nodes, zone)
        if not visiting:
            return math.inf
        if self.cycles.common_period(visiting) <= LONGEST_PERIOD:
            return float(self.gaps_of(visiting, zone).max())
        best = min(self.gaps_of([node], zone).max() for node in visiting)
        for k, node in enumerate(visiting):
            for other in visiting[:k]:
                if self.cycles.common_period([node, other]) <= LONGEST_PERIOD:
                    best = min(best, self.gaps_of([node, other], zone).max())
        return float(best)

    def visiting(self, nodes: Sequence[int], zone: int) -> tuple[int, ...]:
        """Those of the nodes whose cycles enter the zone."""
        return tuple(node for node in nodes if len(self._visits(int(self.cycles.cycle[node]), zone)))

    def _visits(self, cycle: int, zone: int) -> Longs:
        """Phases of a cycle at which the robot is in the zone."""
        start, length = self.cycles.start[cycle], self.cycles.length[cycle]
        return np.flatnonzero(self.sees[start : start + length, zone])

    def gaps_of(self, nodes: Sequence[int], zone: int) -> Longs:
        """Steps (v,) between the visits of a zone in a common period of the robots; at least one of them enters it."""
        period = self.cycles.common_period(nodes)
        at = np.zeros(period, np.bool_)
        for node in nodes:
            cycle = int(self.cycles.cycle[node])
            length = int(self.cycles.length[cycle])
            visits = (self._visits(cycle, zone) - self.cycles.phase[node]) % length
            at.reshape(-1, length)[:, visits] = True
        times = np.flatnonzero(at)
        return np.diff(times, append=times[0] + period)


def groups(watch: Watch, *, unordered: bool = False) -> Iterator[tuple[int, ...]]:
    """All periodic groups that watch every zone, lazily: one periodic state per robot, at a common time.

    Each group is given once. The first robot's cycle has phase 0. The next robot's phases are those below the greatest
    common divisor of its cycle's length and the common period so far, which is how many differ. unordered: of equal
    robots only groups whose nodes rise are followed, and of groups that are the same set at other times the first is
    given.
    """
    robots = len(watch.cycles.kind_of_robot)
    for nodes in _extend(watch, (), np.ones(len(watch.cycles.state), np.bool_), 1, robots):
        if watch.sees.shape[1] and not _covers(watch, nodes):
            continue
        if unordered and nodes != _first_of_sets(watch.cycles, nodes):
            continue
        yield nodes


def _covers(watch: Watch, nodes: Sequence[int]) -> bool:
    """Whether the cycles of these nodes together enter every zone."""
    seen = np.zeros(watch.sees.shape[1], np.bool_)
    for node in nodes:
        start = watch.cycles.start[watch.cycles.cycle[node]]
        length = watch.cycles.length[watch.cycles.cycle[node]]
        seen |= watch.sees[start : start + length].any(axis=0)
    return bool(seen.all())


def _extend(watch: Watch, nodes: tuple[int, ...], free: Flags, period: int, robots: int) -> Iterator[tuple[int, ...]]:
    """All teams that begin with ``nodes`` and whose robots never meet; free: (p,) nodes that meet none of these."""
    if len(nodes) == robots:
        yield nodes
        return
    cycles = watch.cycles
    kind = cycles.kind_of_robot[len(nodes)]
    for node in np.flatnonzero(free & (cycles.kind == kind)):
        length = int(cycles.length[cycles.cycle[node]])
        if cycles.phase[node] < math.gcd(period, length):
            yield from _extend(
                watch, (*nodes, int(node)), free & cycles.compatible[node], math.lcm(period, length), robots
            )


def _first_of_sets(cycles: LimitCycles, nodes: tuple[int, ...]) -> tuple[int, ...]:
    """The least of all forms in which ``groups`` would give the same robots if they were not told apart."""
    period = cycles.common_period(nodes)
    forms = []
    for step in range(period):
        later = [cycles.later(node, step) for node in nodes]
        # states sorted among the robots of each kind
        order = sorted(range(len(nodes)), key=lambda k: (cycles.kind_of_robot[k], later[k]))
        form = [0] * len(nodes)
        slots = sorted(range(len(nodes)), key=lambda k: (cycles.kind_of_robot[k], k))
        for slot, k in zip(slots, order, strict=True):
            form[slot] = later[k]
        forms.append(canonical(cycles, form))
    return min(forms)


def canonical(cycles: LimitCycles, nodes: Sequence[int]) -> tuple[int, ...]:
    """The same robots at the time at which ``groups`` gives them."""
    shift, period = 0, 1
    for node in nodes:
        length = int(cycles.length[cycles.cycle[node]])
        g = math.gcd(period, length)
        phase = (int(cycles.phase[node]) + shift) % length
        # multiples of the period so far bring the phase below g
        while phase >= g:
            shift += period
            phase = (phase + period) % length
        period = math.lcm(period, length)
    return tuple(cycles.later(node, shift) for node in nodes)

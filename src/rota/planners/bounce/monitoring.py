"""Algorithm 2 of Alam & Bobadilla 2020: all periodic groups of a team that watch target zones without contact.

A group without contact is a product of single robots' limit cycles, so none of this needs the joint map, all of which
``enumeration.py`` goes through, as published.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.planners.bounce.arrays import Flags, Floats, Longs
from rota.planners.bounce.limit_cycles import LimitCycles

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


def canonical(cycles: LimitCycles, nodes: Sequence[int]) -> tuple[int, ...]:
    """The same robots at the one time that stands for all: each robot's phase is below what those before it leave open.

    The first robot's is 0, the next one's below the greatest common divisor of its cycle's length and the common period
    so far.
    """
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

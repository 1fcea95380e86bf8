"""When the robots of a periodic group are where: rounds step by step, and how long each step lasts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.planners.bounce.arrays import Floats, Ints
from rota.planners.bounce.chosen_group import Chosen
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.trajectories import MOST_JOINT_STEPS, Pace

LEAST_GAIN = 0.1  # share of the common period; for less, shorter steps bring bodies nearer in time and pay too little


@dataclass(frozen=True, kw_only=True, eq=False)
class TimedGroup:
    """States and times, (t + 1,) for each robot, the way to the loop included; loops begin where the way ends.

    own_s (t, m), lasts_s (t,): what each robot needs for each step of one common period, or of its first steps, and
    what they last. joint: steps have durations of their own, and all loops last one common period.
    """

    states: tuple[Ints, ...]
    times_s: tuple[Floats, ...]
    own_s: Floats
    lasts_s: Floats
    common_period: int
    joint: bool

    def ratio(self, watch: Watch, chosen: Chosen, periods_s: Sequence[float]) -> float:
        """The worst gap between visits to a zone, over its period; as steps last, where they have their own times."""
        if not self.joint:
            return chosen.ratio
        times_s, worst = np.concatenate([[0.0], np.cumsum(self.lasts_s)]), 0.0
        for zone, period_s in enumerate(periods_s):
            visits = [t for t in range(self.common_period) if self._visits(watch, chosen, t, zone)]
            gaps_s = np.diff(times_s[visits], append=times_s[visits[0]] + times_s[-1])
            worst = max(worst, float(gaps_s.max()) / period_s)
        return worst

    def _visits(self, watch: Watch, chosen: Chosen, t: int, zone: int) -> bool:
        """Whether any robot is in the zone t steps after the loops begin."""
        return any(watch.sees[chosen.cycles.later(node, t), zone] for node in chosen.nodes)


def timed_group(pace: Pace, headings: int, chosen: Chosen) -> TimedGroup:
    """The group's rounds in time.

    On the way to the loops each step has its own duration. On the loops too, where that shortens their common period by
    LEAST_GAIN and the period has at most MOST_JOINT_STEPS; all loops are that long then. Otherwise all steps last as
    long as the longest, and each robot has its own loop. A robot alone has nobody to keep in step with: any gain is
    taken.
    """
    cycles, nodes = chosen.cycles, chosen.nodes
    period, lengths = cycles.common_period(nodes), [int(cycles.length[cycles.cycle[node]]) for node in nodes]
    looked_at = min(period, MOST_JOINT_STEPS)
    rounds = _states(chosen, looked_at)
    own_s = pace.own_s(rounds, headings)
    lasts_s = own_s.max(axis=1)
    least = LEAST_GAIN if len(nodes) > 1 else 0.0
    joint = period == looked_at and 1 - lasts_s.mean() / pace.longest_s > least
    loops = [period] * len(nodes) if joint else lengths
    way = np.concatenate([chosen.transient, rounds[:1]])
    way_s = pace.times_s(way, headings)
    states, times_s = [], []
    for k, steps in enumerate(loops):
        own = _states(chosen, steps)[:, k]
        loop_s = pace.times_s(rounds, headings) if joint else pace.longest_s * np.arange(steps + 1)
        states.append(np.concatenate([way[:-1, k], own]).astype(np.int32))
        times_s.append(np.concatenate([way_s[:-1], way_s[-1] + loop_s]))
    if not joint:
        lasts_s = np.full(len(own_s), pace.longest_s)
    return TimedGroup(
        states=tuple(states), times_s=tuple(times_s), own_s=own_s, lasts_s=lasts_s, common_period=period, joint=joint
    )


def _states(chosen: Chosen, steps: int) -> Ints:
    """(steps + 1, m) states from the beginning of the loops on."""
    cycles = chosen.cycles
    columns = []
    for node in chosen.nodes:
        cycle = cycles.cycle[node]
        later = (cycles.phase[node] + np.arange(steps + 1)) % cycles.length[cycle]
        columns.append(cycles.state[cycles.start[cycle] + later])
    return np.stack(columns, axis=1)

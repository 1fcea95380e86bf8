"""All periodic groups of a team that watch target zones without contact, one after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from rota.planners.bounce.limit_cycles import LimitCycles
from rota.planners.bounce.monitoring import Watch, canonical

Flags = NDArray[np.bool_]


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

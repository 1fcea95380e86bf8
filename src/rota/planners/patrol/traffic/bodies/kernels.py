"""Compiled loops of keeping bodies apart: the latest start from which a robot is at a place at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Ints

Bytes = NDArray[np.uint8]
ShortInts = NDArray[np.int32]


@allocation_free
def latest_starts(blocked: Bytes, begins: Bytes, latest: ShortInts) -> None:
    """Fill ``latest`` (places, times): when a robot at a place at a time left the first place, at the latest.

    blocked (places, columns): where somebody else is near, at times modulo the columns. begins (times,): whether it
    may leave then. -1: it cannot be there. In one step of time it goes on by one place, or waits.
    """
    places, times = latest.shape
    columns = blocked.shape[1]
    for t in range(times):
        latest[0, t] = t if begins[t] and not blocked[0, t % columns] else -1
    for s in range(1, places):
        latest[s, 0] = -1
        for t in range(1, times):
            best = max(latest[s - 1, t - 1], latest[s, t - 1])
            latest[s, t] = -1 if blocked[s, t % columns] else best


@allocation_free
def places_until(latest: ShortInts, arrival: int, place: Ints) -> None:
    """Fill ``place`` (times,): where a robot is, from its latest start until ``arrival`` at the last place.

    Seen from the end it goes on wherever it can, and waits only where it must.
    """
    s, t = latest.shape[0] - 1, arrival
    start = latest[s, t]
    place[t] = s
    while s > 0:
        if latest[s - 1, t - 1] == start:
            s -= 1
        t -= 1
        place[t] = s

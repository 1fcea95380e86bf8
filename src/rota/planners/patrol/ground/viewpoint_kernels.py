"""Compiled loops for places to look from: who sees what, and greedy set cover."""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import kernel
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees


@kernel
def places_see(x: Any, y: Any, reach: float, square: int, period_class: int, s: Samples, room: int) -> Any:
    """Samples that each place sees: starts (n + 1,) and indices; no place sees more than ``room``."""
    n = x.shape[0]
    start = np.zeros(n + 1, dtype=np.int64)
    runs = np.empty(2 * room, dtype=np.int32)
    items = np.empty(1024, dtype=np.int32)
    at = 0
    for i in range(n):
        written = leg_sees(Leg(x[i], y[i], x[i], y[i], reach, square), period_class, s, runs)
        for j in range(0, written, 2):
            while at + runs[j + 1] - runs[j] > items.shape[0]:
                items = np.concatenate((items, np.empty_like(items)))
            for sample in range(runs[j], runs[j + 1]):
                items[at] = sample
                at += 1
        start[i + 1] = at
    return start, items[:at].copy()


@kernel
def greedy_cover(start: Any, items: Any, weight: Any, covered: Any) -> Any:
    """Places chosen one after the other, each for the greatest weight of samples not yet covered; marks ``covered``."""
    n = start.shape[0] - 1
    count = weight.shape[0]
    back_start = np.zeros(count + 2, dtype=np.int64)
    for j in range(items.shape[0]):
        back_start[items[j] + 2] += 1
    for i in range(2, count + 2):
        back_start[i] += back_start[i - 1]
    back = np.empty(items.shape[0], dtype=np.int32)
    gain = np.zeros(n)
    for i in range(n):
        for j in range(start[i], start[i + 1]):
            back[back_start[items[j] + 1]] = i
            back_start[items[j] + 1] += 1
            if not covered[items[j]]:
                gain[i] += weight[items[j]]
    chosen = np.empty(n, dtype=np.int64)
    count_chosen = 0
    while count_chosen < n:
        best = np.argmax(gain)
        if gain[best] <= 1e-9:
            break
        chosen[count_chosen] = best
        count_chosen += 1
        for j in range(start[best], start[best + 1]):
            sample = items[j]
            if covered[sample]:
                continue
            covered[sample] = True
            for m in range(back_start[sample], back_start[sample + 1]):
                gain[back[m]] -= weight[sample]
        gain[best] = 0.0
    return chosen[:count_chosen]

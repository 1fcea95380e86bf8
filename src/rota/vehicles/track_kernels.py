# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Sampled tracks: how near they come to points, and which samples straight legs need (compiled)."""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import kernel


@kernel
def nearest_m(track, begins, points_m):
    """How near the samples (m, 3) come to each point (n, 3), among those from begins[k] to begins[k + 1]."""
    near = np.full(len(points_m), np.inf)
    for k in range(len(points_m)):
        for i in range(begins[k], begins[k + 1]):
            off2 = 0.0
            for axis in range(3):
                off2 += (track[i, axis] - points_m[k, axis]) ** 2
            near[k] = min(near[k], math.sqrt(off2))
    return near


@kernel
def kept_samples(times_s, positions_m, first, within_m):
    """Whether each sample is kept, so that straight motion between kept ones is never off by more than ``within_m``.

    The first, the last, and number ``first`` are. Douglas & Peucker's splitting, with places compared at equal times.
    """
    n = len(times_s)
    kept = np.zeros(n, np.bool_)
    kept[0] = kept[first] = kept[n - 1] = True
    stack = np.empty((n + 2, 2), np.int64)
    stack[0], stack[1] = (0, first), (first, n - 1)
    size = 2
    while size:
        size -= 1
        a, b = stack[size]
        worst2, at = within_m * within_m, -1
        for i in range(a + 1, b):
            share, off2 = (times_s[i] - times_s[a]) / (times_s[b] - times_s[a]), 0.0
            for axis in range(positions_m.shape[1]):
                straight = positions_m[a, axis] + share * (positions_m[b, axis] - positions_m[a, axis])
                off2 += (positions_m[i, axis] - straight) ** 2
            if off2 > worst2:
                worst2, at = off2, i
        if at >= 0:
            kept[at] = True
            stack[size], stack[size + 1] = (a, at), (at, b)
            size += 2
    return kept

"""Compiled: how legs share the samples that they see about as well, so that one may leave what another comes nearer to.

A sample is seen where the least of its legs' distances is within reach. That is no linear limit; but any weighted mean
of the distances is at least the least of them. Samples that are left to their nearest legs alone hold every leg where
it is: of two lanes side by side neither may move aside, for each has samples of its own on the line between them. A
mean whose weights balance the directions in which the legs lie is as strict as the ground between samples is.
"""

from __future__ import annotations

import math

from rota.compiled.kernel import allocation_free
from rota.model.arrays import Flags, Floats


@allocation_free
def share_out(deficit_m: Floats, towards: Floats, alone: Flags, shares: Floats) -> None:
    """Write the weights (n, 3) of the legs that see each sample, which sum up to 1.

    deficit_m (n, 3): by how much the range of each is short, the best first; inf where legs are fewer. towards
    (n, 3, 2): unit vectors from the sample. alone (n,): samples that are left to the best. Weights that balance go back
    to the best leg until their mean asks for no range that is not short.
    """
    for i in range(deficit_m.shape[0]):
        best_m = deficit_m[i, 0]
        shares[i, 0], shares[i, 1], shares[i, 2] = 1.0, 0.0, 0.0
        if alone[i] or deficit_m[i, 1] == math.inf:
            continue
        weights = balance(towards, i, 3 if deficit_m[i, 2] < math.inf else 2)
        mean_m = 0.0
        for c in range(3):
            if weights[c] > 0:
                mean_m += weights[c] * deficit_m[i, c]
        most_m, kept = max(0.0, best_m), 1.0
        if mean_m > most_m:
            kept = (most_m - best_m) / (mean_m - best_m)
        shares[i, 0] = 1 - kept
        for c in range(3):
            shares[i, c] += kept * weights[c]


@allocation_free
def balance(towards: Floats, i: int, legs: int) -> tuple[float, float, float]:
    """The weights with which the mean of unit vectors (two or three of row i) is shortest."""
    x0, y0, x1, y1 = towards[i, 0, 0], towards[i, 0, 1], towards[i, 1, 0], towards[i, 1, 1]
    if legs == 2:
        return 0.5, 0.5, 0.0
    x2, y2 = towards[i, 2, 0], towards[i, 2, 1]
    w0, w1, w2 = x1 * y2 - y1 * x2, x2 * y0 - y2 * x0, x0 * y1 - y0 * x1
    if (w0 > 0 and w1 > 0 and w2 > 0) or (w0 < 0 and w1 < 0 and w2 < 0):
        whole = w0 + w1 + w2
        return w0 / whole, w1 / whole, w2 / whole
    # they lie to one side: half of each of the two that are farthest apart
    c01, c02, c12 = x0 * x1 + y0 * y1, x0 * x2 + y0 * y2, x1 * x2 + y1 * y2
    if c01 <= c02 and c01 <= c12:
        return 0.5, 0.5, 0.0
    return (0.5, 0.0, 0.5) if c02 <= c12 else (0.0, 0.5, 0.5)

# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False
"""Compiled loops for where a piece of ground lies.

numpy's means and extremes would be compiled anew in each kernel that asks for them; these are compiled once.
"""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import kernel, noinline


@noinline
def middle_of(corners):
    """The mean (x, y) of some corners (c, 2), of which there is one at least."""
    x, y = 0.0, 0.0
    for i in range(len(corners)):
        x += corners[i, 0]
        y += corners[i, 1]
    return x / len(corners), y / len(corners)


@noinline
def box_of(corners):
    """The bounds x0, x1, y0, y1 of some corners (c, 2); inf, -inf, inf, -inf of none."""
    x0, x1, y0, y1 = math.inf, -math.inf, math.inf, -math.inf
    for i in range(len(corners)):
        x0, x1 = min(x0, corners[i, 0]), max(x1, corners[i, 0])
        y0, y1 = min(y0, corners[i, 1]), max(y1, corners[i, 1])
    return x0, x1, y0, y1


@kernel(noinline=True)
def with_room(numbers, more):
    """The numbers (n,), and after them room for so many more."""
    longer = np.empty(len(numbers) + more)
    for i in range(len(numbers)):
        longer[i] = numbers[i]
    return longer

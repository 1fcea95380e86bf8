# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loop that counts the cells in range of somebody, moment by moment."""

from __future__ import annotations

import numpy as np

from rota.compiled.kernel import kernel


@kernel
def cells_in_range(places, reaches, squares, x, y, inside):
    """How many of the cells ``inside`` (rows, columns) have their centre in range of a robot: (t,).

    places: (t, k, 2). reaches: (t, k) radius or half side, below 0 for one that takes no part. squares: (k,) whether
    the sensor is one. x: (columns,), y: (rows,) centres, evenly spaced.
    """
    moments, robots = reaches.shape
    rows, columns = inside.shape
    step = x[1] - x[0] if columns > 1 else (y[1] - y[0] if rows > 1 else 1.0)
    counts = np.zeros(moments, np.int64)
    seen = np.full(inside.shape, -1, np.int64)
    for t in range(moments):
        for k in range(robots):
            reach = reaches[t, k]
            if reach < 0:
                continue
            px, py = places[t, k, 0], places[t, k, 1]
            first, last = max(0, int((px - reach - x[0]) / step)), min(columns - 1, int((px + reach - x[0]) / step) + 1)
            low, high = max(0, int((py - reach - y[0]) / step)), min(rows - 1, int((py + reach - y[0]) / step) + 1)
            for row in range(low, high + 1):
                dy = abs(y[row] - py)
                for column in range(first, last + 1):
                    if seen[row, column] == t or not inside[row, column]:
                        continue
                    dx = abs(x[column] - px)
                    within = max(dx, dy) <= reach if squares[k] else dx * dx + dy * dy <= reach * reach
                    if within:
                        seen[row, column] = t
                        counts[t] += 1
    return counts

"""Compiled thinning of trajectories: fewer points, from which no place strays too far at its time."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free


@allocation_free
def thin(places: Any, allowed: float, kept: Any) -> None:
    """Mark the steps that are kept of each robot's places (steps, n, 2 or 3), the first and the last among them.

    kept: (steps, n) of 0 and 1, result. Straight at constant speed between kept steps, a robot is at every time within
    ``allowed`` of where it was. From each kept step on, the next is the last for which that holds, as far as an
    interval of velocities along each axis shows it.
    """
    steps, n = places.shape[0], places.shape[1]
    axes = places.shape[2]
    slack = allowed / math.sqrt(float(axes))
    for i in range(n):
        begin = 0
        kept[0, i] = 1
        while begin < steps - 1:
            x0, y0, z0 = places[begin, i, 0], places[begin, i, 1], places[begin, i, axes - 1]
            low_x, high_x, low_y, high_y = -math.inf, math.inf, -math.inf, math.inf
            low_z, high_z = -math.inf, math.inf  # in the plane, y once more
            last = begin + 1
            for k in range(begin + 1, steps):
                vx, vy = (places[k, i, 0] - x0) / (k - begin), (places[k, i, 1] - y0) / (k - begin)
                vz = (places[k, i, axes - 1] - z0) / (k - begin)
                if low_x <= vx <= high_x and low_y <= vy <= high_y and low_z <= vz <= high_z:
                    last = k
                spread = slack / (k - begin)
                low_x, high_x = max(low_x, vx - spread), min(high_x, vx + spread)
                low_y, high_y = max(low_y, vy - spread), min(high_y, vy + spread)
                low_z, high_z = max(low_z, vz - spread), min(high_z, vz + spread)
                if low_x > high_x or low_y > high_y or low_z > high_z:
                    break
            kept[last, i] = 1
            begin = last

"""Compiled thinning of trajectories: fewer points, from which no place strays too far at its time."""

from __future__ import annotations

import math
from typing import Any

from rota.planners.swarm.kernels import compiled


@compiled
def thin(places: Any, allowed: float, kept: Any) -> None:
    """Mark the steps that are kept of each robot's places (steps, n, 2), the first and the last among them.

    kept: (steps, n) of 0 and 1, result. Straight at constant speed between kept steps, a robot is at every time within
    ``allowed`` of where it was. From each kept step on, the next is the last for which that holds, as far as an
    interval of velocities along each axis shows it.
    """
    steps, n = places.shape[0], places.shape[1]
    slack = allowed / math.sqrt(2.0)
    for i in range(n):
        begin = 0
        kept[0, i] = 1
        while begin < steps - 1:
            x0, y0 = places[begin, i, 0], places[begin, i, 1]
            low_x, high_x, low_y, high_y = -math.inf, math.inf, -math.inf, math.inf
            last = begin + 1
            for k in range(begin + 1, steps):
                vx, vy = (places[k, i, 0] - x0) / (k - begin), (places[k, i, 1] - y0) / (k - begin)
                if low_x <= vx <= high_x and low_y <= vy <= high_y:
                    last = k
                spread = slack / (k - begin)
                low_x, high_x = max(low_x, vx - spread), min(high_x, vx + spread)
                low_y, high_y = max(low_y, vy - spread), min(high_y, vy + spread)
                if low_x > high_x or low_y > high_y:
                    break
            kept[last, i] = 1
            begin = last

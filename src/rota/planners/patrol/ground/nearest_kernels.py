"""Compiled loop for the nearest places of a border, as a disc or a square sensor measures distance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.compiled.kernel import kernel


@kernel(error_model="numpy")
def nearest_on_segments(points: Any, segments: Any, square: int) -> Any:
    """For each point (n, 2) the place (n, 2) on the segments (k, 4) at the least range (n,), inf when k is 0.

    Range is Euclid's distance, or with ``square`` the greater of |dx| and |dy|; of places of one range the nearest.
    """
    places = np.full(points.shape, np.nan)
    ranges = np.full(points.shape[0], np.inf)
    stops = np.empty(6)
    for p in range(points.shape[0]):
        best, near = np.inf, np.inf
        for k in range(segments.shape[0]):
            ax, ay = segments[k, 0] - points[p, 0], segments[k, 1] - points[p, 1]
            dx, dy = segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1]
            # distance is least at the foot or an end; as a square measures it, at an axis or a diagonal, too
            stops[0], stops[1], stops[2] = 0.0, 1.0, 0.0
            if dx != 0.0 or dy != 0.0:
                stops[2] = -(ax * dx + ay * dy) / (dx * dx + dy * dy)
            stops[3], stops[4], stops[5] = stops[2], stops[2], stops[2]
            if square:
                stops[3], stops[4], stops[5] = -ax / dx, -(ax - ay) / (dx - dy), -(ax + ay) / (dx + dy)
                if dx == 0.0:
                    stops[3] = 0.0
                if dx == dy:
                    stops[4] = 0.0
                if dx == -dy:
                    stops[5] = 0.0
            for stop in stops:
                t = min(1.0, max(0.0, stop))
                x, y = ax + t * dx, ay + t * dy
                away = math.sqrt(x * x + y * y)
                far = max(abs(x), abs(y)) if square else away
                if far < best - 1e-9 or (far <= best + 1e-9 and away < near):
                    best, near = min(best, far), away
                    ranges[p] = far
                    places[p, 0], places[p, 1] = points[p, 0] + x, points[p, 1] + y
                    if t == 1.0:
                        places[p, 0], places[p, 1] = segments[k, 2], segments[k, 3]
                    elif t == 0.0:
                        places[p, 0], places[p, 1] = segments[k, 0], segments[k, 1]
    return places, ranges

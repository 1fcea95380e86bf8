"""Sets of velocities by themselves: the exact centroid of one, and Algorithm 1's mean of random velocities in it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.errors import MissionError
from rota.planners.swarm.reciprocal_kernels import sample_key, sampled_mean
from rota.planners.swarm.state import Outline
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, centroid_in_disc, cut, square_round

Floats = NDArray[np.float64]


class VelocitySet:
    """Velocities no faster than a speed with v . e <= bound for every row (e_x, e_y, bound) of half_planes (m, 3).

    e are unit vectors, bounds and the speed are in metres per second; m is at most 59.
    Source: Chen et al., Sensors 18(6):1864, 2018, Eq. 9.
    """

    def __init__(self, half_planes: Floats, speed_m_s: float) -> None:
        half_planes = np.asarray(half_planes, dtype=np.float64).reshape(-1, 3)
        if not (math.isfinite(speed_m_s) and speed_m_s > 0):
            raise MissionError(f"speed_m_s: {speed_m_s!r} is not allowed; must be a finite number greater than 0")
        if len(half_planes) > MOST_CORNERS - 5 or not np.isfinite(half_planes).all():
            raise MissionError(f"half_planes: {half_planes!r} is not allowed; at most {MOST_CORNERS - 5}, all finite")
        self._speed = float(speed_m_s)
        self._outline, spare = _outline(), _outline()
        self._corners = square_round(self._speed, self._outline)
        for ex, ey, bound in half_planes:
            if self._corners:
                self._corners = cut(self._outline, self._corners, ex, ey, bound, spare)
                self._outline, spare = spare, self._outline

    def centroid(self) -> Floats | None:
        """The set's centroid (2,), in closed form; None: the set is empty."""
        if not self._corners:
            return None
        ok, x, y = centroid_in_disc(self._outline, self._corners, self._speed)
        return np.array([x, y]) if ok else None

    def sampled_centroids(self, samples: int, *, tries: int, seed: int) -> Floats:
        """Algorithm 1: means (tries, 2) of the velocities in the set, among ``samples`` random ones; nan: none was."""
        means = np.full((tries, 2), np.nan)
        if not self._corners:
            return means
        for k in range(tries):
            key = np.uint64(sample_key(seed, 0, k))
            any_inside, x, y = sampled_mean(key, samples, self._speed, self._outline, self._corners)
            if any_inside:
                means[k] = x, y
        return means


def _outline() -> Outline:
    """Room for the corners of a polygon."""
    return Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS))

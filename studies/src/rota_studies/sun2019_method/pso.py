"""Particle swarms for the partition of the frame (Sun et al. 2019, Section 4.4, Algorithm 3, Eqs. 27 and 28).

Readings. A particle's position holds the ends theta of all segments but the last, which ends where the frame began
(r(theta_m) = r(1) = r(0) = r(theta_0)); each stands for the sensor nearest to it along the frame, and ends at the same
sensor are one, so that segments can vanish. How a swarm finds the number of segments is not said: here each swarm has
a number of its own, and they are spread evenly over those that could be needed. "Updated as (24)" means Eq. 27.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota_studies.sun2019_method.mission_settings import SegmentSettings
from rota_studies.sun2019_method.pso_kernels import Cuts, Rules, Swarm, end_sensors, fly_all
from rota_studies.sun2019_stages.partition_kernels import Ring

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BINS_PER_SENSOR = 4


def swarm_partition(
    ring: Ring, share: Floats, expected: float, settings: SegmentSettings, *, segments: int | None, seed: int
) -> tuple[Ints, Floats]:
    """The best partition that the swarms find: the last sensor (m,) of each segment, and the cost by iteration.

    share: (n + 1,) of the way round at which each sensor lies. The first segment begins behind sensor 0; the last one
    ends with it. expected: about how many segments will be needed; swarms try from half to twice as many, and two more.
    segments: None, or the most ends that all swarms have. The history (iterations + 1,) begins with the random
    positions.
    """
    n = len(share) - 1
    low, high = max(1, math.floor(expected / 2)), math.ceil(2 * expected) + 2
    if segments is not None:
        low, high = segments, segments
    dimensions = np.minimum(low + np.arange(settings.swarms) % (high - low + 1), n).astype(np.int64) - 1
    most = int(dimensions.max())
    bins = BINS_PER_SENSOR * n
    nearby = np.searchsorted(share, np.arange(bins) / bins, side="right") - 1
    cuts = Cuts(share, np.clip(nearby, 0, n - 1).astype(np.int64))
    x, v, y = np.empty((3, settings.particles, most))
    swarm = Swarm(x, v, y, np.empty(settings.particles), np.empty(most), np.empty(most + 1, dtype=np.int64))
    history = np.full(settings.iterations + 1, np.inf)
    rngs = np.random.SeedSequence(seed).generate_state(settings.swarms, np.uint64) | np.uint64(1)
    position = np.empty(most)
    winner = fly_all(dimensions, cuts, ring, rules_of(settings), swarm, history, rngs.reshape(-1, 1), position)
    ends = swarm.ends.copy()
    count = end_sensors(position, dimensions[winner], cuts, ends)
    return ends[:count] % n, history


def rules_of(settings: SegmentSettings) -> Rules:
    """The settings as the kernels take them."""
    return Rules(
        iterations=settings.iterations,
        least_velocity=float(settings.velocity_min),
        most_velocity=float(settings.velocity_max),
        most_inertia=float(settings.inertia_max),
        least_inertia=float(settings.inertia_min),
        own_pull=float(settings.c1),
        swarm_pull=float(settings.c2),
        weight_late=float(settings.weight_late),
        weight_segments=float(settings.weight_segments),
        weight_early=float(settings.weight_early),
        margin_s=float(settings.margin_s),
    )

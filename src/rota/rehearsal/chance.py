"""What chance has in store for each robot in one run. It depends on no setting and no other robot."""

from __future__ import annotations

import numpy as np

from rota.live.keeping import LATE_S, LEAST_RATE
from rota.model.arrays import Floats
from rota.rehearsal.drive_kernels import Chance
from rota.rehearsal.least_times import round_shares
from rota.rehearsal.scene import HOUR_S, Scene
from rota.vehicles.motion import Wind

GUST_S = 20.0  # how long a robot's speed is off by the same: gusts at 30 m last so long at 8 m/s (MIL-F-8785C: 154 m)
MOST_SIGMAS = 3.0
LATE_RELIEFS = 1  # the stream of chance for them, beside that of everything else


def chance_of(scene: Scene, wind: Wind, seed: int, number: int, left: int = 0) -> Chance:
    """What happens to all robots in the run of this number; left: how often one has left a charger before."""
    asked, robots = scene.conditions, len(scene.plan.trajectories)
    gust = max(1, round(GUST_S / scene.tick_s))
    chances = [np.random.default_rng([seed, number, 1 + robot]) for robot in range(robots)]
    waited_s = np.array([chance.standard_exponential() for chance in chances])
    fails_s = np.full(robots, np.inf)
    if asked.failures_per_hour:
        fails_s = waited_s * (HOUR_S / asked.failures_per_hour)
    gusts = -(-scene.ticks // gust)
    slowness = np.ones((robots, gusts))
    if asked.speed_noise:
        slowness = 1 / (1 + asked.speed_noise * np.array([_normal(chance, gusts) for chance in chances]))
    late_s = np.zeros((robots, 1))
    if asked.late_relief_s:
        streams = [np.random.default_rng([seed, number, 1 + robot, LATE_RELIEFS]) for robot in range(robots)]
        most = left + max(1, *(scene.most_charges(way) for way in scene.plan))
        late_s = asked.late_relief_s * np.array([stream.standard_exponential(most) for stream in streams])
    waits_s = np.full(robots, np.inf)
    if not asked.hands_off:
        waits_s[round_shares(scene.plan, wind) * LEAST_RATE <= 1] = LATE_S
        waits_s[scene.relieves_nobody] = np.inf
    return Chance(slowness, gust, fails_s, late_s, waits_s)


def wind_of(scene: Scene, seed: int, number: int) -> Wind:
    """The wind in the run of this number."""
    asked = scene.conditions
    from_deg = asked.wind_from_deg
    if from_deg is None:
        from_deg = 360 * np.random.default_rng([seed, number, 0]).random()
    return Wind(speed_m_s=asked.wind_m_s, from_deg=from_deg)


def _normal(chance: np.random.Generator, count: int) -> Floats:
    """Normal numbers (count,) none of which is farther than ``MOST_SIGMAS`` from 0."""
    from scipy.special import ndtr, ndtri

    low, high = ndtr([-MOST_SIGMAS, MOST_SIGMAS])
    return np.asarray(ndtri(low + (high - low) * chance.random(count)))

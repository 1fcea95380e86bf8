"""One run of a rehearsal: what chance has in store for each robot, and what becomes of the demands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.live.keeping import LATE_S, LEAST_RATE
from rota.rehearsal import kernels
from rota.rehearsal.contacts import Contact, contacts_of
from rota.rehearsal.least_times import least_times_s, round_shares
from rota.rehearsal.scene import HOUR_S, Scene
from rota.vehicles.motion import Wind

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GUST_S = 20.0  # how long a robot's speed is off by the same: gusts at 30 m last so long at 8 m/s (MIL-F-8785C: 154 m)
MOST_SIGMAS = 3.0
PARTS = 48  # into which what is looked at is cut


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What became of one run.

    late_shares: (d, PARTS) for each demand the share of it that was late, in each part of the time. worst_gaps_s,
    worst_places: (d,) the longest time that some place was unseen, and which. failed: how many robots did.
    contacts: of bodies.
    """

    late_shares: Floats
    worst_gaps_s: Floats
    worst_places: Ints
    failed: int
    contacts: tuple[Contact, ...]


def rehearse_once(scene: Scene, seed: int, number: int) -> tuple[Run, Floats, Floats]:
    """The run of this number, and of each place (n,) the seconds beyond its period and the longest gap."""
    driven = drive(scene, seed, number)
    count, demands = len(scene.asked.demand), len(scene.demands)
    late, late_s, worst_s = np.zeros((demands, PARTS)), np.zeros(count), np.zeros(count)
    kernels.watch_places(scene.sights, driven, scene.asked, late, late_s, worst_s)
    order = np.lexsort((-worst_s, scene.asked.demand))
    worst_places = order[np.searchsorted(scene.asked.demand[order], np.arange(demands))]
    run = Run(
        late_shares=late * PARTS / (scene.end_s - scene.begin_s),
        worst_gaps_s=worst_s[worst_places],
        worst_places=worst_places,
        failed=int(np.count_nonzero(driven.fails_s < scene.end_s)),
        contacts=tuple(contacts_of(scene.plan, scene.pairs, driven)),
    )
    return run, late_s, worst_s


def drive(scene: Scene, seed: int, number: int) -> kernels.Driven:
    """How all robots drive in the run of this number. What chance gives a robot depends on no setting and no other."""
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
    wind = _wind(scene, seed, number)
    waits_s = np.full(robots, np.inf)
    if not asked.hands_off:
        waits_s[round_shares(scene.plan, wind) * LEAST_RATE <= 1] = LATE_S
    least_s = least_times_s(scene.plan, wind, scene.tick_s, scene.ticks)
    return kernels.Driven(
        times_s=kernels.drive(least_s, slowness, gust, fails_s, scene.tick_s, waits_s),
        tick_s=scene.tick_s,
        loops_s=np.array([way.loop_duration_s for way in scene.plan], np.float64),
        fails_s=fails_s,
        begin_s=scene.begin_s,
        end_s=scene.end_s,
    )


def _wind(scene: Scene, seed: int, number: int) -> Wind:
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

"""One run of a rehearsal: how robots drive in it, and what becomes of the demands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.rehearsal import drive_kernels, kernels
from rota.rehearsal.chance import chance_of, wind_of
from rota.rehearsal.charging import Charging, charging_of, full_batteries
from rota.rehearsal.contacts import Contact, contacts_of
from rota.rehearsal.drive_kernels import Fills
from rota.rehearsal.least_times import least_times_s
from rota.rehearsal.scene import Scene

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PARTS = 48  # into which what is looked at is cut


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What became of one run.

    late_shares: (d, PARTS) for each demand the share of it that was late, in each part of the time. worst_gaps_s,
    worst_places: (d,) the longest time that some place was unseen, and which. failed: how many robots did.
    contacts: of bodies. charging: None where nobody charges.
    """

    late_shares: Floats
    worst_gaps_s: Floats
    worst_places: Ints
    failed: int
    contacts: tuple[Contact, ...]
    charging: Charging | None


def rehearse_once(scene: Scene, seed: int, number: int) -> tuple[Run, Floats, Floats]:
    """The run of this number, and of each place (n,) the seconds beyond its period and the longest gap."""
    driven, fills = drive(scene, seed, number)
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
        charging=charging_of(scene, driven, fills) if scene.charges else None,
    )
    return run, late_s, worst_s


def drive(scene: Scene, seed: int, number: int) -> tuple[kernels.Driven, Fills]:
    """How all robots drive in the run of this number, and how full their batteries are."""
    wind = wind_of(scene, seed, number)
    chance, fills = chance_of(scene, wind, seed, number), full_batteries(scene)
    least_s = least_times_s(scene.plan, wind, scene.tick_s, scene.ticks)
    starts_s = np.zeros(len(least_s))
    times_s, _ = drive_kernels.drive(least_s, chance, scene.batteries, fills, scene.tick_s, 0, starts_s, 0.0)
    driven = kernels.Driven(
        times_s=times_s,
        tick_s=scene.tick_s,
        loops_s=np.array([way.loop_duration_s for way in scene.plan], np.float64),
        fails_s=chance.fails_s,
        begin_s=scene.begin_s,
        end_s=scene.end_s,
    )
    return driven, fills

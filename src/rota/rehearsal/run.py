"""One run of a rehearsal: how robots drive in it, and what becomes of the demands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.rehearsal import kernels
from rota.rehearsal.charging import Charging, charging_of
from rota.rehearsal.contacts import Contact, contacts_of
from rota.rehearsal.scene import Scene
from rota.rehearsal.stages import drive_in_stages, join

PARTS = 48  # into which what is looked at is cut


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What became of one run.

    late_shares: (d, PARTS) for each demand the share of it that was late, in each part of the time. worst_gaps_s,
    worst_places: (d,) the longest time that some place was unseen, and which. failed: how many robots did.
    contacts: of bodies. charging: None where nobody charges. takeovers: how many plans took over; refusal: why none did
    at last, None: where none was asked for or was refused.
    """

    late_shares: Floats
    worst_gaps_s: Floats
    worst_places: Ints
    failed: int
    contacts: tuple[Contact, ...]
    charging: Charging | None
    takeovers: int
    refusal: str | None


def rehearse_once(scene: Scene, seed: int, number: int) -> tuple[Run, Floats, Floats]:
    """The run of this number, and of each place (n,) the seconds beyond its period and the longest gap."""
    stages, refusal = drive_in_stages(scene, seed, number)
    sights, driven = join(stages)
    count, demands = len(scene.asked.demand), len(scene.demands)
    late, late_s, worst_s = np.zeros((demands, PARTS)), np.zeros(count), np.zeros(count)
    kernels.watch_places(sights, driven, scene.asked, late, late_s, worst_s)
    order = np.lexsort((-worst_s, scene.asked.demand))
    worst_places = order[np.searchsorted(scene.asked.demand[order], np.arange(demands))]
    run = Run(
        late_shares=late * PARTS / (scene.end_s - scene.begin_s),
        worst_gaps_s=worst_s[worst_places],
        worst_places=worst_places,
        failed=int(np.count_nonzero(stages[0].driven.fails_s < scene.end_s)),
        contacts=tuple(
            contact
            for stage in stages
            for contact in contacts_of(stage.scene.plan, stage.scene.pairs, stage.driven, stage.until_s)
        ),
        charging=charging_of(scene, driven, stages[-1].fills) if scene.charges else None,
        takeovers=len(stages) - 1,
        refusal=refusal,
    )
    return run, late_s, worst_s

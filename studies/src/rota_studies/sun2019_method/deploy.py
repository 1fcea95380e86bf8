"""Sensors deployed by the paper's swarms, and completed where these leave cells uncovered."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rota.model.planner_settings import setting
from rota.planners.patrol.methods.sun2019.sensors import greedy_cover
from rota_studies.sun2019_method.ccpso2 import Evolution, evolve
from rota_studies.sun2019_method.mission_settings import SensorSettings
from rota_studies.sun2019_stages.algorithms import Cover, SensorCover
from rota_studies.sun2019_stages.cells import cells_seen_from
from rota_studies.sun2019_stages.deploy import Deployment
from rota_studies.sun2019_stages.zones import CoverTask

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class History:
    """How a CCPSO2 went, before its first iteration and after each of them.

    cost: (iterations + 1,) fitness of the best deployment (Eq. 11). counts: (iterations + 1, 4) of it: sensors in
    obstacles, cells uncovered, sensors deployed, cells overlapped. completed: sensors added when it was over, for cells
    that it had left uncovered.
    """

    cost: Floats
    counts: Ints
    completed: int

    @property
    def sensors(self) -> Ints:
        """Sensors deployed, (iterations + 1,)."""
        return self.counts[:, 2]


@dataclass(frozen=True, kw_only=True)
class SwarmCover(Cover):
    """What swarms found, and how they went."""

    history: History


@dataclass(frozen=True, kw_only=True)
class DeploySettings(SensorCover, SensorSettings):
    """How sensors are deployed (Section 4.2). method: the paper's improved CCPSO2, or a set cover."""

    method: Literal["ccpso2", "greedy", "exact"] = setting("ccpso2")  # type: ignore[assignment]

    def without_rules(self) -> DeploySettings:
        """The same without the heuristic rules: the normal CCPSO2 of Figure 6b."""
        return replace(self, addition=False, movement=False, deletion=False, fusion=False)

    def cover(self, task: CoverTask, *, share: float, seed: np.random.SeedSequence) -> Cover:
        """As few sensors as the swarms find, of at most the task's share of S_MAX; a set cover likewise.

        What the CCPSO2 leaves uncovered after its last iteration a greedy cover completes, so that every cell that can
        be seen is.
        """
        if self.method != "ccpso2":
            return super().cover(task, share=share, seed=seed)
        if self.sensors_max is not None:
            sensors = max(1, int(np.ceil(self.sensors_max * share)))
        else:
            sensors = -(-3 * len(greedy_cover(task.seen_start, task.seen_item, len(task.cells))) // 2)
        return complete(task, evolve(task, self, sensors=sensors, seed=seed))


def complete(task: CoverTask, evolution: Evolution) -> SwarmCover:
    """The deployment with sensors that a greedy cover adds for the cells left uncovered."""
    seen = np.zeros(len(task.cells), dtype=bool)
    seen[cells_seen_from(evolution.positions_m, task.cells, task.ground)[1]] = True
    keep = ~seen[task.seen_item]
    of_place = np.repeat(np.arange(len(task.places_m)), np.diff(task.seen_start))[keep]
    start = np.searchsorted(of_place, np.arange(len(task.places_m) + 1))
    added = greedy_cover(start, task.seen_item[keep], len(task.cells))
    history = History(cost=evolution.cost, counts=evolution.counts, completed=len(added))
    return SwarmCover(positions_m=np.vstack([evolution.positions_m, task.places_m[added]]), history=history)


def history_of(deployment: Deployment) -> History | None:
    """The tasks' histories added up, iteration by iteration: the curve of Figures 6c, 13b and 16b; None of covers."""
    covers = [cover for zone in deployment.zones for cover in zone.covers if isinstance(cover, SwarmCover)]
    if not covers:
        return None
    return History(
        cost=np.sum([cover.history.cost for cover in covers], axis=0),
        counts=np.sum([cover.history.counts for cover in covers], axis=0),
        completed=sum(cover.history.completed for cover in covers),
    )

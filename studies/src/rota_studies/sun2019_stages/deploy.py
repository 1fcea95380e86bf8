"""Sensor deployment (Sun et al. 2019, Section 4.2): virtual sensors that cover a mission's zones, one after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota_studies.sun2019_stages.algorithms import Cover, SensorCover
from rota_studies.sun2019_stages.cells import Cells, cells_seen_from
from rota_studies.sun2019_stages.zones import ZoneTasks, virtual_radius_m, zones_to_deploy

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class ZoneDeployment:
    """The sensors of one zone.

    positions_m: (n, 2). cells: of the zone, (m,) of them; times_seen: (m,) how many of its sensors see each, 0 only for
    those that nobody can see. covers: of its tasks, one after the other.
    """

    name: str
    period_s: float
    positions_m: Floats
    cells: Cells
    times_seen: Ints
    covers: tuple[Cover, ...]


@dataclass(frozen=True, kw_only=True)
class Deployment:
    """Virtual sensors that cover all zones, in the order of their periods; the frame leads through them.

    virtual_radius_m: r_v, how far each sees; the proximity graph of Section 4.3 joins those within r_n = 2 r_v.
    """

    zones: tuple[ZoneDeployment, ...]
    virtual_radius_m: float

    @property
    def positions_m(self) -> Floats:
        """All sensors, (n, 2) metres, zone by zone."""
        return np.vstack([np.zeros((0, 2)), *(zone.positions_m for zone in self.zones)])

    @property
    def zone_of(self) -> Ints:
        """The index in ``zones`` of the zone that each sensor was deployed for, (n,); sr(s_i) of Eq. 13."""
        return np.repeat(np.arange(len(self.zones)), [len(zone.positions_m) for zone in self.zones])

    @property
    def periods_s(self) -> Floats:
        """The period of each sensor's zone, (n,) seconds; T^c(s_j) of Eq. 23."""
        return np.array([zone.period_s for zone in self.zones], dtype=np.float64)[self.zone_of]


def deploy_sensors(mission: Mission, algorithm: SensorCover | None = None, *, seed: int = 0) -> Deployment:
    """Deploy virtual sensors of radius r_v = 2 r_s that see all cells of the mission's zones (Section 4.2).

    A virtual sensor sees a cell when all corners of the cell are within r_v, not r_s, and in sight: with cells of 2.4 m
    on Figure 13 greedy set cover then takes 10/18/88 sensors (``border_cells="centre"``), where the paper's swarms took
    10/15/71; discs of r_s would be 165 or more, by the area of its free ground alone. Zones come one after the other,
    from the smallest period up; sensors of a zone stand in it, and zones already covered count as obstacles, for
    placing and for sight. The ground of a zone is cut to cells as ``border_cells`` tells (see ``cells_of``).

    Departures, where the paper says nothing: cells that cannot be seen from their own zone take sensors wherever a
    robot can stand, and only obstacles hide them; a zone that asks for visits takes one sensor inside. Cells that
    nobody can see have 0 in ``times_seen`` and cost nothing.

    algorithm: None for the greedy cover. seed: of what has chance in it; set covers have none.

    Raises MissionError for square sensors, and NoPlanFound where a robot fits nowhere, or cells would be too many.
    """
    algorithm = algorithm or SensorCover()
    zones = list(zones_to_deploy(mission, cell_m=algorithm.cell_m, border=algorithm.border_cells))
    cells = sum(len(task.cells) for zone in zones for task in zone.tasks)
    seeds = np.random.SeedSequence(seed).spawn(len(zones))
    deployed = []
    for zone, zone_seed in zip(zones, seeds, strict=True):
        covers = [
            algorithm.cover(task, share=len(task.cells) / cells, seed=own)
            for task, own in zip(zone.tasks, zone_seed.spawn(len(zone.tasks)), strict=True)
        ]
        deployed.append(_join(zone, covers))
    if not any(len(zone.positions_m) for zone in deployed):
        raise NoPlanFound("none of the ground that is asked for can be seen from anywhere a robot can stand")
    return Deployment(zones=tuple(deployed), virtual_radius_m=virtual_radius_m(mission))


def _join(zone: ZoneTasks, covers: list[Cover]) -> ZoneDeployment:
    """The covers of a zone's tasks as one, and how often its sensors see each cell."""
    times_seen = np.zeros(len(zone.cells), dtype=np.int64)
    for task, cover in zip(zone.tasks, covers, strict=True):
        items = cells_seen_from(cover.positions_m, task.cells, task.ground)[1]
        times_seen[task.number] += np.bincount(items, minlength=len(task.cells))
    spot = [] if zone.spot_m is None else [np.array([zone.spot_m])]
    return ZoneDeployment(
        name=zone.name, period_s=zone.period_s, cells=zone.cells, times_seen=times_seen, covers=tuple(covers),
        positions_m=np.vstack([np.zeros((0, 2)), *(cover.positions_m for cover in covers), *spot]),
    )  # fmt: skip

"""Sensor deployment (Sun et al. 2019, Section 4.2): virtual sensors that cover a mission's zones, one after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.planners.patrol.methods.sun2019.ccpso2 import Evolution, evolve
from rota.planners.patrol.methods.sun2019.cells import Cells, cells_seen_from
from rota.planners.patrol.methods.sun2019.cover import exact_cover, greedy_cover
from rota.planners.patrol.methods.sun2019.deploy_settings import DeploySettings
from rota.planners.patrol.methods.sun2019.zones import CoverTask, ZoneTasks, virtual_radius_m, zones_to_deploy

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
class ZoneDeployment:
    """The sensors of one zone.

    positions_m: (n, 2). cells: of the zone, (m,) of them; times_seen: (m,) how many of its sensors see each, 0 only for
    those that nobody can see. history: of the CCPSO2; None after a set cover. least: sensors below which no set of the
    exact cover's places can go, proved; None otherwise.
    """

    name: str
    period_s: float
    positions_m: Floats
    cells: Cells
    times_seen: Ints
    history: History | None
    least: int | None


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

    @property
    def history(self) -> History | None:
        """The zones' histories added up, iteration by iteration: the curve of Figures 6c, 13b and 16b."""
        parts = [zone.history for zone in self.zones if zone.history is not None]
        return _add(parts) if parts else None

    @property
    def least(self) -> int | None:
        """The proved numbers of all zones together; None unless every zone has one."""
        bounds = [zone.least for zone in self.zones]
        return None if None in bounds else sum(bound for bound in bounds if bound is not None)


def deploy_sensors(
    mission: Mission, settings: DeploySettings | None = None, *, seed: int = 0, threads: int | None = None
) -> Deployment:
    """Deploy virtual sensors of radius r_v = 2 r_s that see all cells of the mission's zones (Section 4.2).

    A virtual sensor sees a cell when all corners of the cell are within r_v, not r_s, and in sight: with cells of 2.4 m
    on Figure 13 greedy set cover then takes 10/18/88 sensors (``border_cells="centre"``), where the paper's swarms took
    10/15/71; discs of r_s would be 165 or more, by the area of its free ground alone. Zones come one after the other,
    from the smallest period up; sensors of a zone stand in it, and zones already covered count as obstacles, for
    placing and for sight. The ground of a zone is cut to cells as ``settings.border_cells`` tells (see ``cells_of``).

    Departures, where the paper says nothing: cells that cannot be seen from their own zone take sensors wherever a
    robot can stand, and only obstacles hide them; a zone that asks for visits takes one sensor inside; what the CCPSO2
    leaves uncovered after its last iteration a greedy cover completes, so that every cell that can be seen is. Cells
    that nobody can see have 0 in ``times_seen`` and cost nothing.

    settings: None for the defaults. seed: of the CCPSO2; covers have no chance in them. threads: that share the work,
    None for one a core; the outcome is the same for any number.

    Raises MissionError for square sensors, and NoPlanFound where a robot fits nowhere, or cells would be too many.
    """
    settings = settings or DeploySettings()
    zones = list(zones_to_deploy(mission, cell_m=settings.cell_m, border=settings.border_cells))
    cells = sum(len(task.cells) for zone in zones for task in zone.tasks)
    seeds = np.random.SeedSequence(seed).spawn(len(zones))
    deployed = []
    for zone, zone_seed in zip(zones, seeds, strict=True):
        parts = [
            _cover(task, settings, share=len(task.cells) / cells, seed=own, threads=threads)
            for task, own in zip(zone.tasks, zone_seed.spawn(len(zone.tasks)), strict=True)
        ]
        deployed.append(_join(zone, parts))
    if not any(len(zone.positions_m) for zone in deployed):
        raise NoPlanFound("none of the ground that is asked for can be seen from anywhere a robot can stand")
    return Deployment(zones=tuple(deployed), virtual_radius_m=virtual_radius_m(mission))


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Sensors for one task, how often they see its cells, and how they were found."""

    positions_m: Floats
    times_seen: Ints
    history: History | None
    least: int | None


def _cover(
    task: CoverTask, settings: DeploySettings, *, share: float, seed: np.random.SeedSequence, threads: int | None
) -> _Part:
    """Cover one task by the method of the settings; share: of all cells the task's, which gives its part of S_MAX."""
    history, least = None, None
    if settings.method == "exact":
        chosen, least = exact_cover(task.seen_start, task.seen_item, len(task.cells), node_limit=settings.node_limit)
        positions_m = task.places_m[chosen]
    else:
        chosen = greedy_cover(task.seen_start, task.seen_item, len(task.cells))
        positions_m = task.places_m[chosen]
    if settings.method == "ccpso2":
        most = settings.sensors_max
        sensors = -(-3 * len(chosen) // 2) if most is None else max(1, int(np.ceil(most * share)))
        evolution = evolve(task, settings, sensors=sensors, seed=seed, threads=threads)
        positions_m, history = _complete(task, evolution)
    items = cells_seen_from(positions_m, task.cells, task.ground)[1]
    times_seen = np.bincount(items, minlength=len(task.cells))
    return _Part(positions_m=positions_m, times_seen=times_seen, history=history, least=least)


def _complete(task: CoverTask, evolution: Evolution) -> tuple[Floats, History]:
    """The deployment with sensors that a greedy cover adds for the cells left uncovered."""
    seen = np.zeros(len(task.cells), dtype=bool)
    seen[cells_seen_from(evolution.positions_m, task.cells, task.ground)[1]] = True
    keep = ~seen[task.seen_item]
    of_place = np.repeat(np.arange(len(task.places_m)), np.diff(task.seen_start))[keep]
    start = np.searchsorted(of_place, np.arange(len(task.places_m) + 1))
    added = greedy_cover(start, task.seen_item[keep], len(task.cells))
    history = History(cost=evolution.cost, counts=evolution.counts, completed=len(added))
    return np.vstack([evolution.positions_m, task.places_m[added]]), history


def _join(zone: ZoneTasks, parts: list[_Part]) -> ZoneDeployment:
    """The parts of a zone as one."""
    times_seen = np.zeros(len(zone.cells), dtype=np.int64)
    for task, part in zip(zone.tasks, parts, strict=True):
        times_seen[task.number] += part.times_seen
    spot = [] if zone.spot_m is None else [np.array([zone.spot_m])]
    histories = [part.history for part in parts if part.history is not None]
    bounds = [part.least for part in parts]
    return ZoneDeployment(
        name=zone.name, period_s=zone.period_s, cells=zone.cells, times_seen=times_seen,
        positions_m=np.vstack([np.zeros((0, 2)), *(part.positions_m for part in parts), *spot]),
        history=_add(histories) if histories else None,
        least=None if None in bounds else sum(bound for bound in bounds if bound is not None) + len(spot),
    )  # fmt: skip


def _add(histories: list[History]) -> History:
    """The history of several deployments together."""
    return History(
        cost=np.sum([history.cost for history in histories], axis=0),
        counts=np.sum([history.counts for history in histories], axis=0),
        completed=sum(history.completed for history in histories),
    )

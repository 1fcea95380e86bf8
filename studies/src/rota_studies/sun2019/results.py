"""What is kept of a run: the paper's stages as printed, and what plans came to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota_studies.sun2019_method.deploy import history_of
from rota_studies.sun2019_method.partition import CostedPartition
from rota_studies.sun2019_stages.deploy import Deployment
from rota_studies.sun2019_stages.frame import Frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class ZoneSensors:
    """The virtual sensors of a zone, (n, 2) metres."""

    name: str
    period_s: float
    positions_m: Floats


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """A deployment (Algorithm 1), zone by zone in the order of the periods. cost: Eq. 11 by iteration, or None."""

    zones: tuple[ZoneSensors, ...]
    virtual_radius_m: float
    cost: Floats | None

    @property
    def positions_m(self) -> Floats:
        """All sensors, (n, 2) metres."""
        return np.vstack([np.zeros((0, 2)), *(zone.positions_m.reshape(-1, 2) for zone in self.zones)])

    @property
    def zone_of(self) -> Ints:
        """(n,) the place in ``zones`` of each sensor's zone."""
        return np.repeat(np.arange(len(self.zones)), [len(zone.positions_m) for zone in self.zones])

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(len(zone.positions_m) for zone in self.zones)


@dataclass(frozen=True, kw_only=True)
class Way:
    """A frame (Algorithm 2). order, path_m, leg_start, zone_crossings, blocked_legs, tour_length: as in ``Frame``.

    zones_m: metres of the legs that begin at sensors of each zone, in the order of the deployment. fell_at, fell_to:
    the generations at which the shortest tour became shorter, and its length there.
    """

    order: Ints
    path_m: Floats
    leg_start: Ints
    length_m: float
    tour_length: float
    zone_crossings: int
    blocked_legs: int
    zones_m: Floats
    generations: int
    fell_at: Ints
    fell_to: Floats


@dataclass(frozen=True, kw_only=True)
class Printed:
    """The paper's algorithms run to the end, and what the check says of the routes as they are.

    segment_zones: the sub-region that each segment counts for, by name. routes_m: round the segments, (k, 2) each; None
    where they are not drawn. unseen_m2, late_m2: of the ``asked_m2``, ground that they never see, and see too seldom.
    """

    sensors: Sensors
    way: Way
    partition: CostedPartition
    segment_zones: tuple[str, ...]
    verdict: str
    asked_m2: float
    unseen_m2: float
    late_m2: float
    digest: str
    routes: tuple[Trajectory, ...] | None = None

    @property
    def robots(self) -> int:
        """One for each segment."""
        return len(self.partition.first)

    @property
    def late(self) -> Ints:
        """The segments that Eq. 26 has no shorter than their period."""
        return np.flatnonzero(self.partition.times_s >= self.partition.periods_s)

    def of_zone(self, name: str) -> list[tuple[float, float]]:
        """Times and periods of a sub-region's segments, the shortest first."""
        pairs = zip(self.partition.times_s.tolist(), self.partition.periods_s.tolist(), strict=True)
        return sorted(pair for pair, zone in zip(pairs, self.segment_zones, strict=True) if zone == name)


class Loop(NamedTuple):
    """A loop of a plan: the sub-region whose period it must keep, or None; seconds of a round; how many share it."""

    zone: str | None
    duration_s: float
    robots: int

    @property
    def told(self) -> str:
        """``62.83 / 2`` is a loop that two robots share: a robot comes by every 31.4 s."""
        return f"{self.duration_s:.2f}" + ("" if self.robots == 1 else f" / {self.robots}")


@dataclass(frozen=True, kw_only=True)
class Found:
    """What planning by a method came to. robots, loops_m, worst_ratio: None where there is no plan.

    met: whether the check passes it. worst_ratio: the worst gap over its period. ways: None where it is not drawn.
    """

    met: bool
    robots: int | None
    loops_m: float | None
    worst_ratio: float | None
    lower_bound_robots: int | None
    loops: tuple[Loop, ...]
    digest: str | None
    reason: str | None = None
    ways: tuple[Trajectory, ...] | None = None

    def plan_on(self, mission: Mission) -> Plan | None:
        """The plan, to be drawn."""
        return None if self.ways is None else Plan(mission=mission, trajectories=self.ways)

    def robots_by_zone(self, names: tuple[str, ...]) -> tuple[int, ...]:
        """Robots whose loops must keep each sub-region's period."""
        return tuple(sum(loop.robots for loop in self.loops if loop.zone == name) for name in names)

    def times(self, name: str) -> list[str]:
        """Rounds of the loops of a sub-region, the shortest first, as text."""
        return [loop.told for loop in sorted(self.loops, key=lambda loop: loop.duration_s) if loop.zone == name]


class Cut(NamedTuple):
    """A partition in two numbers: its segments, and those that are late; and its cost by Eq. 28."""

    robots: int
    late: int
    cost: float


def sensors_of(deployment: Deployment) -> Sensors:
    """What is kept of a deployment."""
    zones = tuple(
        ZoneSensors(name=zone.name, period_s=zone.period_s, positions_m=zone.positions_m) for zone in deployment.zones
    )
    history = history_of(deployment)
    return Sensors(
        zones=zones, virtual_radius_m=deployment.virtual_radius_m, cost=None if history is None else history.cost
    )


def way_of(frame: Frame, zone_of: Ints, zones: int) -> Way:
    """What is kept of a frame; zone_of: (n,) of its sensors."""
    fell = np.flatnonzero(np.diff(frame.history, prepend=math.inf) < 0)
    return Way(
        order=frame.order,
        path_m=frame.path_m,
        leg_start=frame.leg_start,
        length_m=frame.length_m,
        tour_length=frame.tour_length,
        zone_crossings=frame.zone_crossings,
        blocked_legs=frame.blocked_legs,
        zones_m=np.bincount(zone_of[frame.order], weights=frame.legs_m, minlength=zones).astype(np.float64),
        generations=len(frame.history) - 1,
        fell_at=fell,
        fell_to=frame.history[fell],
    )


def cut_of(partition: CostedPartition) -> Cut:
    """What is kept of a partition that is not drawn."""
    late = int((partition.times_s >= partition.periods_s).sum())
    return Cut(robots=len(partition.first), late=late, cost=partition.cost)

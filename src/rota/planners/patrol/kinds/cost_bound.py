"""What a fleet of several kinds of robots costs at least.

Statement. A fleet with n_k robots of kind k, each at the cost c_k, cannot do what is asked

- where for some mu > 0 the sum of n_k (sweep_k + footprint_k mu) is less than that of A_z min(1 / T_z, mu) over the
  ground of the regions z, by the argument of ``area_bound``, whose windows take in what robots bring into range one by
  one, whichever kind each is of;
- where it has fewer robots than are proved necessary of a robot as good as the best of its kinds in all respects.

Both hold for the regions that ask for certain sensors by themselves, with the robots alone that have these. The bound
is the cost of the cheapest fleet that neither excludes. That batteries run low is not counted.

Fleets are looked at in the order of their costs, so that the first one that is not excluded gives the bound, and the
search may end anywhere with the cost it has come to.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.errors import MissionError, NoPlanFound
from rota.geometry.free_space import DemandedRegion
from rota.model.battery_limits import ENDLESS
from rota.model.mission import Mission, Robot, Zone
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.kinds.groups import Group
from rota.planners.patrol.tolerances import ROUNDING


@dataclass(frozen=True, kw_only=True)
class CostBound:
    """No fleet costs less than ``cost`` or has fewer than ``robots``; ``reason`` says why."""

    cost: float
    robots: int
    reason: str


@dataclass(frozen=True, kw_only=True)
class _Demands:
    """Regions that ask for the same sensors, and the kinds that have one of them."""

    regions: tuple[DemandedRegion, ...]
    kinds: tuple[int, ...]


def cost_bound(mission: Mission, groups: Sequence[Group], regions: Sequence[DemandedRegion]) -> CostBound:
    """The bound for kinds of robots. NoPlanFound where all that there may be of each kind cannot do what is asked."""
    proofs = _Proofs(mission, groups, regions)
    heap: list[tuple[float, tuple[int, ...]]] = [(0.0, (0,) * len(groups))]
    seen, cost = {heap[0][1]}, 0.0
    for _ in range(50_000):  # fleets that are looked at
        if not heap:
            raise NoPlanFound(
                f"fleet.kinds: {', '.join(f'{group.most} {group.name}' for group in groups)} cannot do what is asked,"
                " proved: give more of them"
            )
        cost, fleet = heapq.heappop(heap)
        if not proofs.exclude(fleet):
            break
        for k, group in enumerate(groups):
            more = (*fleet[:k], fleet[k] + 1, *fleet[k + 1 :])
            if more not in seen and fleet[k] < (math.inf if group.most is None else group.most):
                seen.add(more)
                heapq.heappush(heap, (sum(n * one.cost for n, one in zip(more, groups, strict=True)), more))
    return CostBound(
        cost=cost, robots=max(proofs.least_robots(range(len(groups))), 1),
        reason="of every cheaper fleet it is proved that it sees too little ground per second, or has too few robots",
    )  # fmt: skip


class _Proofs:
    """What excludes fleets of a mission's kinds."""

    def __init__(self, mission: Mission, groups: Sequence[Group], regions: Sequence[DemandedRegion]) -> None:
        self._mission, self._groups = mission, groups
        names = dict.fromkeys(region.sensors for region in regions)
        every = _Demands(regions=tuple(regions), kinds=tuple(range(len(groups))))
        self._demands = [every] + [
            _Demands(
                regions=tuple(region for region in regions if region.sensors == own),
                kinds=tuple(k for k, group in enumerate(groups) if not own or group.robot.sensor.name in own),
            )
            for own in names
            if own
        ]
        self._needed: dict[tuple[int, tuple[int, ...]], int] = {}

    def exclude(self, fleet: Sequence[int]) -> bool:
        """Whether a fleet, robots of each kind, surely cannot do what is asked."""
        for number, demands in enumerate(self._demands):
            own = tuple(k for k in demands.kinds if fleet[k])
            robots = sum(fleet[k] for k in own)
            if not robots or self._sees_too_little(demands, fleet) or robots < self._least(number, own):
                return True
        return False

    def least_robots(self, kinds: Sequence[int]) -> int:
        """Robots at least, of any of these kinds."""
        return self._least(0, tuple(kinds))

    def _sees_too_little(self, demands: _Demands, fleet: Sequence[int]) -> bool:
        """Whether robots bring too little ground into range in windows of some period's length."""
        swept = [region for region in demands.regions if region.demand == "every_point"]
        areas_m2 = np.array([self._seeable_m2[region.name] for region in swept])
        periods_s = np.array([region.period_s for region in swept])
        robots = [(fleet[k], self._groups[k].robot) for k in demands.kinds]
        for mu in 1 / np.unique(periods_s):
            asked = float(areas_m2 @ np.minimum(1 / periods_s, mu))
            seen = sum(n * (sweep_m2_s(robot) + footprint_m2(robot) * mu) for n, robot in robots)
            if seen < asked * (1 - ROUNDING):
                return True
        return False

    def _least(self, number: int, kinds: tuple[int, ...]) -> int:
        """Robots at least for the demands of this number, of robots as good as the best of these kinds."""
        if (number, kinds) not in self._needed:
            self._needed[number, kinds] = self._prove(self._demands[number], kinds)
        return self._needed[number, kinds]

    def _prove(self, demands: _Demands, kinds: tuple[int, ...]) -> int:
        """The same, anew; 1 where the ground cannot be laid out."""
        try:
            mission = self._mission_for(demands.regions, [self._groups[k].robot for k in kinds])
            return prove_bound(set_up_problem(mission), tours=False).robots
        except (MissionError, NoPlanFound):
            return 1

    def _mission_for(self, regions: Sequence[DemandedRegion], robots: Sequence[Robot]) -> Mission:
        """A mission that asks for these regions, with one of each of these robots."""
        zones = tuple(
            Zone(name=f"{k}", period_s=region.period_s, demand=region.demand, shape=region.shape)
            for k, region in enumerate(regions)
        )
        alike = self._mission.fleet
        fleet = replace(
            alike, kinds=(), start=None, battery=ENDLESS,
            robots=[replace(robot, battery=ENDLESS) for robot in robots],
        )  # fmt: skip
        return replace(self._mission, fleet=fleet, zones=zones, period_s=None, chargers=())

    @cached_property
    def _seeable_m2(self) -> dict[str, float]:
        """How much of each region, by its name, some kind of robot can surely see by itself."""
        seeable = dict.fromkeys((region.name for region in self._demands[0].regions), 0.0)
        for group in self._groups:
            regions = [region for region in self._demands[0].regions if group.serves(region)]
            try:
                problem = set_up_problem(self._mission_for(regions, [group.robot]))
            except (MissionError, NoPlanFound):
                continue
            own = surely_seeable_m2(problem.regions, problem.sure_space, problem.walls, problem.sure_robot)
            for region, area_m2 in zip(problem.regions, own, strict=True):
                name = regions[int(region.name)].name
                seeable[name] = max(seeable[name], area_m2)
        return seeable

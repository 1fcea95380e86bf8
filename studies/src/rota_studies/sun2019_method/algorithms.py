"""The paper's algorithms for the stages of the method sun2019, as a mission asks for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rota.model.planner_settings import setting
from rota.planners.patrol.planner_settings import Effort
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_method.genetic import genetic_tour
from rota_studies.sun2019_method.mission_settings import FrameSettings, Sun2019
from rota_studies.sun2019_method.partition import PartitionSettings
from rota_studies.sun2019_stages.algorithms import (
    Algorithms,
    FrameTour,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class TourSettings(FrameTour, FrameSettings):
    """How the frame is found. method: "local_search" is shorter and faster; "genetic" is the paper's Algorithm 2."""

    method: Literal["local_search", "genetic"] = setting("local_search")

    def order(self, distance: Floats, straight_m: Floats, seed: int) -> tuple[Ints, Floats]:
        """The order, and the shortest length by generation or, of the local search, by hundredth of its kicks."""
        if self.method == "local_search":
            return super().order(distance, straight_m, seed)
        return genetic_tour(
            distance, generations=self.generations, population=self.population, regroup_every=self.regroup_every,
            reversal_tries=self.reversal_tries, seed=seed,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PaperAlgorithms(Algorithms):
    """Who does the stages, where the paper's algorithms may."""

    deployments: tuple[DeploySettings, ...]
    tour: TourSettings
    partition: PartitionSettings


def algorithms_of(stages: Sun2019, effort: Effort) -> PaperAlgorithms:
    """What a mission asks for; swarms cut by the routes' lengths, which Eq. 26 asks for."""
    partition = PartitionSettings()
    if stages.partition == "pso":
        partition = PartitionSettings(method="pso", times="routes", **vars(stages.segments))
    covers = stages.covers(effort)
    return PaperAlgorithms(
        deployments=tuple(DeploySettings(method=method, **vars(stages.sensors)) for method in covers),
        tour=TourSettings(method=stages.tour, **vars(stages.frame)),
        partition=partition,
        routes=stages.routes,
    )

"""All settings of the method of Sun et al. 2019 together: the paper's tables, and ours by effort."""

from __future__ import annotations

from dataclasses import dataclass, field

from rota.errors import MissionError
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.methods.sun2019.deploy_settings import DeployMethod, DeploySettings
from rota.planners.patrol.methods.sun2019.frame_settings import PartitionSettings, TourSettings
from rota.planners.patrol.methods.sun2019.mission_settings import Sun2019
from rota.planners.patrol.methods.sun2019.route_settings import RouteSettings
from rota.planners.patrol.planner_settings import Effort, PatrolSettings

EVEN = PartitionSettings(too_few="even")
"""Our partition: exact; where robots are too few by Eq. 26, all routes are too long alike, for repair to shorten."""


@dataclass(frozen=True, kw_only=True)
class MethodSettings:
    """The settings of all stages. What the paper leaves open is told with the settings of its stage.

    deployments: each is tried, and the plan with the fewest robots stays; the paper's is one. frames: how many times,
    with different seeds, each of them is deployed and toured.
    """

    deployments: tuple[DeploySettings, ...] = (DeploySettings(method="greedy"),)
    frames: int = 1
    tour: TourSettings = field(default_factory=TourSettings)
    partition: PartitionSettings = field(default_factory=lambda: EVEN)
    route: RouteSettings = field(default_factory=RouteSettings)

    def __post_init__(self) -> None:
        if not self.deployments:
            raise MissionError("deployments: none is given; at least one is needed")
        if self.frames < 1:
            raise MissionError(f"frames: {self.frames!r} is not allowed; must be 1 or more")


# Set covers come first: greedy ones stand in rows, which makes short frames (measured on Figure 13: 110 sensors and a
# frame of 1,099 m, where swarms have 86 and 1,165 to 1,202 m; the exact cover 88 and 1,114 m).
BEST: dict[Effort, tuple[DeployMethod, ...]] = {
    "quick": ("greedy",), "normal": ("greedy", "exact"), "high": ("greedy", "exact", "ccpso2"),
}  # fmt: skip


def settings_for(planning: PatrolSettings) -> MethodSettings:
    """The settings that a mission asks for, with as much work as its effort allows; of another method the defaults."""
    stages = planning.method_settings
    return stage_settings(stages if isinstance(stages, Sun2019) else Sun2019(), planning.effort)


def stage_settings(stages: Sun2019, effort: Effort) -> MethodSettings:
    """The settings of all stages by an effort; swarms cut by the routes' lengths, which Eq. 26 asks for."""
    methods = BEST[effort] if stages.deployment == "best" else (stages.deployment,)
    partition = EVEN
    if stages.partition == "pso":
        partition = PartitionSettings(method="pso", times="routes", **vars(stages.segments))
    return MethodSettings(
        deployments=tuple(DeploySettings(method=method, **vars(stages.sensors)) for method in methods),
        frames=EFFORTS[effort].multistart.seeds,
        tour=TourSettings(method=stages.tour, **vars(stages.frame)),
        partition=partition,
        route=RouteSettings(routes=stages.routes, repairs=EFFORTS[effort].repair.rounds),
    )

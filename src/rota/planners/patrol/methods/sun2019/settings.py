"""All settings of the method of Sun et al. 2019 together: the paper's tables, and ours by effort."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from rota.errors import MissionError
from rota.planners.patrol.methods.sun2019.deploy_settings import TABLE_2, DeploySettings
from rota.planners.patrol.methods.sun2019.frame_settings import TABLE_3, TABLE_4, PartitionSettings, TourSettings
from rota.planners.patrol.methods.sun2019.route_settings import RouteSettings
from rota.planners.patrol.planner_settings import DeploymentMethod, Effort, PatrolSettings

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
BEST: dict[Effort, tuple[DeploySettings, ...]] = {
    "quick": (DeploySettings(method="greedy"),),
    "normal": (DeploySettings(method="greedy"), DeploySettings(method="exact")),
    "high": (DeploySettings(method="greedy"), DeploySettings(method="exact"), DeploySettings()),
}
FRAMES: dict[Effort, int] = {"quick": 1, "normal": 2, "high": 4}
REPAIRS: dict[Effort, int] = {"quick": 12, "normal": 20, "high": 30}


def settings_for(planning: PatrolSettings) -> MethodSettings:
    """The settings that a mission asks for, with as much work as its effort allows.

    Stages named after the paper's are done as its tables say, but that S_MAX fits the ground: Table 2's 160 sensors
    are for its own map.
    """
    stages, effort = planning.sun2019, planning.effort
    return MethodSettings(
        deployments=_deployments(stages.deployment, effort),
        frames=FRAMES[effort],
        tour=TABLE_3 if stages.tour == "genetic" else TourSettings(),
        partition=TABLE_4 if stages.partition == "pso" else EVEN,
        route=RouteSettings(routes=stages.routes, repairs=REPAIRS[effort]),
    )


def _deployments(method: DeploymentMethod, effort: Effort) -> tuple[DeploySettings, ...]:
    """The settings of the deployments that are tried."""
    if method == "best":
        return BEST[effort]
    return (replace(TABLE_2, sensors_max=None),) if method == "ccpso2" else (DeploySettings(method=method),)

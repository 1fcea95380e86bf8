"""Settings of sensor deployment by one algorithm (Sun et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from rota.model.planner_settings import setting
from rota.planners.patrol.methods.sun2019.mission_settings import SensorSettings

DeployMethod = Literal["ccpso2", "greedy", "exact"]


@dataclass(frozen=True, kw_only=True)
class DeploySettings(SensorSettings):
    """How sensors are deployed (Section 4.2), and by what.

    method: the paper's improved CCPSO2; "greedy" set cover; "exact" set cover (mixed-integer program, bounded by
    node_limit for each zone, with a proved bound; more nodes may find fewer sensors).
    """

    method: DeployMethod = setting("ccpso2")
    node_limit: int = setting(1, least=1)

    def without_rules(self) -> DeploySettings:
        """The same without the heuristic rules: the normal CCPSO2 of Figure 6b."""
        return replace(self, addition=False, movement=False, deletion=False, fusion=False)

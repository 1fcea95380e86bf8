"""Settings of the frame and of its partition by one algorithm (Sun et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rota.model.planner_settings import setting
from rota.planners.patrol.methods.sun2019.mission_settings import (
    FramePartition,
    FrameSettings,
    FrameTour,
    SegmentSettings,
)

TooFew = Literal["least_late", "even"]


@dataclass(frozen=True, kw_only=True)
class TourSettings(FrameSettings):
    """How the frame is found. method: "local_search" is shorter and faster; "genetic" is the paper's Algorithm 2."""

    method: FrameTour = setting("local_search")


@dataclass(frozen=True, kw_only=True)
class PartitionSettings(SegmentSettings):
    """How the frame is cut into segments, one robot each; by default without margin, and without joining legs.

    method: "exact" is the optimum by dynamic programming; "pso" is the paper's Algorithm 3.
    times: what Eq. 26 is taken for. "routes": the length of the closed route round the segment over the speed, as it is
    printed; the exact method then gives what Eq. 28 costs least. "estimate": twice the segment's length and 2 pi r_s,
    which needs no routes and is what our method begins with.
    too_few: what the exact method makes smallest where the segments asked for are too few to keep all periods: the sum
    of what routes are late, as Eq. 28 has it, "least_late"; or the largest share of a period, "even", for routes that
    are to be shortened all alike afterwards. Only with the estimate.
    """

    joining_legs: bool = setting(False)
    margin_s: float = setting(0.0, least=0)
    method: FramePartition = setting("exact")
    times: Literal["estimate", "routes"] = setting("estimate")
    too_few: TooFew = setting("least_late")

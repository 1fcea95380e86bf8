"""What does the stages of the method: what an algorithm of each stage takes and gives.

An algorithm is a frozen block of the settings that it runs with, and what it does with them. Ours are the classes below
themselves; others are subclasses of these, made of what a mission says by the block of settings that brings them: see
``mission_settings``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Robot
from rota.model.planner_settings import setting
from rota.planners.patrol.methods.sun2019.sensors import exact_cover, greedy_cover
from rota_studies.sun2019_stages.frame import Frame, PartFrame, radius_m
from rota_studies.sun2019_stages.local_search import locally_shortest_tour
from rota_studies.sun2019_stages.partition import Partition, partition_frame
from rota_studies.sun2019_stages.stage_settings import (
    FrameSettings,
    SegmentRoutes,
    SensorSettings,
)
from rota_studies.sun2019_stages.zones import CoverTask

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Cover:
    """The sensors of a task, (n, 2) metres; least: below which no set of its places can go, None where nobody knows."""

    positions_m: Floats
    least: int | None = None


@dataclass(frozen=True, kw_only=True)
class SensorCover(SensorSettings):
    """Stage 1, sensors that see all cells of a task; ours: a "greedy" or an "exact" set cover, by ``method``."""

    method: Literal["greedy", "exact"] = setting("greedy")

    def cover(self, task: CoverTask, *, share: float, seed: np.random.SeedSequence) -> Cover:
        """As few sensors as it finds. share: of all cells of the mission, those of the task."""
        seen = task.seen_start, task.seen_item, len(task.cells)
        chosen, least = exact_cover(*seen) if self.method == "exact" else (greedy_cover(*seen), None)
        return Cover(positions_m=task.places_m[chosen], least=least)


@dataclass(frozen=True, kw_only=True)
class FrameTour(FrameSettings):
    """Stage 2, the order in which a closed tour comes past all sensors; ours: a local search."""

    def order(self, distance: Floats, straight_m: Floats, seed: int) -> tuple[Ints, Floats]:
        """The order (n,), and the shortest length so far as the search went on, (r,).

        distance: (n, n) what is to be short; straight_m: (n, n) metres between the sensors.
        """
        kicks = self.kicks_per_waypoint
        return locally_shortest_tour(distance, nearness=straight_m, kicks_per_waypoint=kicks, seed=seed)


@dataclass(frozen=True, kw_only=True)
class FramePartition:
    """Stage 3, the frame cut into segments of a robot each; ours: exactly, by times that are estimated.

    joining_legs: whether a segment holds the leg that leads to it as well.
    """

    joining_legs: bool = False

    def route_lengths_m(self, frame: Frame, periods_s: Floats, paths: ShortestPaths, robot: Robot) -> Floats | None:
        """Metres (n, n) of the closed routes round the k + 1 waypoints from each on, asked for once; None: no need.

        periods_s: (n,) of the waypoints along the frame.
        """
        return None

    def cut(self, part: PartFrame, robot: Robot, *, segments: int | None, seed: int) -> Partition:
        """The segments, as many as are asked for, or as are needed (None)."""
        return partition_frame(
            part.legs_m, part.waypoint_periods_s, speed_m_s=robot.ground_speed_m_s, sensor_radius_m=radius_m(robot),
            segments=segments,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Algorithms:
    """Who does the stages. deployments: each is tried, and the plan with the fewest robots stays; routes: as missions
    say it.
    """

    deployments: tuple[SensorCover, ...] = (SensorCover(),)
    tour: FrameTour = FrameTour()
    partition: FramePartition = FramePartition()
    routes: SegmentRoutes = "shortened"

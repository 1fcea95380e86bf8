"""The stages one after the other: deployment, frame, partition, routes (Sun et al. 2019, Figures 11 and 12)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Mission, Robot
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.methods.sun2019.route import route_round
from rota_studies.sun2019_stages.algorithms import Algorithms, FramePartition, SensorCover
from rota_studies.sun2019_stages.deploy import Deployment, deploy_sensors
from rota_studies.sun2019_stages.frame import PartFrame, radius_m
from rota_studies.sun2019_stages.partition import Partition, route_length_m
from rota_studies.sun2019_stages.stretches import segment_line
from rota_studies.sun2019_stages.tour import find_frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Framed:
    """The first two stages: the sensors, and the frames past them, one for each part of the space."""

    deployment: Deployment
    parts: tuple[PartFrame, ...]
    seed: int


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One robot's share: its stretch of the frame, line_m (k, 2), and the closed route (n, 2) round it.

    time_s: Eq. 26, of the stretch; the route as it is driven takes another time. period_s: Eq. 23.
    """

    line_m: Floats
    route_m: Floats
    time_s: float
    period_s: float
    part: int


@dataclass(frozen=True, kw_only=True)
class Stages:
    """All four stages. partitions: of each part's frame; segments: of all of them, in their order."""

    framed: Framed
    partitions: tuple[Partition, ...]
    segments: tuple[Segment, ...]

    @property
    def load(self) -> float:
        """Times over periods by Eq. 26, on average: 1 is a robot's all."""
        return float(np.mean([segment.time_s / segment.period_s for segment in self.segments]))


def framed_sensors(
    mission: Mission, paths: ShortestPaths, deploy: SensorCover, algorithms: Algorithms, *, seed: int
) -> Framed:
    """Deploy sensors and find the frames past them. paths: of the space where the mission's robots can be."""
    deployment = deploy_sensors(mission, deploy, seed=seed)
    positions_m, zone, periods_s = deployment.positions_m, deployment.zone_of, deployment.periods_s
    parts, robot = paths.part_of(positions_m), common_robot(mission.fleet)
    frames = []
    for part in np.unique(parts).tolist():
        members = np.flatnonzero(parts == part)
        frame = find_frame(
            positions_m[members], zone[members], paths, virtual_radius_m=deployment.virtual_radius_m,
            algorithm=algorithms.tour, seed=seed,
        )  # fmt: skip
        along_s = periods_s[members][frame.order]
        frames.append(
            PartFrame(
                frame=frame,
                sensors=members,
                waypoint_periods_s=along_s,
                part=int(part),
                legs_m=frame.legs_m,
                route_lengths_m=algorithms.partition.route_lengths_m(frame, along_s, paths, robot),
            )
        )
    return Framed(deployment=deployment, parts=tuple(frames), seed=seed)


def cut_in_segments(
    framed: Framed, robot: Robot, paths: ShortestPaths, algorithms: Algorithms, *, robots: int | None = None
) -> Stages:
    """Cut the frames into segments and lead the routes round them.

    robots: how many segments in all, but at least one in each part and no more than it has sensors; None: as many as
    the partition needs. Parts with the least load give robots up first.
    """
    counts = None if robots is None else share_out(framed, robot, algorithms.partition, robots)
    partitions = [
        algorithms.partition.cut(part, robot, segments=None if counts is None else counts[k], seed=framed.seed)
        for k, part in enumerate(framed.parts)
    ]
    return Stages(
        framed=framed,
        partitions=tuple(partitions),
        segments=tuple(
            _segment(part, partition, k, robot, paths, algorithms.partition)
            for part, partition in zip(framed.parts, partitions, strict=True)
            for k in range(len(partition.first))
        ),
    )


def share_out(framed: Framed, robot: Robot, algorithm: FramePartition, robots: int) -> list[int]:
    """Robots of each part (p,), ``robots`` in all: one more where the load is greatest, one fewer where it is least."""
    if len(framed.parts) == 1:
        return [min(max(robots, 1), len(framed.parts[0].sensors))]
    needed = [algorithm.cut(part, robot, segments=None, seed=framed.seed) for part in framed.parts]
    loads = [float((partition.times_s / partition.periods_s).sum()) for partition in needed]
    counts, most = [len(partition.first) for partition in needed], [len(part.sensors) for part in framed.parts]
    while sum(counts) > robots and max(counts) > 1:
        candidates = [k for k, count in enumerate(counts) if count > 1]
        counts[min(candidates, key=lambda k: loads[k] / (counts[k] - 1))] -= 1
    while sum(counts) < robots and any(count < top for count, top in zip(counts, most, strict=True)):
        candidates = [k for k, count in enumerate(counts) if count < most[k]]
        counts[max(candidates, key=lambda k: loads[k] / counts[k])] += 1
    return counts


def measure(stages: Stages, driven_m: Floats, robot: Robot) -> Framed:
    """The frames with legs that count as long as the driven routes (m,) round their segments came to, in metres.

    The next partition then gives shorter segments where repair made routes long, and longer segments where it did not.
    """
    around_m = route_length_m(0.0, radius_m(robot))
    frames, at = [], 0
    for part, partition in zip(stages.framed.parts, stages.partitions, strict=True):
        legs_m = part.legs_m.copy()
        for k in range(len(partition.first)):
            inner = partition.places(k, len(legs_m))[:-1]
            if part.route_lengths_m is None:
                long_m, really_m = float(part.legs_m[inner].sum()), (driven_m[at] - around_m) / 2
            else:
                long_m, really_m = float(partition.times_s[k]) * robot.ground_speed_m_s, float(driven_m[at])
            if long_m > 0:
                legs_m[inner] *= np.clip(really_m / long_m, 0.5, 2.0)  # a single driven route says only so much
            at += 1
        frames.append(replace(part, legs_m=legs_m))
    return replace(stages.framed, parts=tuple(frames))


def _segment(
    part: PartFrame, partition: Partition, k: int, robot: Robot, paths: ShortestPaths, algorithm: FramePartition
) -> Segment:
    """Segment number k of a partition with the route round it."""
    line_m = segment_line(part.frame, partition, k, joining_legs=algorithm.joining_legs)
    return Segment(
        line_m=line_m,
        route_m=route_round(line_m, paths, radius_m=radius_m(robot)),
        time_s=float(partition.times_s[k]),
        period_s=float(partition.periods_s[k]),
        part=part.part,
    )

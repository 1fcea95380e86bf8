"""The frame cut by the paper's particle swarms, or exactly by what Eq. 28 costs (Sun et al. 2019, Section 4.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Robot
from rota.model.planner_settings import setting
from rota_studies.sun2019_method.cheapest_kernels import cheapest_partition
from rota_studies.sun2019_method.mission_settings import SegmentSettings
from rota_studies.sun2019_method.pso import rules_of, swarm_partition
from rota_studies.sun2019_method.pso_kernels import cost_of
from rota_studies.sun2019_method.route_lengths import route_lengths_m, segment_lengths_m
from rota_studies.sun2019_stages.algorithms import FramePartition
from rota_studies.sun2019_stages.frame import Frame, PartFrame, radius_m
from rota_studies.sun2019_stages.partition import Partition, exact_partition, ring_of, segments_of
from rota_studies.sun2019_stages.partition_kernels import Ring

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class CostedPartition(Partition):
    """Segments of a frame, and what they cost.

    excess_s: (m,) by how much the time exceeds the period, 0 where it does not (the margin is not counted). cost: Eq.
    28. history: the lowest cost by iteration of the particle swarms, beginning with their random positions; of the
    exact method only the cost.
    """

    excess_s: Floats
    cost: float
    history: Floats


@dataclass(frozen=True, kw_only=True)
class PartitionSettings(SegmentSettings, FramePartition):
    """How the frame is cut into segments, one robot each; by default without margin, and without joining legs.

    method: "exact" is the optimum by dynamic programming; "pso" is the paper's Algorithm 3.
    times: what Eq. 26 is taken for. "routes": the length of the closed route round the segment over the speed, as it is
    printed; the exact method then gives what Eq. 28 costs least. "estimate": twice the segment's length and 2 pi r_s,
    which needs no routes.
    """

    joining_legs: bool = setting(False)
    margin_s: float = setting(0.0, least=0)
    method: Literal["exact", "pso"] = setting("exact")
    times: Literal["estimate", "routes"] = setting("estimate")

    def route_lengths_m(self, frame: Frame, periods_s: Floats, paths: ShortestPaths, robot: Robot) -> Floats | None:
        """Metres round every stretch of the frame, where times are those."""
        if self.times == "estimate":
            return None
        return route_lengths_m(
            frame, periods_s, paths, speed_m_s=robot.ground_speed_m_s, radius_m=radius_m(robot),
            joining_legs=self.joining_legs,
        )  # fmt: skip

    def cut(self, part: PartFrame, robot: Robot, *, segments: int | None, seed: int) -> CostedPartition:
        """The frame of one part cut into segments, as many as given or needed."""
        lengths_m = part.route_lengths_m
        if lengths_m is not None and part.legs_m is not part.frame.legs_m:
            counted_m, really_m = (
                segment_lengths_m(legs_m, joining_legs=self.joining_legs) for legs_m in (part.legs_m, part.frame.legs_m)
            )
            lengths_m = lengths_m * np.divide(counted_m, really_m, out=np.ones_like(counted_m), where=really_m > 0)
        return cut_frame(
            part.legs_m, part.waypoint_periods_s, speed_m_s=robot.ground_speed_m_s, sensor_radius_m=radius_m(robot),
            segments=segments, route_lengths_m=lengths_m, settings=self, seed=seed,
        )  # fmt: skip


def cut_frame(
    legs_m: Floats,
    waypoint_periods_s: Floats,
    *,
    speed_m_s: float,
    sensor_radius_m: float,
    settings: PartitionSettings,
    segments: int | None = None,
    route_lengths_m: Floats | None = None,
    seed: int = 0,
) -> CostedPartition:
    """Cut a closed frame into segments; arguments and errors as ``partition_frame`` of rota has them.

    route_lengths_m: (n, n) of the closed route round the k + 1 waypoints from each on; None: estimated by their
    lengths. seed: of the particle swarms, whose best partition is as good as they find, by Eq. 28.

    With route lengths the exact method gives the partition that Eq. 28 costs least. Without them it gives the fewest
    segments, the margin counted, of which the largest share of a period is the smallest.
    """
    ring = ring_of(legs_m, waypoint_periods_s, speed_m_s, sensor_radius_m)._replace(joining=int(settings.joining_legs))
    n = len(legs_m)
    if segments is not None and not 1 <= segments <= n:
        raise ValueError(f"segments: {segments!r} is not allowed; must be from 1 to the number of waypoints, {n}")
    if route_lengths_m is not None:
        ring = ring._replace(route_s=checked_lengths(route_lengths_m, n) / speed_m_s)
    if settings.method == "pso":
        legs, periods = np.asarray(legs_m, dtype=np.float64), np.asarray(waypoint_periods_s, dtype=np.float64)
        expected = float(((legs + np.roll(legs, 1)) / (speed_m_s * periods)).sum())
        last, history = swarm_partition(
            ring, termination_shares(legs), expected, settings, segments=segments, seed=seed
        )
        return with_cost((np.roll(last, 1) + 1) % n, ring, settings, history)
    if route_lengths_m is not None:
        return with_cost(_cheapest(ring, settings, segments), ring, settings, None)
    later = ring._replace(around_m=ring.around_m + settings.margin_s * ring.speed_m_s)
    return with_cost(exact_partition(later, segments), ring, settings, None)


def checked_lengths(route_lengths_m: Floats, n: int) -> Floats:
    """Lengths (n, n) of routes as the kernels want them; ValueError for other shapes and what is not above 0."""
    routes_m = np.ascontiguousarray(route_lengths_m, dtype=np.float64)
    if not (routes_m.shape == (n, n) and (np.isfinite(routes_m) & (routes_m > 0)).all()):
        raise ValueError(
            f"route_lengths_m: shape {routes_m.shape} or a value is not allowed; must be ({n}, {n}) finite numbers "
            "greater than 0"
        )
    return routes_m


def normalised_lengths(legs_m: Floats) -> Floats:
    """Eqs. 20 and 21: each leg (n,) as a share of the whole frame; equal shares where the frame has no length."""
    whole_m = float(legs_m.sum())
    return np.asarray(legs_m / whole_m) if whole_m > 0 else np.full(len(legs_m), 1 / len(legs_m))


def termination_shares(legs_m: Floats) -> Floats:
    """Eq. 22: the share of the frame (n + 1,) at which each sensor lies, and 1 where the first sensor comes again.

    We read the sum up to the leg that leads to sensor K, since r(theta_i) = p(s_K). As printed it has one leg more.
    """
    shares = np.concatenate([[0.0], np.cumsum(normalised_lengths(legs_m))])
    shares[-1] = 1.0
    return shares


def _cheapest(ring: Ring, settings: PartitionSettings, segments: int | None) -> Ints:
    """The first waypoints (m,) of the partition that Eq. 28 costs least."""
    n = len(ring.level) - 1
    layers = segments or 0
    price, first = np.empty((n, n)), np.empty(n, dtype=np.int64)
    cost, chosen = np.empty((layers + 1, n + 1)), np.zeros((layers + 1, n + 1), dtype=np.int64)
    count = cheapest_partition(layers, rules_of(settings), ring, price, cost, chosen, first)
    return np.sort(first[:count])


def with_cost(first: Ints, ring: Ring, settings: PartitionSettings, history: Floats | None) -> CostedPartition:
    """The partition with these first waypoints (m,), and what it costs."""
    found, rules = segments_of(first, ring), rules_of(settings)
    late_s = (found.times_s - found.periods_s + settings.margin_s).tolist()
    cost = float(sum(cost_of(late, rules) for late in late_s))
    return CostedPartition(
        **vars(found),
        excess_s=np.maximum(0.0, found.times_s - found.periods_s),
        cost=cost,
        history=np.array([cost]) if history is None else history,
    )

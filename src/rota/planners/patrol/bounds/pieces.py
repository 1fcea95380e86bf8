"""Connected pieces of ground, and groups of pieces that lie near each other: what proofs over far ground look at."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from rota.geometry.free_space import DemandedRegion
from rota.model.mission import Robot
from rota.planners.patrol.bounds.forest_bound import shortest_tree
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Connected pieces of ground: area_m2 (n,) surely seeable, period_s (n,), straight distances away_m (n, n)."""

    area_m2: Floats
    period_s: Floats
    away_m: Floats

    def __len__(self) -> int:
        return len(self.area_m2)


def ground_pieces(regions: Sequence[DemandedRegion], seeable_m2: Sequence[float]) -> Pieces:
    """The largest connected pieces of the regions that must be seen point by point.

    seeable_m2: for each region the area that can surely be seen. What cannot be is taken from each of its pieces.
    """
    largest: list[tuple[float, float, Polygon]] = []
    for region, area in zip(regions, seeable_m2, strict=True):
        if region.demand == "every_point":
            lost = region.shape.area - area
            largest += [(p.area - lost, region.period_s, p) for p in region.shape.geoms if p.area > lost]
    largest = sorted(largest, key=lambda piece: -piece[0] / piece[1])[:60]
    shapes = np.array([shape for _, _, shape in largest], dtype=object)
    away = np.zeros((len(largest), len(largest)))
    for i in range(len(largest)):
        away[i, i + 1 :] = shapely.distance(shapes[i], shapes[i + 1 :])
    return Pieces(
        area_m2=np.array([area for area, _, _ in largest]),
        period_s=np.array([period for _, period, _ in largest]),
        away_m=away + away.T,
    )


def groupings(pieces: Pieces, robot: Robot) -> Iterator[tuple[list[Ints], Floats]]:
    """Groups of pieces, and the least distances gaps_m (m, m) between places in range of two of the groups.

    For each period the pieces with that or a shorter one are grouped by single linkage, at several thresholds.
    Each group is an array of numbers of pieces.
    """
    for period_s in np.unique(pieces.period_s):
        asked = np.flatnonzero(pieces.period_s <= period_s)
        for label in _linkages(pieces.away_m[np.ix_(asked, asked)]):
            groups = [asked[label == k] for k in range(int(label.max()) + 1)]
            yield groups, _gaps(pieces, groups, robot)


def most_seen_m2(robot: Robot, window_s: Floats | float) -> Floats | float:
    """The most ground in m2 that one robot can have in range within a window."""
    return sweep_m2_s(robot) * window_s + footprint_m2(robot)


def _linkages(away_m: Floats) -> Iterator[Ints]:
    """Labels (n,) from 0 on of single linkage clusters, at thresholds from 0 up; away_m: (n, n)."""
    first, second, length = shortest_tree(away_m)
    steps = np.unique(np.append(0.0, length))
    most = 12
    if len(steps) > most:
        steps = steps[np.unique(np.linspace(0, len(steps) - 1, most).astype(np.int64))]
    for step in steps:
        label = np.arange(len(away_m))
        for a, b in zip(first[length <= step], second[length <= step], strict=True):
            label[label == label[b]] = label[a]
        yield np.unique(label, return_inverse=True)[1]


def _gaps(pieces: Pieces, groups: Sequence[Ints], robot: Robot) -> Floats:
    """(m, m) metres between places in range of two groups, at least."""
    gaps = np.zeros((len(groups), len(groups)))
    for i, one in enumerate(groups):
        for j, other in enumerate(groups[:i]):
            away = pieces.away_m[np.ix_(one, other)].min()
            gaps[i, j] = gaps[j, i] = max(0.0, away - 2 * robot.sensor.reach_m)
    return gaps

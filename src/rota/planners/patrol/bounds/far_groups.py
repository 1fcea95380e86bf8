"""Lower bounds from pieces of ground that lie far apart: robots of their own for each, or long ways between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from rota.geometry.free_space import DemandedRegion
from rota.mission import Robot
from rota.planners.patrol.bounds.apart_bound import SURELY, heaviest_clique, shortest_tree, too_far_apart
from rota.planners.patrol.bounds.area_bound import footprint_m2, sweep_m2_s

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_PIECES, MOST_LINKS = 60, 12


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Connected pieces of ground: area_m2 (n,) that can be seen, at least, period_s (n,), away_m (n, n) straight."""

    area_m2: Floats
    period_s: Floats
    away_m: Floats

    def __len__(self) -> int:
        return len(self.area_m2)


def ground_pieces(regions: Sequence[DemandedRegion], seeable_m2: Sequence[float]) -> Pieces:
    """The largest connected pieces of the regions that must be seen point by point.

    seeable_m2: area of each region that can be seen, at least; all that cannot be is taken from each of its pieces.
    """
    found: list[tuple[float, float, Polygon]] = []
    for region, area in zip(regions, seeable_m2, strict=True):
        if region.demand == "every_point":
            lost = region.shape.area - area
            found += [(p.area - lost, region.period_s, p) for p in region.shape.geoms if p.area > lost]
    found = sorted(found, key=lambda piece: -piece[0] / piece[1])[:MOST_PIECES]
    shapes = np.array([shape for _, _, shape in found], dtype=object)
    away = np.zeros((len(found), len(found)))
    for i in range(len(found)):
        away[i, i + 1 :] = shapely.distance(shapes[i], shapes[i + 1 :])
    return Pieces(
        area_m2=np.array([area for area, _, _ in found]),
        period_s=np.array([period for _, period, _ in found]),
        away_m=away + away.T,
    )


def groups_of_their_own(pieces: Pieces, robot: Robot) -> tuple[int, int]:
    """Robots at least, since no robot can serve two of several groups of pieces: their number, and how many groups.

    Groups are made by joining what is near (single linkage, several thresholds); ground in between may be left out. A
    group needs ceil(A / (sweep T + footprint)) robots within any window of its longest period T, and robots that serve
    one group within windows of one common middle cannot serve another (``too_far_apart``).
    """
    best = (0, 0)
    for asked in _by_period(pieces):
        for label in _linkages(pieces.away_m[np.ix_(asked, asked)]):
            groups = [asked[label == k] for k in range(int(label.max()) + 1)]
            areas = np.array([pieces.area_m2[g].sum() for g in groups])
            periods = np.array([pieces.period_s[g].max() for g in groups])
            each = np.maximum(1, np.ceil(areas / _window_m2(robot, periods) / SURELY)).astype(np.int64)
            clique = heaviest_clique(too_far_apart(_gaps(pieces, groups, robot), periods, robot.speed_m_s), each)
            best = max(best, (int(each[clique].sum()), len(clique)))
    return best


def swept_and_travelled(pieces: Pieces, robot: Robot) -> tuple[int, float]:
    """Robots at least, since in any window robots sweep all ground and travel between its groups; and the window (s).

    A robot's path within a window T visits groups one after the other, and sees nothing that counts on the way between
    two. A visit of length l sees at most s l + h (sweep s per metre, footprint h). With k robots, groups of area A in
    all, and the m - k or more ways of lengths d between visits, k (s V T + h) >= A + sum of (s d - h). Groups nearer
    than h / s are joined, so that no further visit helps, and the ways hold a forest of at most k trees over the
    groups.
    """
    per_metre = sweep_m2_s(robot) / robot.speed_m_s
    near_m = footprint_m2(robot) / per_metre
    best = (0, 0.0)
    for asked in _by_period(pieces):
        window_s = float(pieces.period_s[asked].max())
        for label in _linkages(pieces.away_m[np.ix_(asked, asked)], at_least_m=near_m + 2 * robot.sensor.reach_m):
            groups = [asked[label == k] for k in range(int(label.max()) + 1)]
            gaps = np.maximum(0.0, _gaps(pieces, groups, robot) - near_m)
            ways = np.sort(shortest_tree(gaps)[2])
            area, capacity = pieces.area_m2[asked].sum(), float(_window_m2(robot, window_s)) * SURELY
            robots = 1
            while area + per_metre * ways[: max(0, len(groups) - robots)].sum() > robots * capacity:
                robots += 1
            best = max(best, (robots, window_s))
    return best


def _window_m2(robot: Robot, window_s: Floats | float) -> Floats | float:
    return sweep_m2_s(robot) * window_s + footprint_m2(robot)


def _by_period(pieces: Pieces) -> Iterable[Ints]:
    """For each period the pieces with that or a shorter one."""
    for period in np.unique(pieces.period_s):
        yield np.flatnonzero(pieces.period_s <= period)


def _linkages(away_m: Floats, at_least_m: float = 0.0) -> Iterable[Ints]:
    """Labels (n,) from 0 on of single linkage clusters, at thresholds from ``at_least_m`` up."""
    one, other, length = shortest_tree(away_m)
    steps = np.unique(np.concatenate([[at_least_m], length[length > at_least_m]]))
    if len(steps) > MOST_LINKS:
        steps = steps[np.unique(np.linspace(0, len(steps) - 1, MOST_LINKS).astype(np.int64))]
    for step in steps:
        label = np.arange(len(away_m))
        for a, b in zip(one[length <= step], other[length <= step], strict=True):
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

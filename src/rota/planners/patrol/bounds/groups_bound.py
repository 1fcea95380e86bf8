"""Robots at least, since no robot can serve two of several groups of ground, and each group takes robots of its own.

Statement. Let groups of ground be pairwise too far apart, as in ``clique_bound``, with T the longest period within a
group and A its area. The team has at least the sum of ceil(A / (sweep T + footprint)) over the groups.

Proof. Within a window of T all of a group comes into range, and one robot has sweep T + footprint of ground in range
at most (``area_bound``). Robots that serve one group within windows of one middle cannot serve another.

Groups are made by joining what is near, and ground in between may be left out.
"""

from __future__ import annotations

import numpy as np

from rota.model.mission import Robot
from rota.planners.patrol.bounds.clique_bound import heaviest_clique, too_far_apart, too_far_apart_reason
from rota.planners.patrol.bounds.pieces import Pieces, groupings, most_seen_m2
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.tolerances import SURELY


def groups_bound(pieces: Pieces, robot: Robot) -> ProvedBound:
    """The best of all groupings; of equal ones that with the most groups."""
    best = (0, 0)
    for groups, gaps_m in groupings(pieces, robot):
        areas_m2 = np.array([pieces.area_m2[group].sum() for group in groups])
        periods_s = np.array([pieces.period_s[group].max() for group in groups])
        each = np.maximum(1, np.ceil(areas_m2 / most_seen_m2(robot, periods_s) / SURELY)).astype(np.int64)
        clique = heaviest_clique(too_far_apart(gaps_m, periods_s, robot.ground_speed_m_s), each)
        best = max(best, (int(each[clique].sum()), len(clique)))
    robots, groups_apart = best
    if robots == groups_apart:
        return ProvedBound(robots=robots, reason=too_far_apart_reason(groups_apart))
    return ProvedBound(
        robots=robots,
        reason=f"{groups_apart} pieces of ground are too far apart for one robot to serve two"
        " of them, and each takes robots of its own",
    )

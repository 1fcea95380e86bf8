"""Robots at least, since in any window they sweep all ground and travel between its groups.

Statement. Let m groups of ground have areas that sum up to A, with periods of at most T, and let d_1, d_2, ... be the
edges of the shortest tree over the groups, each less by footprint / s, in ascending order; s = sweep / V is what a
robot sweeps per metre. A team of k robots has k (sweep T + footprint) >= A + s (d_1 + ... + d_{m - k}).

Proof. Within a window of T the path of a robot visits groups one after the other, and sees nothing that counts on the
way between two. A visit of length l sees at most s l + footprint. There are m - k or more ways between visits, and they
hold a forest of at most k trees over the groups. Groups nearer than footprint / s are joined before, so that no further
visit helps.
"""

from __future__ import annotations

import numpy as np

from rota.mission import Robot
from rota.planners.patrol.bounds.clique_bound import SURELY
from rota.planners.patrol.bounds.forest_bound import shortest_tree
from rota.planners.patrol.bounds.pieces import Pieces, groupings, seen_within_m2
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s


def sweep_and_travel_bound(pieces: Pieces, robot: Robot) -> ProvedBound:
    """The best of all groupings; of equal ones that with the longest window."""
    per_metre = sweep_m2_s(robot) / robot.speed_m_s
    near_m = footprint_m2(robot) / per_metre
    best = (0, 0.0)
    for groups, gaps_m in groupings(pieces, robot, from_m=near_m + 2 * robot.sensor.reach_m):
        asked = np.sort(np.concatenate(groups))
        window_s = float(pieces.period_s[asked].max())
        ways_m = np.sort(shortest_tree(np.maximum(0.0, gaps_m - near_m))[2])
        area_m2, capacity_m2 = pieces.area_m2[asked].sum(), float(seen_within_m2(robot, window_s)) * SURELY
        robots = 1
        while area_m2 + per_metre * ways_m[: max(0, len(groups) - robots)].sum() > robots * capacity_m2:
            robots += 1
        best = max(best, (robots, window_s))
    robots, window_s = best
    return ProvedBound(
        robots=robots,
        reason=f"within any {window_s:.6g} s they must sweep ground in several places and travel between these",
    )

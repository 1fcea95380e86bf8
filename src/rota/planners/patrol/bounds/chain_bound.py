"""Robots at least, since of places in a row none can be left for its period by a robot that serves the next.

Statement. Let a height be any function of place that changes by at most a metre per metre of travel. Whoever serves
point p stands at a height in [low_p, high_p], once in every window of p's period T_p. Begin with b = -infinity, and
as long as some point has low_p > b, replace b by the least high_p + V T_p / 2 of all such points. The team has at least
as many robots as there are steps.

Proof. Number the robots at each instant from the lowest to the highest. The height of the k-th changes by at most the
speed V per second, too. Let robots 1 to k never rise above b. A point with low_p > b is served by robots of higher
number only. So robot k + 1 is at or below high_p once in every window of T_p, and never above high_p + V T_p / 2.

Heights are the ways from one of the places, their negatives, and coordinates along straight lines.
"""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.witness_points import MOST_LOOKED_AT
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tolerances import ROUNDING

DIRECTIONS = 16  # of such lines


def chain_bound(way_m: Floats, spread_m: Floats, period_s: Floats, speed_m_s: float) -> ProvedBound:
    """The best chain along the ways way_m (n, n) from one of the centres; see ``best_chain``."""
    return _proof(best_chain(way_m, spread_m, period_s, speed_m_s))


def straight_chain_bound(problem: Problem, robot: Robot) -> ProvedBound:
    """The best chain of the problem's lattice points along straight lines, whatever lies between them."""
    points = problem.points
    lattice = np.flatnonzero((points.visit_m == 0) & (points.shrink_m > 0))
    some = lattice[:: max(1, len(lattice) // MOST_LOOKED_AT)]
    period_s = np.array(problem.periods_s)[points.period[some]]
    return _proof(straight_chain(points.xy_m[some], robot.sensor.reach_m, period_s, robot.ground_speed_m_s))


def _proof(robots: int) -> ProvedBound:
    reason = f"of {robots} places in a row none can be left for its period by a robot that serves the next"
    return ProvedBound(robots=robots, reason=reason)


def chain_robots(low_m: Floats, high_m: Floats, period_s: Floats, speed_m_s: float) -> tuple[int, float]:
    """The length of the greedy chain, and the height above which none of its robots ever rises.

    low_m, high_m: (n,) metres, the heights from which a point is served; period_s: (n,).
    """
    order = np.argsort(low_m)
    low_s = low_m[order].tolist()
    # the least ceiling of all points that are served from no lower than each
    ceilings_m = np.minimum.accumulate((high_m + speed_m_s * period_s / 2)[order][::-1])[::-1].tolist()
    robots, below_m, first = 0, -math.inf, 0
    while first < len(low_s):
        robots, below_m = robots + 1, ceilings_m[first]
        first = bisect_right(low_s, below_m + ROUNDING * abs(below_m))
    return robots, below_m


def best_chain(way_m: Floats, spread_m: Floats, period_s: Floats, speed_m_s: float) -> int:
    """The longest chain whose heights are the ways from one of the centres, or their negatives.

    way_m: (n, n) ways between the centres, all finite; spread_m: (n,) how far from its centre a point is served.
    """
    most = 0
    for way in way_m:
        for height in (way, -way):
            most = max(most, chain_robots(height - spread_m, height + spread_m, period_s, speed_m_s)[0])
    return most


def straight_chain(xy_m: Floats, reach_m: float, period_s: Floats, speed_m_s: float) -> int:
    """The longest chain of points xy_m (n, 2), each served from within reach_m, along one of ``DIRECTIONS``."""
    most = 0
    for angle in np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        along = xy_m @ np.array([np.cos(angle), np.sin(angle)])
        for height in (along, -along):
            most = max(most, chain_robots(height - reach_m, height + reach_m, period_s, speed_m_s)[0])
    return most

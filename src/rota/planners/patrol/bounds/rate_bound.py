"""How many robots sweeping takes at least: every point weighs what its own period lets a robot earn, not the shortest.

Weigh demanded points by w(p) >= 0. Let f(p) be the share of time in which p is in range of some robot and e(p) how
often per second it comes into range. Gaps last T(p) at most, so 1 - f <= e T, and the integral of w is at most that of
w T e + w f: what the robots earn per second by bringing ground into range and by holding it there. If no robot can ever
earn more than 1, the integral of w is a lower bound on the number of robots.

A disc of radius r at x that moves at speed V brings in at most g = w T along its rim: since what comes in also leaves,
half the flow through the whole rim, (r V / 2) * integral of g |cos| over the rim, and it holds the integral of w over
the disc. With G = 2 r V w T and H = pi r^2 w it earns (mean of G over the rim, weighted with |cos|) + (mean of H over
the disc). Where one period T rules, w = 1 / (2 r V T + pi r^2) gives G + H = 1. Where periods meet, rim and disc see
different shares of them, and ground of the longer period near a shorter one must weigh a little less:

    G(p) = G_c - sum over shorter classes j of (G_{j+1} - G_j) (1 - psi(d_j(p) / r)),   G_c = G of class c alone,

with d_j(p) the distance to K_j, the ground of class j and of shorter periods, is enough. For that psi must satisfy, for
every set K and every disc, (mean of psi(d_K / r) over the rim) <= (share of the disc outside K), psi = 0 on K; then rim
and disc earn at most 1 together, the terms with K_j cancelling one by one. ``rim_share`` gives such a psi:

- along the ray from a rim point with d_K = s r <= r towards the centre the first s r metres lie outside K, and
  |cos| <= 1, so (4 / pi)(s - s^2 / 2) will do up to s = 1, and the 2 / pi reached there beyond it too;
- the part of the disc within s r of the rim point farthest from K lies outside K: its share bounds psi at that point.

A psi that is at each s one of the two, the first up to some s0 and the second beyond, where it is larger, will do as
well: if no rim point lies beyond s0 the first argument holds for all of them, otherwise the second, as psi grows.
For a square of side a the rim counts sqrt(2) a V at most, and the second argument alone is used, for its corner.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Robot
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s


def swept_robots(
    shapes: Sequence[MultiPolygon], lost_m2: Sequence[float], periods_s: Sequence[float], robot: Robot
) -> tuple[float, float]:
    """Robots at least, not rounded: the sum of A / (sweep T + footprint) over the ground, less what borders cost.

    Also the area per second (m2/s) that they are asked to see.

    shapes (k,): disjoint ground to be seen, lost_m2 (k,): how much of each nobody can see, at most, periods_s (k,).
    0 when nothing is asked. Periods may count as longer ones, which never asks more. Source: the areas' rate argument
    of Sun et al. 2019, sharpened as this module tells.
    """
    periods = sorted(set(periods_s))
    ground = [
        shapely.union_all([s for s, t in zip(shapes, periods_s, strict=True) if t == period]) for period in periods
    ]
    areas = np.array([sum(s.area for s, t in zip(shapes, periods_s, strict=True) if t == p) for p in periods])
    lost = np.array([sum(m2 for m2, t in zip(lost_m2, periods_s, strict=True) if t == p) for p in periods])
    lost = np.minimum(lost, areas)
    if not periods:
        return 0.0, 0.0
    return _best_merging(np.array(periods), areas, lost, _border_areas(ground, robot), robot)


def _best_merging(
    periods_s: Floats, areas_m2: Floats, lost_m2: Floats, border_m2: Floats, robot: Robot
) -> tuple[float, float]:
    """The most that is earned, and asked per second, when periods may count as the next longer one, greedily chosen.

    Little ground with a period of its own can cost more at its borders than it weighs.
    """
    last = np.arange(len(periods_s))  # of each class the one whose period it counts with
    best = _earnings(periods_s, areas_m2, lost_m2, border_m2, robot)
    while True:
        tries = [np.where(last == c, last[c + 1], last) for c in np.unique(last)[:-1]]
        earned = [_earnings(periods_s[merged], areas_m2, lost_m2, border_m2, robot) for merged in tries]
        if not earned or max(earned) <= best:
            return best, float(((areas_m2 - lost_m2) / periods_s[last]).sum())
        best, last = max(earned), tries[int(np.argmax(earned))]


def _earnings(periods_s: Floats, areas_m2: Floats, lost_m2: Floats, border_m2: Floats, robot: Robot) -> float:
    """The integral of the weights; border_m2 (k, k): that of 1 - psi(distance to K_j) over ground c, for j < c."""
    swept_m2 = sweep_m2_s(robot) * periods_s
    share = swept_m2 / (swept_m2 + footprint_m2(robot))
    steps = np.diff(share, append=share[-1:])
    total = 0.0
    for c in range(len(periods_s)):
        kept = max(0.0, (areas_m2[c] - lost_m2[c]) * share[c] - float(steps[:c] @ border_m2[:c, c]))
        total += kept / swept_m2[c]
    return total


def _border_areas(ground: Sequence[MultiPolygon], robot: Robot) -> Floats:
    """(k, k): an upper estimate of the integral, over ground c, of 1 - psi(distance to ground 0..j), for j < c."""
    k = len(ground)
    border_m2 = np.zeros((k, k))
    reach_m, full_m = _reach_and_full(robot)
    pairs = k * (k - 1) // 2
    rings = int(np.clip(240 // max(pairs, 1), 4, 40))  # overlays of widened ground in all
    at_m = np.linspace(0.0, full_m, rings + 1)
    gain = np.diff(np.array([rim_share(s / reach_m, robot) for s in at_m]))
    for j in range(k - 1):
        urgent = shapely.union_all(ground[: j + 1])
        wide = _widen(urgent, full_m)
        near = [shapely.intersection(wide, other) for other in ground[j + 1 :]]
        for i in range(rings):
            grown = _widen(urgent, float(at_m[i + 1]))
            border_m2[j, j + 1 :] += gain[i] * np.array([shapely.intersection(grown, part).area for part in near])
    return border_m2


def _widen(shape: MultiPolygon, by_m: float) -> MultiPolygon:
    """A shape that holds all points within ``by_m`` metres of this one."""
    corners = 16  # of a quarter of a circle, which contains the true one
    return shapely.buffer(shape, by_m / math.cos(math.pi / (4 * corners)), quad_segs=corners)


def _reach_and_full(robot: Robot) -> tuple[float, float]:
    """The length that distances are measured in, and the distance from which on psi is 1."""
    if isinstance(robot.sensor, DiscSensor):
        return robot.sensor.radius_m, 2 * robot.sensor.radius_m
    return robot.sensor.side_m, math.sqrt(2) * robot.sensor.side_m


def rim_share(s: float, robot: Robot) -> float:
    """psi at distance s (in radii of a disc, in sides of a square), from 0 at 0 to 1 at 2 (a square: sqrt 2)."""
    if isinstance(robot.sensor, DiscSensor):
        if s >= 2:
            return 1.0
        # the part of a unit disc within s of a point of its rim
        half = s / 2
        lens = s * s * math.acos(half) + 2 * math.asin(half) - s * math.sqrt(1 - half * half)
        return max(4 / math.pi * (s - s * s / 2) if s < 1 else 2 / math.pi, lens / math.pi)
    if s >= math.sqrt(2):
        return 1.0
    if s <= 1:
        return math.pi * s * s / 4
    return math.sqrt(s * s - 1) + s * s * (math.pi / 4 - math.acos(1 / s))

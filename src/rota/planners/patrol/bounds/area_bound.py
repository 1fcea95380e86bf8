"""Robots at least, since each area must come into range within any window of its period.

Statement. Of disjoint areas A_z with periods T_z, all of which can be seen, a team of robots that bring ``sweep`` m2/s
of new ground into range at most, and have ``footprint`` m2 in range at rest, takes

    robots >= max over mu in {1 / T_z} of sum_z A_z min(1 / T_z, mu) / (sweep + footprint mu).

Proof. Within a window of length 1 / mu a robot brings at most sweep / mu of new ground into range and holds its
footprint at the beginning. In that window all of an area with T_z <= 1 / mu comes into range. Of one with a longer
period, such windows see the share 1 / (mu T_z) on average, so that some window sees as much as the sum asks.

Source. The areas' rate argument of Sun et al. 2019, made rigorous by the footprint. "Range" stands where they say
"view", for beside a corner the edge of a shadow outruns the disc.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rota.model.mission import Robot
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s
from rota.planners.patrol.tolerances import ROUNDING


def area_rate_bound(areas_m2: Sequence[float], periods_s: Sequence[float], robot: Robot) -> int:
    """Robots at least for areas (k,) that can be seen, in m2, and their periods (k,) in seconds.

    Nothing asked gives 0, any area at least 1.
    """
    rounded = math.ceil(area_rate(areas_m2, periods_s, robot)[0] - ROUNDING)
    return max(rounded, 1 if any(area > 0 for area in areas_m2) else 0)


def area_rate(areas_m2: Sequence[float], periods_s: Sequence[float], robot: Robot) -> tuple[float, float]:
    """The bound of ``area_rate_bound`` before rounding, and the area per second asked (m2/s) that gives it."""
    best = (0.0, 0.0)
    for period_s in periods_s:
        mu = 1 / period_s
        rate = sum(area * min(1 / period, mu) for area, period in zip(areas_m2, periods_s, strict=True))
        best = max(best, (rate / (sweep_m2_s(robot) + footprint_m2(robot) * mu), rate))
    return best


def rate_proof(robots: float, asked_m2_s: float, *, turns: bool = False) -> ProvedBound:
    """The proof from a real number of robots that are asked to see ``asked_m2_s`` of ground per second.

    turns: robots stop to turn, which is counted.
    """
    who = "a robot that stops to turn" if turns else "a robot"
    each = f", {who} sweeps {asked_m2_s / robots:.4g} at most" if robots > 0 else ""
    return ProvedBound(robots=math.ceil(robots - ROUNDING), reason=f"{asked_m2_s:.4g} m2/s are asked for{each}")

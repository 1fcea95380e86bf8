"""Plans by hand for vehicles: a square, and a winding way to a corner and back."""

from __future__ import annotations

import numpy as np
from shapely import box
from tests.files.two_robots import ORIGIN

from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory

SIDE_M, SPEED_M_S = 60.0, 8.0
ROUND_S = 4 * SIDE_M / SPEED_M_S


def square(period_s: float, turn_rate_rad_s: float | None = None) -> Plan:
    """One robot round a square whose ground it sees once a round."""
    ring = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]) * SIDE_M
    fleet = Fleet(speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=12), turn_rate_rad_s=turn_rate_rad_s)
    area = box(-5, -5, SIDE_M + 5, SIDE_M + 5).difference(box(5, 5, SIDE_M - 5, SIDE_M - 5))
    mission = Mission(name="square", area=area, period_s=period_s, fleet=fleet, origin=ORIGIN)
    trajectory = Trajectory(robot="robot-1", times_s=np.linspace(0, ROUND_S, 5), positions_m=ring)
    return Plan(mission=mission, trajectories=(trajectory,))


def winding(off_m: float) -> Plan:
    """Along two sides of a square and back, with a point each 5 m that is off by so much; a wait at the far corner."""
    out = [[5.0 * k, off_m * (k % 2)] for k in range(12)] + [[60.0, 0.0]] + [[60.0, 5.0 * k] for k in range(1, 13)]
    places = [*out, out[-1], *out[-2::-1]]
    lengths_m = np.linalg.norm(np.diff(places, axis=0), axis=1)
    times_s = np.append(0, np.cumsum(np.where(lengths_m > 0, lengths_m / 8, 7.5)))
    plan = square(100)
    return Plan(mission=plan.mission, trajectories=(Trajectory(robot="robot-1", times_s=times_s, positions_m=places),))

"""The check's kernels compiled before there is a plan to check."""

from __future__ import annotations

import numpy as np
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory

SIDE_M = 20.0


def check_of_a_team() -> None:
    """The check of two robots that circle a block: sight, motion and the bodies' separation."""
    from rota.check.judge import check_plan

    check_plan(_round_a_block())


def check_of_slits() -> None:
    """The check's loops for ground that is seen only as robots pass."""
    from rota.check.pieces import convex_pieces
    from rota.check.revisits import passing_gaps, sights_of

    plan = _round_a_block()
    pieces = convex_pieces(plan.mission.area, SIDE_M / 4, SIDE_M / 8)
    passing_gaps(sights_of(plan, plan.mission.area.bounds), pieces, np.ones(len(pieces)))


PARTS = (check_of_a_team, check_of_slits)


def _round_a_block() -> Plan:
    """Two robots with bodies, on one loop round a block that hides what is behind it."""
    mission = Mission(
        name="first run",
        area=MultiPolygon([box(0, 0, SIDE_M, SIDE_M)]),
        period_s=100,
        obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.1),
    )
    ring = np.array([[2.0, 2.0], [18.0, 2.0], [18.0, 18.0], [2.0, 18.0], [2.0, 2.0]])
    times_s = np.arange(0.0, 65.0, 16.0)
    robots = [Trajectory(robot=f"robot-{k}", times_s=times_s, positions_m=ring) for k in (1, 2)]
    return Plan(mission=mission, trajectories=tuple(robots))

"""A plan of 20 robots over a square kilometre, made without a planner: ``python -m benchmarks.square_kilometre PLAN``.

The square is cut into 2 x 10 blocks of 500 m x 100 m, one a robot. A robot mows its block in six lanes and comes back
along the block's left edge; like a planned route its loop has a waypoint every few metres.
"""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np
from shapely import box

from rota.files.plan_file import write_plan
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory

SIDE_M, BLOCK_M = 1000.0, (500.0, 100.0)
RADIUS_M, SPEED_M_S, PERIOD_S = 10.0, 10.0, 320.0
LANES = 6  # 16.7 m apart: less than 2 x 10 m, so that swaths overlap and corners are seen
EDGE_M = 5.0  # the outermost legs stay this far from the block's sides; its corners are then 9.7 m away
LANES_START_M = 20.0  # right of the way back, which sees what lies between the lanes' left ends
WAYPOINT_EVERY_M = 20.0


def square_kilometre_plan() -> Plan:
    """The plan; every point is seen again within a loop of 305 s, and 320 s are allowed."""
    mission = Mission(
        name="square-kilometre",
        area=box(0, 0, SIDE_M, SIDE_M),
        period_s=PERIOD_S,
        fleet=Fleet(speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=RADIUS_M)),
    )
    corners_m = [(x, y) for x in np.arange(0, SIDE_M, BLOCK_M[0]) for y in np.arange(0, SIDE_M, BLOCK_M[1])]
    return Plan(
        mission=mission,
        trajectories=tuple(_mowing(f"robot-{k + 1}", np.array(corner_m)) for k, corner_m in enumerate(corners_m)),
    )


def _mowing(robot: str, corner_m: np.ndarray) -> Trajectory:
    bends_m = corner_m + _bends_m()
    points_m = [bends_m[:1]]
    for start_m, end_m in pairwise(bends_m):
        legs = int(np.ceil(np.hypot(*(end_m - start_m)) / WAYPOINT_EVERY_M))
        points_m.append(start_m + np.linspace(0, 1, legs + 1)[1:, None] * (end_m - start_m))
    positions_m = np.concatenate(points_m)
    positions_m[-1] = positions_m[0]
    lengths_m = np.hypot(*np.diff(positions_m, axis=0).T)
    times_s = np.concatenate([[0.0], np.cumsum(lengths_m / SPEED_M_S)])
    return Trajectory(robot=robot, times_s=times_s, positions_m=positions_m)


def _bends_m() -> np.ndarray:
    """Corners of one block's loop, (n, 2), first and last the same: lanes to and fro, then back along the left edge."""
    spacing_m = BLOCK_M[1] / LANES
    left_m, right_m = LANES_START_M, BLOCK_M[0] - EDGE_M
    bends_m = [(EDGE_M, spacing_m / 2)]
    for lane in range(LANES):
        y_m = (lane + 0.5) * spacing_m
        ends_m = [(left_m, y_m), (right_m, y_m)]
        bends_m += ends_m if lane % 2 == 0 else ends_m[::-1]
    bends_m += [(EDGE_M, BLOCK_M[1] - spacing_m / 2), bends_m[0]]
    return np.array(bends_m)


if __name__ == "__main__":
    write_plan(square_kilometre_plan(), sys.argv[1], meets_demand=True)

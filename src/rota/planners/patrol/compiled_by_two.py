"""A first plan comes sooner where two processes compile its loops."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

# the longest moves first, for they are wanted first; then all that a planner does before it anneals; then a robot that
# circles a block, which takes the check through sight, motion and two bodies' separation
OTHER_HALF = """
import numpy as np
from shapely import MultiPolygon, box
from rota.planners.patrol.annealing.compile_ahead import compile_exchanges
compile_exchanges()
from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.plan import Plan, Trajectory
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import period_groupings
ring = [[2, 2], [18, 2], [18, 18], [2, 18], [2, 2]]
mission = Mission(
    name="first run", area=MultiPolygon([box(0, 0, 20, 20)]), period_s=100,
    obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.1),
)
problem = set_up_problem(mission)
tours, one = period_groupings(problem, 1)[0].tours, np.ones(1)
weights = {'length_weight': one, 'budget_penalty': one}
Annealing(tours[:1], problem.samples, problem.paths.grid, **weights, seed=0, range_margin_m=0.01)
robots = [Trajectory(robot=f"robot-{k}", times_s=[0, 16, 32, 48, 64], positions_m=ring) for k in (1, 2)]
check_plan(Plan(mission=mission, trajectories=tuple(robots)))
"""


@contextmanager
def compiled_by_two(*, to_the_end: bool = False) -> Iterator[None]:
    """Compile the annealing while another process compiles all else: a first plan comes sooner by a third.

    What both need is compiled by one of them, and the other one waits for it. to_the_end: wait for all of it.
    """
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([sys.executable, "-c", OTHER_HALF], stdin=quiet, stdout=quiet, stderr=quiet)
    try:
        from rota.planners.patrol.annealing.compile_ahead import compile_moves

        compile_moves()
        yield
        if to_the_end:
            process.wait()
    finally:
        process.kill()
        process.wait()

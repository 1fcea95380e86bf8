"""What is compiled ahead is what the search then calls: one signature each, never a second compilation."""

from __future__ import annotations

import subprocess
import sys

# in a process of its own: other tests call the kernels with types of their own
SEARCH = """
import numpy as np
from shapely import MultiPolygon, box
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.model.mission import (DiscSensor, Fleet, Mission, Obstacle)
from rota.planners.patrol.annealing import kernels, move_kernels, state_kernels
from rota.planners.patrol.annealing.compile_ahead import longest_moves, moves
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import period_groupings
longest_moves()
moves()
mission = Mission(
    name="block", area=MultiPolygon([box(0, 0, 20, 20)]), period_s=60,
    obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=3)), planning=PatrolSettings(effort="quick"),
)
problem = set_up_problem(mission)
search = Annealing(
    period_groupings(problem, 1)[0].tours, problem.samples, problem.paths.grid,
    length_weight=np.ones(1), budget_penalty=np.ones(1), seed=0, range_margin_m=0.01,
)
print(search.run(2_000, hot_m=1.0, cold_m=0.01, should_stop=lambda: False))
assert search.shortfall_m >= 0
search.see_more(10)
called = (kernels.anneal, kernels.see_more, state_kernels.over_budget_costs)
inner = (move_kernels.try_two_opt, move_kernels.try_or_opt)
print(*(len(kernel.entries) for kernel in called), *(len(kernel.signatures) for kernel in inner))
"""


def test_the_annealing_is_compiled_ahead_with_the_types_that_it_is_called_with() -> None:
    done = subprocess.run([sys.executable, "-c", SEARCH], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "1", "1", "1", "1", "1"]

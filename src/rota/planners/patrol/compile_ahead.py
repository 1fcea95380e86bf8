"""What a first patrol plan compiles, in parts that processes share out, those that take longest first."""

from __future__ import annotations

import numpy as np
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.annealing.compile_ahead import Float, longest_moves, moves, typeof, types_of_states
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.repair.bending.sighting_kernels import SensingLegs, Sightings, best_sightings


def ground() -> None:
    """Points, viewpoints and the ways between them, a first order of viewpoints, and the annealing's first state."""
    problem = _yard()
    tours, one = period_groupings(problem, 1)[0].tours, np.ones(1)
    Annealing(
        tours[:1], problem.samples, problem.paths.grid,
        length_weight=one, budget_penalty=one, seed=0, range_margin_m=0.01,
    )  # fmt: skip


def bending() -> None:
    """Who sees which sample, for the linear programs that bend loops."""
    ints, threes = np.zeros(0, np.int64), np.zeros((0, 3))
    legs, best = (
        SensingLegs(np.zeros((0, 4)), ints, np.zeros(0), ints),
        Sightings(threes.astype(np.int64), threes, threes),
    )
    _, samples, _ = types_of_states()
    best_sightings.compile_entry(typeof(legs), Float, samples, typeof(np.zeros(0, np.int32)), typeof(best))


def compile_bound() -> None:
    """What proves how many robots are needed, with what places see round corners."""
    prove_bound(_yard())


PARTS = (longest_moves, ground, moves, bending, compile_bound)


def _yard() -> Problem:
    """A small yard round a block, which hides and bars; what drives in it has a body."""
    return set_up_problem(
        Mission(
            name="first run",
            area=MultiPolygon([box(0, 0, 20, 20)]),
            period_s=100,
            obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
            fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.1),
        )
    )

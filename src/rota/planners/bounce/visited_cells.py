"""Which cells the robots of a plan enter, read from its trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.plan import Plan, Trajectory
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.trajectories import step_duration_s

Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class VisitedCells:
    """The cells of a plan's mission and (n,) how many steps robots are in each, until the last one's points end.

    steps: the most that a robot takes until then.
    """

    cells: Cells
    visits: Ints
    step_s: float
    steps: int


def visited_cells(plan: Plan) -> VisitedCells:
    """How often the robots of a plan of the bounce planner are in each cell, the starts included."""
    cells = make_cells(plan.mission)
    step_s = step_duration_s(plan.mission, cells)
    visits = np.zeros(cells.count, np.int64)
    steps = 0
    number = np.full((cells.row.max() + 2, cells.column.max() + 2), cells.count)
    number[cells.row, cells.column] = np.arange(cells.count)
    for trajectory in plan:
        at = np.floor((_places_at_steps(trajectory, step_s) - cells.corner_m) / cells.cell_m).astype(np.int64)
        visits += np.bincount(number[at[:, 1], at[:, 0]], minlength=cells.count + 1)[: cells.count]
        steps = max(steps, len(at) - 1)
    return VisitedCells(cells=cells, visits=visits, step_s=step_s, steps=steps)


def _places_at_steps(trajectory: Trajectory, step_s: float) -> NDArray[np.float64]:
    """(steps + 1, 2) where the robot is after each step."""
    last = round(float(trajectory.times_s[-1]) / step_s)
    times_s = np.arange(last + 1) * step_s
    x, y = (np.interp(times_s, trajectory.times_s, trajectory.positions_m[:, axis]) for axis in (0, 1))
    return np.column_stack([x, y])

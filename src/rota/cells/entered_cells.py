"""Which cells of their grid bouncing robots are in, the ways they face there, and how often each cell is entered."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory


class FacedCells(NamedTuple):
    """Where a robot is after each step, (n, 2) cells from the grid's lower left corner, and the ways it faces, (n,).

    entered: (n,) whether it came there in this step, or began there.
    """

    cells: Ints
    headings_rad: Floats
    entered: Flags


def faced_cells(mission: Mission, trajectory: Trajectory) -> FacedCells:
    """The cells and headings of a bouncing robot, step by step; a longer wait counts as one step."""
    corner, cell_m = np.array(mission.grid_corner_m), mission.bouncing.cell_m
    at = np.floor((trajectory.positions_m[:, :2] - corner) / cell_m).astype(np.int64)
    assert trajectory.headings_rad is not None
    cells, headings, entered = [at[0]], [float(trajectory.headings_rad[0])], [True]
    for leg, move in enumerate(np.diff(at, axis=0)):
        steps = math.gcd(int(move[0]), int(move[1]))
        cells += [at[leg] + move * k // steps for k in range(1, steps + 1)] or [at[leg]]
        headings += [float(trajectory.headings_rad[leg + 1])] * max(steps, 1)
        entered += [steps > 0] * max(steps, 1)
    return FacedCells(np.array(cells), np.array(headings), np.array(entered))


def entries_of_cells(plan: Plan) -> Ints:
    """(rows, columns) how often robots enter each cell on their trajectories, starts included, loops once."""
    (x0, y0), (_, _, x1, y1) = plan.mission.grid_corner_m, plan.mission.area.bounds
    cell_m = plan.mission.bouncing.cell_m
    columns, rows = (max(1, math.ceil(size / cell_m - 1e-9)) for size in (x1 - x0, y1 - y0))
    found = np.zeros((rows, columns), np.int64)
    for trajectory in plan:
        faced = faced_cells(plan.mission, trajectory)
        np.add.at(found, (faced.cells[faced.entered, 1], faced.cells[faced.entered, 0]), 1)
    return found

"""A plan of bouncing robots: how often and when first each cell is entered, and where robots turn."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.cells.entered_cells import entries_of_cells
from rota.model.arrays import Floats
from rota.model.plan import Plan, Trajectory

TURN_RAD = 1e-9


class Turns(NamedTuple):
    """Where a robot turns, (b,) each: from when on, where, and the headings before and after in radians."""

    times_s: Floats
    places_m: Floats
    before_rad: Floats
    after_rad: Floats


def turns_of(trajectory: Trajectory) -> Turns:
    """Every turn of a bouncing robot in the order of time; its loop counts once."""
    headings = trajectory.headings_rad
    if headings is None:
        headings = np.zeros(len(trajectory.times_s))
    at = np.flatnonzero(np.abs(np.diff(headings)) > TURN_RAD)
    places_m = trajectory.positions_m[at, :2]
    return Turns(trajectory.times_s[at], places_m, headings[at], headings[at + 1])


def turn_arrays(plan: Plan) -> dict[str, NDArray[Any]]:
    """The turns of all robots as arrays of a playback."""
    found = [turns_of(trajectory) for trajectory in plan]
    offsets = np.cumsum([0, *(len(turns.times_s) for turns in found)])
    joined = [np.concatenate([np.asarray(turns[k]) for turns in found]) for k in range(len(Turns._fields))]
    return {
        "turn_offsets": offsets.astype(np.uint32),
        "turn_time_s": joined[0].astype(np.float64),
        "turn_x_m": joined[1][:, 0].astype(np.float32),
        "turn_y_m": joined[1][:, 1].astype(np.float32),
        "turn_before_rad": joined[2].astype(np.float32),
        "turn_after_rad": joined[3].astype(np.float32),
    }


def cell_arrays(plan: Plan) -> tuple[dict[str, Any], dict[str, NDArray[Any]], Floats]:
    """The cells' grid, the arrays of a playback with a number for each cell, and when each was entered first.

    The last is (rows, columns) seconds, inf for cells that nobody enters.
    """
    entries = entries_of_cells(plan)
    rows, columns = entries.shape
    x0, y0 = plan.mission.grid_corner_m
    first_s = np.full(entries.shape, np.inf)
    for trajectory in plan:
        _note_entries(plan, trajectory, first_s)
    grid = {
        "x0_m": x0, "y0_m": y0, "cell_m": plan.mission.bouncing.cell_m,
        "columns": columns, "rows": rows, "most": int(entries.max(initial=0)),
    }  # fmt: skip
    arrays = {"cell_entries": entries.astype(np.uint32).ravel(), "cell_entered_s": first_s.astype(np.float32).ravel()}
    return grid, arrays, first_s


def _note_entries(plan: Plan, trajectory: Trajectory, first_s: Floats) -> None:
    """Lower ``first_s`` (rows, columns) to when this robot reaches the middle of each cell."""
    corner, cell_m = np.array(plan.mission.grid_corner_m), plan.mission.bouncing.cell_m
    at = np.floor((trajectory.positions_m[:, :2] - corner) / cell_m).astype(np.int64)
    times_s = trajectory.times_s
    first_s[at[0, 1], at[0, 0]] = 0.0
    for leg, move in enumerate(np.diff(at, axis=0)):
        steps = math.gcd(int(move[0]), int(move[1]))
        for k in range(1, steps + 1):
            column, row = at[leg] + move * k // steps
            time_s = times_s[leg] + (times_s[leg + 1] - times_s[leg]) * k / steps
            first_s[row, column] = min(first_s[row, column], time_s)

"""Loops on which a robot hardly leaves its place: it turns in a cell, or goes to and fro between two walls.

Such a rattle is a limit cycle as good as any other on the grid. But it hangs on every wall exactly, sees next to
nothing of the ground, and the first turn that is off ends most of them. So other loops are chosen where they serve.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import pdist

from rota.model.arrays import Flags, Floats
from rota.model.plan import Plan
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.limit_cycles import LimitCycles

WIDTHS = 2.0  # of a body: within so much it hardly moves
STRAIGHT = 1e-6  # share of its length by which a line may be off


def is_rattle(places_m: Floats, body_radius_m: float) -> bool:
    """Whether a loop through places (n, 2) stays within two widths of the body, or on one straight line."""
    places = np.unique(np.round(places_m[:, :2], 9), axis=0)
    size = places.max(axis=0) - places.min(axis=0)
    if np.hypot(*size) <= 2 * WIDTHS * body_radius_m:
        return True
    along = places[-1] - places[0]  # from the first to the last by x and then y: the ends of a line
    off = np.abs((places - places[0]) @ np.array([-along[1], along[0]]))
    if off.max() <= STRAIGHT * (along @ along):
        return True
    return bool(size.max() <= 2 * WIDTHS * body_radius_m and pdist(places).max() <= 2 * WIDTHS * body_radius_m)


def rattling_nodes(cycles: LimitCycles, cells: Cells, body_radius_m: float) -> Flags:
    """(p,) whether each periodic state is on a rattle of a robot with this body."""
    centres = cells.centres_m[cycles.state // cells.headings]
    rattles = [
        is_rattle(centres[start : start + length], body_radius_m)
        for start, length in zip(cycles.start, cycles.length, strict=True)
    ]
    return np.array(rattles, np.bool_)[cycles.cycle]


def rattling_robots(plan: Plan) -> dict[str, float]:
    """The robots of a plan whose loops are rattles, and how far from end to end these are in metres."""
    found = {}
    for trajectory in plan:
        places = trajectory.positions_m[trajectory.loop_index :, :2]
        if trajectory.loop_duration_s > 0 and is_rattle(
            places, plan.mission.fleet.robot(trajectory.robot).body_radius_m
        ):
            found[trajectory.robot] = float(pdist(places).max(initial=0.0))
    return found

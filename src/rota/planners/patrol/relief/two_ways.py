"""Ways to a post and back on which two robots with bodies pass each other while one relieves the other.

Who comes and who goes meet beside the post, half way through the pause between them. On one way they would touch; on
two that are at right angles there, straight for as far as a robot comes in the pause, their centres are at the nearest
that far apart by the square root of two. Robots that take time to turn or to change speed pass each other as far apart,
after a longer pause.
"""

from __future__ import annotations

import math

import numpy as np

from rota.errors import PlanError
from rota.geometry.kernels import free_segments
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.planners.patrol.tolerances import SAME_PLACE_M


def passing_ways(
    paths: ShortestPaths, charger_m: Floats, post_m: Floats, straight_m: float
) -> tuple[Floats, Floats] | None:
    """Two ways (k, 2) from a charger to a post, at right angles for ``straight_m`` there: to come by, and to go back.

    None: walls leave no room for them, no way leads there, or the charger is as near.
    """
    try:
        way_m = paths.path(charger_m, post_m)
    except PlanError:
        return None
    steps_m = np.diff(way_m, axis=0)
    if np.hypot(*steps_m.T).sum() <= straight_m + SAME_PLACE_M:
        return None
    ahead_rad = math.atan2(*-steps_m[-1][::-1])
    for turn in sorted(range(-5, 7), key=abs):  # about the post, until walls leave room
        turned_rad = ahead_rad + turn * math.pi / 6 + np.array([-math.pi / 4, math.pi / 4])
        beside_m = post_m + straight_m * np.column_stack([np.cos(turned_rad), np.sin(turned_rad)])
        if not free_segments(beside_m, np.vstack([post_m, post_m]), paths.grid).all():
            continue
        comes_m, goes_m = (np.vstack([paths.path(charger_m, each), post_m]) for each in beside_m)
        return comes_m, goes_m
    return None

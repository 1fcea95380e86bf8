"""What stays unmet after it was asked for: places from which it is seen well, and not only by a hair."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.repair.detours import led_past
from rota.planners.patrol.repair.last_places import nearby_place, places_in_view, way_across
from rota.planners.patrol.tours.tour import Tour


def ask_again(problem: Problem, extra: SamplePoints, new: SamplePoints) -> SamplePoints:
    """Of each crowd of new points beside one that was asked for, the one that is seen from the least ground.

    The point that was asked for is seen by a hair at best, and so is a crowd. On ragged ground only: elsewhere most
    come into sight with the next round.
    """
    if not problem.is_ragged or not len(extra):
        return no_points()
    # what is so near is the same place
    near_m, _ = cKDTree(extra.xy_m).query(new.xy_m, distance_upper_bound=0.005 * problem.reach_m)
    beside = np.flatnonzero(np.isfinite(near_m))
    # one visit may do for those that are so near
    crowd = np.unique(np.floor(new.xy_m[beside] / (0.05 * problem.reach_m)), axis=0, return_inverse=True)[1].ravel()
    hardest = []
    for k in range(crowd.max(initial=-1) + 1):
        members = beside[crowd == k]
        members = members[:: 1 + len(members) // 12]  # some dozen of them are looked at
        seen_m2 = [places_in_view(problem, new.xy_m[i]).area for i in members]
        hardest += [members[i] for i in np.argsort(seen_m2) if seen_m2[i] > 0][:1]
    return new[np.array(hardest, dtype=np.int64)]


def visiting_stubborn(context: Context, tours: list[Tour], points: SamplePoints, stuck: int) -> list[Tour]:
    """The tours led to where points can be seen from nearby, nearer by each round in which they are ``stuck``.

    Every such point is seen, but no single view takes in a whole piece round it.
    """
    for i in range(min(len(points), 12)):  # each takes metres
        place = nearby_place(context.problem, points.xy_m[i], float(points.visit_m[i]), stuck)
        if place is not None:
            way_m = way_across(context.problem, points.xy_m[i], place)
            tours = led_past(context.problem, tours, way_m, int(points.period[i]))
    return tours

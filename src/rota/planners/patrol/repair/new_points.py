"""Places that the judge found unmet become samples: of a crowd a few, those at the rim of what is seen first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.limits_of_sight import with_reach_for
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints, join, points_of
from rota.planners.patrol.tolerances import ON_LINE_M
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.verdict import Verdict


def new_points(
    context: Context, tours: Sequence[Tour], verdict: Verdict, turn: int, *, shorter_m: float
) -> SamplePoints:
    """The places that the judge found unmet, as samples; of a crowd of them a few, more and nearer in every round.

    shorter_m: by how much less than they reach sensors are taken to reach for them.
    """
    problem = context.problem
    most = max(1_500, len(problem.points) // 20)  # with more, annealing and programs take long
    by_name = {region.name: i for i, region in enumerate(problem.regions)}
    unmet_m, unmet_demand = verdict.unmet_points_m, verdict.unmet_demand
    if problem.is_ragged and len(verdict.shown_unmet_m):
        unmet_m, unmet_demand = verdict.shown_unmet_m, verdict.shown_unmet_demand
        if turn > 1:  # at first most others lie in pieces of ground that walls cut in two
            unmet_m = np.vstack([unmet_m, verdict.unmet_points_m])
            unmet_demand = np.concatenate([unmet_demand, verdict.unmet_demand])
    # on ragged ground what lies side by side is seen through slits of its own, and a round of checking takes long
    grid_m = (0.002 if problem.is_ragged else 0.04) * problem.reach_m * 0.6 ** (turn - 1)
    samples = [no_points()]
    for k, demand in enumerate(verdict.demands):
        xy = unmet_m[unmet_demand == k]
        if demand.name not in by_name or not len(xy):
            continue
        i = by_name[demand.name]
        if problem.regions[i].demand == "visit":
            again = problem.points[problem.points.region == i]
            samples.append(replace(again, area_m2=np.full(len(again), problem.swath_m**2)))
            continue
        ranges_m = np.zeros(len(xy))
        if problem.at_limit:
            order, ranges_m = hardest_first(problem, tours, xy)
            xy = xy[order]
        _, first = np.unique(np.floor(xy / grid_m).astype(np.int64), axis=0, return_index=True)
        first = np.sort(first)[:: max(1, len(first) // most)]
        new = points_of(xy[first], problem.spacing_m**2, problem.region_class[i], i, shrink_m=shorter_m)
        samples.append(with_reach_for(new, ranges_m[first], problem.reach_m, problem.range_margin_m))
    return join(samples)


def hardest_first(problem: Problem, tours: Sequence[Tour], xy_m: Floats) -> tuple[Ints, Floats]:
    """An order of the points (n, 2): those at the rim that the tours miss, from the outermost inwards, then the rest.

    With the range (n,) of each, in that order. Ground beyond the rim is nobody's and comes last.
    """
    places_m, ranges_m = nearest_places(xy_m, problem.space, problem.walls, problem.robot)
    at_rim = np.flatnonzero((ranges_m > problem.reach_m - problem.range_margin_m) & (ranges_m <= problem.reach_m))
    routes = shapely.union_all([shapely.linestrings(np.vstack([t.vertices_m, t.vertices_m[:1]])) for t in tours])
    missed = np.zeros(len(xy_m), dtype=bool)
    missed[at_rim] = shapely.distance(routes, shapely.points(places_m[at_rim])) > ON_LINE_M
    order = np.lexsort((np.where(ranges_m <= problem.reach_m, -ranges_m, np.inf), ~missed))
    return order.astype(np.int64), ranges_m[order]

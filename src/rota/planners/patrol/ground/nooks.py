"""Points beside all sides of ragged ground: samples lie too far apart for these, and the check finds them in rounds."""

from __future__ import annotations

import shapely

from rota.geometry.free_space import nooks
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints, join, points_of
from rota.planners.patrol.tolerances import INSIDE_M


def nooks_of(problem: Problem) -> SamplePoints:
    """Points beside every side of a region that must be seen, and one in every inner corner; more on ragged ground."""
    # what one point misses of a side that is seen through slits takes rounds
    found, per_side = [no_points()], 2 if problem.is_ragged else 1
    for i, region in enumerate(problem.regions):
        if region.demand == "every_point":
            xy_m = nooks(region.shape, INSIDE_M, per_side=per_side)
            inside = shapely.contains_xy(region.shape, xy_m)
            found.append(points_of(xy_m[inside], problem.spacing_m**2, problem.region_class[i], i))
    return join(found)

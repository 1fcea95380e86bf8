"""Demands that a robot meets by coming to one place: zones to visit, and ground all of which is seen from there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.viewpoints import what_places_see


@dataclass(frozen=True, kw_only=True)
class Targets:
    """Places (n, 2) to come to, the period (n,) of each, its class (n,), and its part (n,) of the standing space.

    room_m (n,): how far from its place a robot may be instead; 0 for ground that is seen. regions: the numbers of the
    demands that are met so; a place may meet several.
    """

    places_m: Floats
    period_s: Floats
    period_class: Ints
    component: Ints
    room_m: Floats
    regions: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.period_s)


def targets_of(problem: Problem) -> Targets:
    """The demands of a problem that are met from one place, each with a place; places that meet several stand once."""
    visits = np.flatnonzero(problem.points.visit_m > 0)
    room_m = dict(zip(problem.points.region[visits].tolist(), problem.points.visit_m[visits].tolist(), strict=True))
    found = dict(zip(room_m, problem.points.xy_m[visits], strict=True)) | places_that_see_regions(problem)
    regions = sorted(found)
    places_m = np.array([found[k] for k in regions]).reshape(-1, 2)
    places_m, which = np.unique(places_m, axis=0, return_inverse=True)
    period_class = np.full(len(places_m), len(problem.periods_s), dtype=np.int64)
    np.minimum.at(period_class, which.ravel(), [problem.region_class[k] for k in regions])
    least_m = np.full(len(places_m), np.inf)
    np.minimum.at(least_m, which.ravel(), [room_m.get(k, 0.0) for k in regions])
    return Targets(
        places_m=places_m, period_s=np.array(problem.periods_s)[period_class], period_class=period_class,
        component=problem.paths.part_of(places_m), room_m=least_m, regions=tuple(regions),
    )  # fmt: skip


def draw_together(targets: Targets) -> Targets:
    """The same with each place as near as it may be to the middle of the two that are nearest to it."""
    places_m, count = targets.places_m, len(targets)
    if count < 2:
        return targets
    apart_m = np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))
    apart_m[targets.component[:, None] != targets.component[None]] = np.inf
    np.fill_diagonal(apart_m, np.inf)
    nearest = np.argsort(apart_m, axis=1, kind="stable")[:, : min(2, count - 1)]
    near = np.isfinite(np.take_along_axis(apart_m, nearest, axis=1))[..., None]
    middle_m = (near * places_m[nearest]).sum(axis=1) / np.maximum(near.sum(axis=1), 1)
    way_m = np.where(near.any(axis=1), middle_m - places_m, 0.0)
    length_m = np.hypot(*way_m.T)
    share = np.minimum(1.0, targets.room_m / np.maximum(length_m, 1e-12))
    return replace(targets, places_m=places_m + share[:, None] * way_m)


def places_that_see_regions(problem: Problem) -> dict[int, Floats]:
    """For each region that is seen from one place all at once such a place (2,), the nearest to its middle."""
    points, regions = problem.points, problem.regions
    small = [k for k, region in enumerate(regions) if region.demand == "every_point" and is_small(problem, k)]
    if not small:
        return {}
    middles_m = np.array([shapely.get_coordinates(regions[k].shape.centroid)[0] for k in small])
    middles_m = middles_m[problem.paths.part_of(middles_m) >= 0]
    start, seen = what_places_see(middles_m, problem.robot, problem.range_margin_m, problem.samples)
    places_m = np.vstack([middles_m, problem.viewpoints.xy_m])
    sizes = np.concatenate([np.diff(start), np.diff(problem.viewpoints.start)])
    place, sample = np.repeat(np.arange(len(places_m)), sizes), np.concatenate([seen, problem.viewpoints.seen])
    found = {}
    for k in small:
        counts = np.bincount(place[points.region[sample] == k], minlength=len(places_m))
        whole = np.flatnonzero(counts == (points.region == k).sum())
        if len(whole):
            away_m = np.hypot(*(places_m[whole] - shapely.get_coordinates(regions[k].shape.centroid)[0]).T)
            found[k] = places_m[whole[np.argmin(away_m)]]
    return found


def is_small(problem: Problem, region: int) -> bool:
    """Whether a sensor's range may hold all of a region, and some of it is asked for."""
    x0, y0, x1, y1 = problem.regions[region].shape.bounds
    across_m = 2 * problem.robot.sensor.reach_m
    return bool(max(x1 - x0, y1 - y0) <= across_m and (problem.points.region == region).any())

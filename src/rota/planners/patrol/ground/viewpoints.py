"""Places from which all samples are seen, and the samples that no place sees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.threads import side_by_side
from rota.model.arrays import Flags, Floats, Ints, ShortInts
from rota.model.mission import Robot
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.limits_of_sight import with_reach_for
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import (
    TOGETHER,
    SamplePoints,
    known_walls,
    lattice,
    lay_out,
    one_a_cell,
)
from rota.planners.patrol.ground.sight import Sight, sensor_arguments
from rota.planners.patrol.ground.surroundings import places_in_sight
from rota.planners.patrol.ground.viewpoint_kernels import greedy_cover, places_see
from rota.planners.patrol.tolerances import HAIR_M, SAME_PLACE_M

MOST_CANDIDATES = 60_000

Seen = tuple[Ints, ShortInts]  # starts (c + 1,) of what each place sees, and its numbers


class Viewpoints(NamedTuple):
    """Places to look from, and what each of them sees.

    xy_m: (c, 2) in the standing space; component: (c,) the part of the space that each lies in. Place i sees the
    samples with the numbers seen[start[i] : start[i + 1]]; start: (c + 1,).
    """

    xy_m: Floats
    component: Ints
    start: Ints
    seen: ShortInts


class SeenPoints(NamedTuple):
    """Points in the order of their prepared samples, and places (c, 2) in metres that see all but ``unseen``.

    unseen: (u,) indices of points that no place sees; unseeable: (k,) those of them that surely no robot can see.
    """

    points: SamplePoints
    samples: Samples
    places_m: Floats
    unseen: Ints
    unseeable: Ints


def candidate_places(space: MultiPolygon, spacing_m: float, coarsest_m: float = np.inf) -> Floats:
    """Places (n, 2) to look from: a lattice in the standing space, its borders and one place in each of its parts.

    In a large space they lie farther apart, up to ``coarsest_m``: beyond that, what lies between would not be seen.
    """
    spacing_m = max(spacing_m, min(float(np.sqrt(space.area / MOST_CANDIDATES)), coarsest_m))
    border = shapely.get_coordinates(shapely.segmentize(space.boundary, spacing_m))
    middles = shapely.get_coordinates(shapely.point_on_surface(np.array(space.geoms)))
    border = one_a_cell(np.unique(border, axis=0), spacing_m / 8)
    return np.ascontiguousarray(np.vstack([lattice(space, spacing_m), border, middles]))


def what_places_see(places_m: Floats, robot: Robot, range_margin_m: float, samples: Samples) -> Seen:
    """Samples that each place (n, 2) sees: starts (n + 1,) and indices into the prepared samples."""
    reach, square = sensor_arguments(robot, range_margin_m)

    def rows_seen_from(some_m: Floats) -> Seen:
        x, y = np.ascontiguousarray(some_m[:, 0]), np.ascontiguousarray(some_m[:, 1])
        seen: Seen = places_see(x, y, reach, square, 0, samples, len(samples.x))
        return seen

    found = side_by_side(rows_seen_from, np.array_split(places_m, 1 + len(places_m) // TOGETHER))
    sizes = np.concatenate([np.diff(start) for start, _ in found])
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), np.concatenate([items for _, items in found])


def choose_viewpoints(start: Ints, items: Ints | ShortInts, wanted: Flags, weight: Floats) -> tuple[Ints, Flags]:
    """Places (greedy set cover) that see all wanted samples that any place sees; which samples (s,) stay unseen."""
    covered = ~wanted
    chosen: Ints = greedy_cover(
        start, items.astype(np.int32, copy=False), np.where(wanted, np.maximum(weight, 1e-6), 0.0), covered
    )
    return chosen, wanted & ~covered


def place_that_sees(
    point_m: Floats, visit_m: float, space: MultiPolygon, walls: Floats, robot: Robot, range_margin_m: float
) -> Floats | None:
    """A place (2,) to stand that sees the point: in the middle of its view, cut by where one can stand.

    None where there is none, or where the view is a sliver: what it sees beside the point is seen from its rim only.
    """
    reach, square = sensor_arguments(robot, range_margin_m)
    if visit_m > 0 and space.distance(shapely.Point(point_m)) <= SAME_PLACE_M:
        return np.asarray(point_m, dtype=np.float64)
    if visit_m > 0:
        places: BaseGeometry = shapely.Point(point_m).buffer(visit_m).intersection(space)
    else:
        x, y = point_m
        cut = (
            shapely.box(x - reach, y - reach, x + reach, y + reach) if square else shapely.Point(point_m).buffer(reach)
        )
        places = places_in_sight(point_m, space, walls, reach * (np.sqrt(2) if square else 1.0), cut)
    if places.is_empty:
        return None
    # the part where one stands most freely: a hair's breadth of a view is of no use to a real robot
    parts = polygons_of(places).geoms
    if not parts:
        return np.asarray(shapely.get_coordinates(places)[0])
    largest = max(parts, key=lambda part: float(part.area))
    if largest.area < HAIR_M * largest.length:
        return None
    return np.asarray(shapely.get_coordinates(largest.point_on_surface())[0])


def search_unseen(
    unseen: Ints, find: Callable[[int], Floats | None], sees: Callable[[Floats], Ints | ShortInts]
) -> tuple[Floats, Ints]:
    """Further places (m, 2) for samples that no candidate sees, and the samples for which none was found.

    find: place for a sample or None; sees: samples that a place sees (so that one place serves the neighbours too).
    """
    places: list[Floats] = []
    hopeless: list[int] = []
    left = dict.fromkeys(int(i) for i in unseen)
    while left:
        i = next(iter(left))
        del left[i]
        place = find(i)
        if place is None:
            hopeless.append(i)
            continue
        seen = set(sees(place).tolist())
        if i not in seen:  # only from the very rim of a view: no robot can be asked to stand there
            hopeless.append(i)
            continue
        places.append(place)
        for j in seen:
            left.pop(j, None)
    return np.array(places).reshape(-1, 2), np.array(hopeless, dtype=np.int64)


def places_that_see_all(points: SamplePoints, sight: Sight) -> SeenPoints:
    """Places that see all points that can be seen: candidates, and further places for what no candidate sees.

    A point that no candidate sees gets the place in the middle of its view. What still is unseen lies near the limit of
    sight. There the shrink of a point is fitted to its range, and it gets the place that sees it from least far.
    """
    space, walls, robot, margin_m = sight
    reach_m, _ = sensor_arguments(robot, 0.0)
    points, samples, _ = lay_out(points, walls, robot)

    def rows_seen_from(place_m: Floats) -> ShortInts:
        return what_places_see(place_m[None], robot, margin_m, samples)[1]

    candidates_m = candidate_places(space, 0.5 * reach_m, 0.9 * reach_m)
    unseen = np.ones(len(points), dtype=bool)
    unseen[what_places_see(candidates_m, robot, margin_m, samples)[1]] = False
    further_m, left = search_unseen(
        np.flatnonzero(unseen),
        lambda i: place_that_sees(points.xy_m[i], float(points.visit_m[i]), space, walls, robot, margin_m),
        rows_seen_from,
    )
    if not len(left):
        return SeenPoints(points, samples, np.vstack([candidates_m, further_m]), left, left)
    nearest_m, ranges_m = nearest_places(points.xy_m[left], space, walls, robot)
    fitted = _with_shrink_fitted(points, left, ranges_m, sight)
    points, samples, order = lay_out(fitted, walls, robot, known=known_walls(samples))
    left = np.argsort(order)[left]
    in_range = {
        int(i): nearest_m[k] for k, i in enumerate(left) if reach_m - ranges_m[k] > HAIR_M and points.visit_m[i] == 0
    }
    last_m, hidden = search_unseen(left, in_range.get, rows_seen_from)
    surely = np.isin(hidden, left[(ranges_m > reach_m) | (points.visit_m[left] > 0)])
    return SeenPoints(points, samples, np.vstack([candidates_m, further_m, last_m]), hidden, hidden[surely])


def _with_shrink_fitted(points: SamplePoints, which: Ints, ranges_m: Floats, sight: Sight) -> SamplePoints:
    """The points, some of them (k,) with a shrink that fits their ranges (k,), and therefore on no lattice any more.

    A lattice has one shrink for all its points.
    """
    reach_m, _ = sensor_arguments(sight.robot, 0.0)
    shrink_m = points.shrink_m.copy()
    shrink_m[which] = with_reach_for(points[which], ranges_m, reach_m, sight.range_margin_m).shrink_m
    stays = np.isin(np.arange(len(points)), which, invert=True)
    return replace(
        points, shrink_m=shrink_m, row=np.where(stays, points.row, -1), column=np.where(stays, points.column, -1)
    )

"""Places from which all samples are seen, and the samples that no place sees."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.line_of_sight import visibility_polygon
from rota.mission import Robot, SquareSensor, inner_reach_m
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import ON_THE_SPOT_M, lattice, one_a_cell
from rota.planners.patrol.ground.viewpoint_kernels import greedy_cover, places_see
from rota.polygons import polygons_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_CANDIDATES = 60_000


def sensor_arguments(robot: Robot, range_margin_m: float) -> tuple[float, int]:
    """Reach (a disc's radius or half a square's side, less the margin) and whether it is a square, for the kernels."""
    return inner_reach_m(robot.sensor) - range_margin_m, int(isinstance(robot.sensor, SquareSensor))


def candidate_places(space: MultiPolygon, spacing_m: float, coarsest_m: float = np.inf) -> Floats:
    """Places (n, 2) to look from: a lattice in the standing space, its borders and one place in each of its parts.

    In a large space they lie farther apart, up to ``coarsest_m``: beyond that, what lies between would not be seen.
    """
    spacing_m = max(spacing_m, min(float(np.sqrt(space.area / MOST_CANDIDATES)), coarsest_m))
    border = shapely.get_coordinates(shapely.segmentize(space.boundary, spacing_m))
    middles = shapely.get_coordinates(shapely.point_on_surface(np.array(space.geoms)))
    border = one_a_cell(np.unique(border, axis=0), spacing_m / 8)
    return np.ascontiguousarray(np.vstack([lattice(space, spacing_m), border, middles]))


def what_places_see(places_m: Floats, robot: Robot, range_margin_m: float, samples: Samples) -> tuple[Ints, Ints]:
    """Samples that each place (n, 2) sees: starts (n + 1,) and indices into the prepared samples."""
    reach, square = sensor_arguments(robot, range_margin_m)
    x, y = np.ascontiguousarray(places_m[:, 0]), np.ascontiguousarray(places_m[:, 1])
    start, items = places_see(x, y, reach, square, 0, samples, len(samples.x))
    return start, np.asarray(items, dtype=np.int64)


def choose_viewpoints(
    start: Ints, items: Ints, wanted: NDArray[np.bool_], weight: Floats
) -> tuple[Ints, NDArray[np.bool_]]:
    """Places (greedy set cover) that see all wanted samples that any place sees; which samples (s,) stay unseen."""
    covered = ~wanted
    chosen: Ints = greedy_cover(start, items, np.where(wanted, np.maximum(weight, 1e-6), 0.0), covered)
    return chosen, wanted & ~covered


def place_that_sees(
    point_m: Floats, visit_m: float, space: MultiPolygon, walls: Floats, robot: Robot, range_margin_m: float
) -> Floats | None:
    """A place (2,) to stand that sees the point, or None when there is none: its view, cut by where one can stand."""
    reach, square = sensor_arguments(robot, range_margin_m)
    if visit_m > 0 and space.distance(shapely.Point(point_m)) <= ON_THE_SPOT_M:
        return np.asarray(point_m, dtype=np.float64)
    if visit_m > 0:
        view: BaseGeometry = shapely.Point(point_m).buffer(visit_m)
    else:
        view = visibility_polygon(point_m, walls, reach * (np.sqrt(2) if square else 1.0))
        x, y = point_m
        cut = (
            shapely.box(x - reach, y - reach, x + reach, y + reach) if square else shapely.Point(point_m).buffer(reach)
        )
        view = view.intersection(cut)
    places = view.intersection(space)
    if places.is_empty:
        return None
    # the part where one stands most freely: a hair's breadth of a view is of no use to a real robot
    parts = polygons_of(places).geoms
    if not parts:
        return np.asarray(shapely.get_coordinates(places)[0])
    largest = max(parts, key=lambda part: float(part.area))
    return np.asarray(shapely.get_coordinates(largest.point_on_surface())[0])


def search_unseen(
    unseen: Ints, find: Callable[[int], Floats | None], sees: Callable[[Floats], Ints]
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

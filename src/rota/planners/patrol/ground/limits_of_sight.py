"""The limit of sight: the last ground in reach, seen only from the border of where robots can stand."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion, border_segments
from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.planners.patrol.ground.samples import SamplePoints, join, points_of
from rota.planners.patrol.ground.sight import sensor_arguments
from rota.planners.patrol.tolerances import BESIDE_M

ARC_STEPS = 64  # per quarter of a circle
FEW_CORNERS = 1_000  # of a space: what is in its range is soon worked out


def area_in_range(space: MultiPolygon, robot: Robot, short_m: float) -> BaseGeometry:
    """All that is in range of a place in the space, of a sensor that reaches ``short_m`` less; sight is not asked.

    Arcs become chords, so that the area is never too large.
    """
    reach_m, square = sensor_arguments(robot, short_m)
    if not square:
        return space.buffer(reach_m, quad_segs=ARC_STEPS)
    sides = border_segments(space).reshape(-1, 2, 1, 2)
    corners = reach_m * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    swept = shapely.convex_hull(shapely.multipoints((sides + corners).reshape(-1, 8, 2)))
    return shapely.union_all([space, *swept])


def limit_is_asked_for(
    regions: Sequence[DemandedRegion], space: MultiPolygon, robot: Robot, range_margin_m: float
) -> bool:
    """Whether some ground that must be seen is out of reach of a sensor that reaches ``range_margin_m`` less."""
    return _limit_is_asked_for(tuple(regions), space, robot, range_margin_m)


@functools.lru_cache(maxsize=4)
def _limit_is_asked_for(
    regions: tuple[DemandedRegion, ...], space: MultiPolygon, robot: Robot, range_margin_m: float
) -> bool:
    """The same; what is left out is told before a search sets up the same ground."""
    asked = [region.shape for region in regions if region.demand == "every_point"]
    beyond = shapely.difference(shapely.union_all(asked), space)
    # what is so near is in range, whatever chords cut off
    if beyond.is_empty or _is_near(beyond, space, 0.98 * sensor_arguments(robot, range_margin_m)[0]):
        return False
    return not bool(shapely.covers(area_in_range(space, robot, range_margin_m), beyond))


def _is_near(shape: BaseGeometry, space: MultiPolygon, near_m: float) -> bool:
    """Whether the shape surely is within ``near_m`` of the space, as that of ragged ground mostly is: False may be so.

    Told from squares: all of one is near if its middle is so near a corner of the space.
    """
    corners_m = shapely.get_coordinates(space)
    if len(corners_m) <= FEW_CORNERS:
        return False
    x0, y0, x1, y1 = shape.bounds
    side_m = max(near_m / 4, float(np.sqrt((x1 - x0) * (y1 - y0) / 50_000)))  # 50,000 squares at most
    columns, rows = int((x1 - x0) / side_m) + 1, int((y1 - y0) / side_m) + 1
    x, y = (v.ravel() for v in np.meshgrid(x0 + side_m * np.arange(columns), y0 + side_m * np.arange(rows)))
    away_m, _ = cKDTree(corners_m).query(np.column_stack([x, y]) + side_m / 2)
    far = away_m + side_m * np.sqrt(0.5) > near_m
    shapely.prepare(shape)
    return not shapely.intersects(shape, shapely.box(x[far], y[far], x[far] + side_m, y[far] + side_m)).any()


def limit_points(
    regions: Sequence[DemandedRegion],
    region_class: Sequence[int],
    space: MultiPolygon,
    robot: Robot,
    *,
    range_margin_m: float,
    spacing_m: float,
) -> SamplePoints:
    """Samples along the limit of what is in range, at most ``spacing_m`` apart, just inside of it; perhaps none.

    A second line of them lies half a margin inside. Ground hardly wider than twice the reach has no limit of sight,
    and yet is seen from its border only. Their shrink is still to be fitted to where they are seen from.
    """
    insets_m = (min(BESIDE_M, range_margin_m / 8), range_margin_m / 2)
    lines_of_points = [points_of(np.zeros((0, 2)), 0.0, 0, 0)]
    for inset_m in insets_m:
        border = area_in_range(space, robot, inset_m).boundary
        for i, region in enumerate(regions):
            if region.demand == "every_point":
                lines = shapely.segmentize(border.intersection(region.shape), spacing_m)
                xy = np.unique(shapely.get_coordinates(lines), axis=0)
                lines_of_points.append(points_of(xy, spacing_m**2 / 4, region_class[i], i))
    return join(lines_of_points)


def with_reach_for(points: SamplePoints, ranges_m: Floats, reach_m: float, range_margin_m: float) -> SamplePoints:
    """The points with a shrink that lets each be seen from its range (n,), and from half of what is left beyond.

    A point whose shrink is small enough keeps it. A shrink may become negative, at most by the margin.
    """
    most_m = np.maximum((reach_m - ranges_m) / 2, 0.0) - range_margin_m
    return replace(points, shrink_m=np.minimum(points.shrink_m, most_m))

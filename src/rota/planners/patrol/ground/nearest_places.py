"""Where to stand so that a sensor need reach least far: the last places from which the rim of the seeable is seen."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely import MultiPolygon

from rota.geometry.free_space import border_segments
from rota.geometry.line_of_sight import edge_grid, sees
from rota.geometry.threads import side_by_side
from rota.model.arrays import Floats, Ints
from rota.model.mission import Robot
from rota.planners.patrol.ground.nearest_kernels import nearest_on_segments
from rota.planners.patrol.ground.sight import sensor_arguments
from rota.planners.patrol.ground.surroundings import places_in_sight
from rota.planners.patrol.tolerances import HAIR_M

PAIRS_TOGETHER = 200_000  # of points and sides: of so many that there are a group of near points is made


def nearest_places(points_m: Floats, space: MultiPolygon, walls: Floats, robot: Robot) -> tuple[Floats, Floats]:
    """For each point (n, 2) the place (n, 2) in the space that sees it from least far, and how far that is (n,).

    walls: (k, 4) that block sight. The range in metres is what the sensor must reach: a distance, or for a square the
    greater of |dx| and |dy|; 0 for points in the space. Beyond the robot's reach no sight is asked, and a range is only
    a lower one; inf where walls hide the point from every place in reach.
    """
    points = np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 2)
    reach_m, square = sensor_arguments(robot, 0.0)
    places, ranges = points.copy(), np.zeros(len(points))
    shapely.prepare(space)
    outside = np.flatnonzero(~shapely.intersects_xy(space, *points.T))
    places[outside], ranges[outside] = _nearest_on_border(points[outside], space, square)
    near = outside[ranges[outside] <= reach_m]
    if not len(walls) or not len(near):
        return places, ranges
    for i in near[~sees(points[near], places[near], edge_grid(walls))]:
        seen_from = places_in_sight(points[i], space, walls, reach_m * (np.sqrt(2) if square else 1.0))
        place, far = nearest_on_segments(points[i : i + 1], segments_of(seen_from), square)
        places[i], ranges[i] = place[0], far[0] if far[0] <= reach_m else np.inf
    return places, ranges


def _nearest_on_border(points_m: Floats, space: MultiPolygon, square: int) -> tuple[Floats, Floats]:
    """For each point (n, 2) the nearest place (n, 2) on the border of the space, and its range (n,) in metres."""
    border = border_segments(space)
    places, ranges = np.full(points_m.shape, np.nan), np.full(len(points_m), np.inf)
    if not len(border) or not len(points_m):
        return places, ranges
    # no range is longer than the way to the nearest corner, whichever way the sensor measures
    most_m = cKDTree(border[:, :2]).query(points_m)[0]
    tree = shapely.STRtree(shapely.linestrings(border.reshape(-1, 2, 2)))

    def nearest(group: Ints) -> None:
        low, high = points_m[group].min(axis=0), points_m[group].max(axis=0)
        far_m = most_m[group].max() + HAIR_M
        near = np.sort(tree.query(shapely.box(*(low - far_m), *(high + far_m))))
        places[group], ranges[group] = nearest_on_segments(points_m[group], border[near], square)

    side_by_side(nearest, groups_of_near(points_m, 1 + len(points_m) * len(border) // PAIRS_TOGETHER))
    return places, ranges


def groups_of_near(points_m: Floats, count: int) -> list[Ints]:
    """The numbers of the points (n, 2) in about so many groups of points that lie near each other."""
    groups = [np.arange(len(points_m))]
    while len(groups) < count:
        halves: list[Ints] = []
        for group in groups:
            wide = int(np.argmax(np.ptp(points_m[group], axis=0)))
            halves += np.array_split(group[np.argsort(points_m[group, wide], kind="stable")], 2)
        groups = [half for half in halves if len(half)]
        if all(len(group) == 1 for group in groups):
            break
    return groups


def segments_of(shape: shapely.Geometry) -> Floats:
    """All segments (k, 4) of a geometry of any kind; a lone point is a segment of no length."""
    segments = [np.zeros((0, 4))]
    for part in shapely.get_parts(shapely.get_parts(np.atleast_1d(shape))):
        for line in shapely.get_rings(part) if part.geom_type == "Polygon" else [part]:
            xy = shapely.get_coordinates(line)
            segments.append(np.hstack([xy[:-1], xy[1:]]) if len(xy) > 1 else np.hstack([xy, xy]))
    return np.ascontiguousarray(np.vstack(segments))
